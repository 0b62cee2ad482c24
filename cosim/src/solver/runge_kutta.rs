//! One step of an explicit Runge-Kutta method.
//!
//! Tableaux: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.1 (the
//! classical method) and table II.5.2 (Dormand and Prince, 5(4)).

use super::Method;
use crate::error::Result;

struct Tableau {
    /// Rows of the stages after the first.
    a: &'static [&'static [f64]],
    b: &'static [f64],
    c: &'static [f64],
    /// `b` minus the weights of the embedded method; empty without one.
    error: &'static [f64],
}

const CLASSICAL: Tableau = Tableau {
    a: &[&[0.5], &[0.0, 0.5], &[0.0, 0.0, 1.0]],
    b: &[1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0],
    c: &[0.5, 0.5, 1.0],
    error: &[],
};

const DORMAND_PRINCE: Tableau = Tableau {
    a: &[
        &[1.0 / 5.0],
        &[3.0 / 40.0, 9.0 / 40.0],
        &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
        &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
        &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
        &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
    ],
    b: &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0, 0.0],
    c: &[0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0],
    error: &[
        71.0 / 57600.0,
        0.0,
        -71.0 / 16695.0,
        71.0 / 1920.0,
        -17253.0 / 339_200.0,
        22.0 / 525.0,
        -1.0 / 40.0,
    ],
};

/// The right-hand side of x' = f(t, x).
pub(crate) type Derivatives<'a> = dyn FnMut(f64, &[f64], &mut [f64]) -> Result<()> + 'a;

/// The stages of a method. [`RungeKutta::begin`] fixes the start of the step, then any number of
/// [`RungeKutta::attempt`]s go from there with steps of different length.
#[derive(Clone)]
pub(crate) struct RungeKutta {
    method: Method,
    time: f64,
    begin: Vec<f64>,
    stages: Vec<Vec<f64>>,
    trial: Vec<f64>,
}

impl RungeKutta {
    pub(crate) fn new(method: Method, states: usize) -> Self {
        let stages = vec![vec![0.0; states]; tableau(method).b.len()];
        Self { method, time: 0.0, begin: vec![0.0; states], stages, trial: vec![0.0; states] }
    }

    /// Begins a step at (`time`, `states`).
    pub(crate) fn begin(&mut self, time: f64, states: &[f64], f: &mut Derivatives) -> Result<()> {
        self.time = time;
        self.begin.copy_from_slice(states);
        f(time, states, &mut self.stages[0])
    }

    /// The derivatives at the start.
    pub(crate) fn slope(&self) -> &[f64] {
        &self.stages[0]
    }

    /// The states after a step of length `h`, into `end`.
    pub(crate) fn attempt(&mut self, h: f64, end: &mut [f64], f: &mut Derivatives) -> Result<()> {
        let tableau = tableau(self.method);
        for (row, weights) in tableau.a.iter().enumerate() {
            let (known, unknown) = self.stages.split_at_mut(row + 1);
            combine(&mut self.trial, &self.begin, h, weights, known);
            f(self.time + tableau.c[row] * h, &self.trial, &mut unknown[0])?;
        }
        combine(end, &self.begin, h, tableau.b, &self.stages);
        Ok(())
    }

    /// The estimated error of the last attempt: root mean square of the components over
    /// `scale(i)`; 0 for a method without an estimate.
    pub(crate) fn error(&self, h: f64, scale: impl Fn(usize) -> f64) -> f64 {
        let weights = tableau(self.method).error;
        if weights.is_empty() || self.begin.is_empty() {
            return 0.0;
        }
        let squares = (0..self.begin.len()).map(|i| {
            let sum: f64 = weights.iter().zip(&self.stages).map(|(w, stage)| w * stage[i]).sum();
            let part = h * sum / scale(i);
            part * part
        });
        (squares.sum::<f64>() / self.begin.len() as f64).sqrt()
    }

    /// Whether the method estimates its error.
    pub(crate) fn adaptive(&self) -> bool {
        !tableau(self.method).error.is_empty()
    }
}

fn tableau(method: Method) -> &'static Tableau {
    match method {
        Method::RungeKutta4 => &CLASSICAL,
        Method::DormandPrince => &DORMAND_PRINCE,
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
    use super::*;

    /// Error at t = 1 of x' = -2 t x^2, x(0) = 1, in `steps` steps; x = 1 / (1 + t^2).
    fn global_error(method: Method, steps: u32) -> f64 {
        let mut rk = RungeKutta::new(method, 1);
        let (mut x, mut end) = ([1.0], [0.0]);
        let h = 1.0 / f64::from(steps);
        let mut f = |t: f64, x: &[f64], dx: &mut [f64]| {
            dx[0] = -2.0 * t * x[0] * x[0];
            Ok(())
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
        for (method, order) in [(Method::RungeKutta4, 4.0), (Method::DormandPrince, 5.0)] {
            let slope = (global_error(method, 16) / global_error(method, 32)).log2();
            assert!((slope - order).abs() < 0.3, "{method:?}: {slope}");
        }
    }

    #[test]
    fn the_error_estimate_is_of_order_five() {
        let estimate = |h: f64| {
            let mut rk = RungeKutta::new(Method::DormandPrince, 1);
            let mut f = |_: f64, x: &[f64], dx: &mut [f64]| {
                dx[0] = x[0];
                Ok(())
            };
            rk.begin(0.0, &[1.0], &mut f).unwrap();
            rk.attempt(h, &mut [0.0], &mut f).unwrap();
            rk.error(h, |_| 1.0)
        };
        let slope = (estimate(0.2) / estimate(0.1)).log2();
        assert!((slope - 5.0).abs() < 0.3, "{slope}");
    }
}
