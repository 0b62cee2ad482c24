//! A solver for `fmi-rs`, which only has Euler's: classical Runge-Kutta steps that end where
//! requested, including time events between the output points.
//!
//! A state event ends a step just after the sign change of an indicator, found by bisection. At the
//! start it compares the Jacobian, if there is one, with central differences.

use fmi_rs::sim::SimulationError;
use fmi_rs::sim::solver::{Dae, Ode, Solver, SolverFactory};

pub(crate) struct RungeKutta;

impl SolverFactory for RungeKutta {
    fn create<'a, O: Ode + 'a, D: Dae + 'a>(
        &self,
        start: f64,
        _tolerance: f64,
        ode: O,
        _dae: Option<D>,
    ) -> Result<Box<dyn Solver + 'a>, SimulationError> {
        let mut solver = Running { time: start, x: vec![0.0; ode.nx()], ode };
        solver.reset(start)?;
        if solver.ode.supports_jacobian() {
            solver.compare_jacobian()?;
        }
        Ok(Box::new(solver))
    }
}

struct Running<O> {
    time: f64,
    x: Vec<f64>,
    ode: O,
}

impl<O: Ode> Running<O> {
    fn slope(&self, time: f64, x: &[f64]) -> Result<Vec<f64>, SimulationError> {
        let mut slope = vec![0.0; x.len()];
        self.ode.f(time, x, &mut slope)?;
        Ok(slope)
    }

    fn signs(&self, time: f64, x: &[f64]) -> Result<Vec<bool>, SimulationError> {
        let mut indicators = vec![0.0; self.ode.nz()];
        self.ode.g(time, x, &mut indicators)?;
        Ok(indicators.iter().map(|indicator| *indicator > 0.0).collect())
    }

    /// The states at `next`, one step further.
    fn moved(&self, next: f64) -> Result<Vec<f64>, SimulationError> {
        let (t, h) = (self.time, next - self.time);
        let ahead = |k: &[f64], by: f64| -> Vec<f64> {
            self.x.iter().zip(k).map(|(x, k)| x + by * k).collect()
        };
        let k1 = self.slope(t, &self.x)?;
        let k2 = self.slope(t + 0.5 * h, &ahead(&k1, 0.5 * h))?;
        let k3 = self.slope(t + 0.5 * h, &ahead(&k2, 0.5 * h))?;
        let k4 = self.slope(next, &ahead(&k3, h))?;
        let end = |i: usize, x: &f64| x + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
        Ok(self.x.iter().enumerate().map(|(i, x)| end(i, x)).collect())
    }

    fn compare_jacobian(&self) -> Result<(), SimulationError> {
        let n = self.x.len();
        let mut jacobian = vec![0.0; n * n];
        self.ode.jacobian(self.time, &self.x, &mut jacobian)?;
        for (column, found) in jacobian.chunks(n).enumerate() {
            let step = 1e-6 * self.x[column].abs().max(1.0);
            let moved = |by: f64| {
                let mut x = self.x.clone();
                x[column] += by;
                self.slope(self.time, &x)
            };
            let (up, down) = (moved(step)?, moved(-step)?);
            for row in 0..n {
                let expected = (up[row] - down[row]) / (2.0 * step);
                if (found[row] - expected).abs() > 1e-5 * expected.abs().max(1.0) {
                    return Err(SimulationError::Solver(format!(
                        "d der({row}) / d x({column}) is {} instead of {expected}",
                        found[row]
                    )));
                }
            }
        }
        Ok(())
    }
}

impl<O: Ode> Solver for Running<O> {
    fn reset(&mut self, time: f64) -> Result<(), SimulationError> {
        self.time = time;
        let mut nominals = vec![0.0; self.x.len()];
        self.ode.init(&mut self.x, &mut nominals)?;
        if nominals.iter().all(|nominal| *nominal > 0.0) {
            return Ok(());
        }
        Err(SimulationError::Solver(format!("nominal values of the states: {nominals:?}")))
    }

    fn step(&mut self, next: f64) -> Result<(f64, &[f64], bool), SimulationError> {
        let begin = self.signs(self.time, &self.x)?;
        let (mut before, mut end) = (self.time, next);
        let mut x = self.moved(end)?;
        let event = self.signs(end, &x)? != begin;
        while event && end - before > 1e-9 {
            let middle = 0.5 * (before + end);
            let there = self.moved(middle)?;
            if self.signs(middle, &there)? == begin {
                before = middle;
            } else {
                (end, x) = (middle, there);
            }
        }
        (self.time, self.x) = (end, x);
        Ok((end, &self.x, event))
    }
}
