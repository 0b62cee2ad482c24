//! One step of an explicit Runge-Kutta method.

use crate::{RootMeanSquare, Tableau};

/// The stages of a method. [`RungeKutta::begin`] fixes the start of the step, then any number of
/// [`RungeKutta::attempt`]s go from there with steps of different length.
#[derive(Clone, Debug)]
pub struct RungeKutta {
    tableau: &'static Tableau,
    time: f64,
    begin: Vec<f64>,
    stages: Vec<Vec<f64>>,
    trial: Vec<f64>,
}

impl RungeKutta {
    /// For this number of states.
    #[must_use]
    pub fn new(tableau: &'static Tableau, states: usize) -> Self {
        let stages = vec![vec![0.0; states]; tableau.result.len()];
        Self { tableau, time: 0.0, begin: vec![0.0; states], stages, trial: vec![0.0; states] }
    }

    /// Begins a step at (`time`, `states`).
    ///
    /// # Errors
    /// Those of `f`, the right-hand side of x' = f(t, x).
    pub fn begin<E>(
        &mut self,
        time: f64,
        states: &[f64],
        f: &mut impl FnMut(f64, &[f64], &mut [f64]) -> Result<(), E>,
    ) -> Result<(), E> {
        self.time = time;
        self.begin.copy_from_slice(states);
        f(time, states, &mut self.stages[0])
    }

    /// The derivatives at the start.
    #[must_use]
    pub fn slope(&self) -> &[f64] {
        &self.stages[0]
    }

    /// The states after a step of length `h`, into `end`.
    ///
    /// # Errors
    /// Those of `f`.
    pub fn attempt<E>(
        &mut self,
        h: f64,
        end: &mut [f64],
        f: &mut impl FnMut(f64, &[f64], &mut [f64]) -> Result<(), E>,
    ) -> Result<(), E> {
        let tableau = self.tableau;
        for (row, weights) in tableau.stages.iter().enumerate() {
            let (known, unknown) = self.stages.split_at_mut(row + 1);
            combine(&mut self.trial, &self.begin, h, weights, known);
            f(self.time + tableau.nodes[row] * h, &self.trial, &mut unknown[0])?;
        }
        combine(end, &self.begin, h, tableau.result, &self.stages);
        Ok(())
    }

    /// The estimated error of the last attempt: root mean square of the components over
    /// `scale(i)`; 0 for a method without an estimate.
    #[must_use]
    pub fn error(&self, h: f64, scale: impl Fn(usize) -> f64) -> f64 {
        let weights = self.tableau.error;
        let mut norm = RootMeanSquare::default();
        for i in (0..self.begin.len()).filter(|_| !weights.is_empty()) {
            let sum: f64 = weights.iter().zip(&self.stages).map(|(w, stage)| w * stage[i]).sum();
            norm.add(h * sum / scale(i));
        }
        norm.value()
    }

    /// Whether the method estimates its error.
    #[must_use]
    pub fn adaptive(&self) -> bool {
        !self.tableau.error.is_empty()
    }
}

/// `target = begin + h * sum of weights * stages`.
fn combine(target: &mut [f64], begin: &[f64], h: f64, weights: &[f64], stages: &[Vec<f64>]) {
    for (i, (target, begin)) in target.iter_mut().zip(begin).enumerate() {
        let sum: f64 = weights.iter().zip(stages).map(|(w, stage)| w * stage[i]).sum();
        *target = begin + h * sum;
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;
    use crate::{CLASSICAL, DORMAND_PRINCE};

    /// Error at t = 1 of x' = -2 t x^2, x(0) = 1, in `steps` steps; x = 1 / (1 + t^2).
    fn global_error(method: &'static Tableau, steps: u32) -> f64 {
        let mut rk = RungeKutta::new(method, 1);
        let (mut x, mut end) = ([1.0], [0.0]);
        let h = 1.0 / f64::from(steps);
        let mut f = |t: f64, x: &[f64], dx: &mut [f64]| {
            dx[0] = -2.0 * t * x[0] * x[0];
            Ok::<_, Infallible>(())
        };
        for step in 0..steps {
            rk.begin(f64::from(step) * h, &x, &mut f).unwrap();
            rk.attempt(h, &mut end, &mut f).unwrap();
            x = end;
        }
        (x[0] - 0.5).abs()
    }

    #[test]
    fn orders_of_convergence() {
        for (method, order) in [(&CLASSICAL, 4.0), (&DORMAND_PRINCE, 5.0)] {
            let slope = (global_error(method, 16) / global_error(method, 32)).log2();
            assert!((slope - order).abs() < 0.3, "{method:?}: {slope}");
        }
    }

    #[test]
    fn the_error_estimate_is_of_order_five() {
        let estimate = |h: f64| {
            let mut rk = RungeKutta::new(&DORMAND_PRINCE, 1);
            let mut f = |_: f64, x: &[f64], dx: &mut [f64]| {
                dx[0] = x[0];
                Ok::<_, Infallible>(())
            };
            rk.begin(0.0, &[1.0], &mut f).unwrap();
            rk.attempt(h, &mut [0.0], &mut f).unwrap();
            rk.error(h, |_| 1.0)
        };
        let slope = (estimate(0.2) / estimate(0.1)).log2();
        assert!((slope - 5.0).abs() < 0.3, "{slope}");
    }
}
