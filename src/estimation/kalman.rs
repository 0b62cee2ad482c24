//! The Kalman update: components of a measurement one after the other, with bounded influence.
//!
//! A measurement whose normalised innovation squared (NIS) passes the gate is not thrown away; its
//! noise is taken for so large that the NIS is at the gate. Its pull then falls with its distance,
//! a filter that has gone astray still comes back, and no good measurement is lost near the gate.
//! Bar-Shalom, Li & Kirubarajan (2001) ch. 5.4 for the NIS, Huber (1981) for bounded influence.

use nalgebra::{Matrix3, Vector3};

use super::belief::{Belief, Column, Scalar, dot};
use super::sensor::Observation;
use super::transition::Transition;

/// Looks on while a belief changes: detection banks, smoothers.
pub trait Witness<const N: usize> {
    /// The errors of the states were propagated by F, and got noise of covariance Q.
    fn predicted(&mut self, f: &Transition<N>) {
        let _ = f;
    }

    /// A scalar measurement was fused.
    fn updated(&mut self, row: &Column<N>, gain: &Column<N>, innovation: f64, s: f64) {
        let _ = (row, gain, innovation, s);
    }

    /// The newest scalar measurements were taken back.
    fn taken_back(&mut self, count: usize) {
        let _ = count;
    }

    /// At one instant the errors of the states became F times what they were, plus noise: some
    /// states were given up.
    fn given_up(&mut self, f: &Transition<N>) {
        let _ = f;
    }
}

impl<const N: usize> Witness<N> for () {}

/// What became of a measurement.
#[derive(Clone, Copy, Debug)]
pub struct Fused<const N: usize> {
    /// Correction of the states; the process applies it to its mean.
    pub correction: Column<N>,
    /// Standard deviations of the innovation as predicted, before any limit.
    pub sigma: [f64; 3],
    /// Normalised innovation squared, before any limit.
    pub nis: f64,
    /// Whether its influence was limited.
    pub limited: bool,
}

/// Quantiles of the chi-square distribution at 99.9 % for one, two and three degrees of freedom.
pub const GATE: [f64; 3] = [10.83, 13.82, 16.27];

/// Fuses an observation; `gate` bounds its NIS, infinity lets everything in.
pub fn fuse<const N: usize>(
    belief: &mut Belief<N>,
    observation: &Observation<N>,
    gate: f64,
    witness: &mut impl Witness<N>,
) -> Fused<N> {
    let (nis, inflation, sigma) = judge(belief, observation, gate);
    let mut correction = Column::zeros();
    for i in 0..observation.size {
        let row = &observation.rows[i];
        let innovation = observation.innovation[i] - dot(row, &correction, belief.order());
        let variance = observation.variance[i] * inflation;
        let scalar = Scalar { innovation, row, variance };
        let (gain, s) = belief.gain(&scalar);
        belief.condense(&scalar, &gain, s);
        correction += gain * innovation;
        witness.updated(row, &gain, innovation, s);
    }
    Fused { correction, sigma, nis, limited: inflation > 1.0 }
}

/// The NIS, and the factor on the noise that brings it down to the gate.
fn judge<const N: usize>(
    belief: &Belief<N>,
    observation: &Observation<N>,
    gate: f64,
) -> (f64, f64, [f64; 3]) {
    let n = observation.size;
    // Components that do not exist: unit variance, no innovation.
    let mut predicted = Matrix3::zeros();
    let mut noise = Vector3::repeat(1.0);
    let mut innovation = Vector3::zeros();
    for i in 0..n {
        let correlation = belief.correlate(&observation.rows[i]);
        for j in i..n {
            let covariance = dot(&observation.rows[j], &correlation, belief.order());
            predicted[(i, j)] = covariance;
            predicted[(j, i)] = covariance;
        }
        noise[i] = observation.variance[i];
        innovation[i] = observation.innovation[i];
    }
    let nis = |factor: f64| quadratic(&(predicted + Matrix3::from_diagonal(&(noise * factor))), &innovation);
    let sigma = core::array::from_fn(|i| {
        if i < n { (predicted[(i, i)] + noise[i]).sqrt() } else { 0.0 }
    });
    let plain = nis(1.0);
    if plain <= gate {
        return (plain, 1.0, sigma);
    }
    // The NIS falls with the factor; without predicted variance it would be plain / factor.
    let (mut low, mut high) = (1.0, plain / gate);
    while nis(high) > gate && high < 1e30 {
        high *= 4.0;
    }
    for _ in 0..30 {
        let middle = (low * high).sqrt();
        if nis(middle) > gate { low = middle } else { high = middle }
    }
    (plain, high, sigma)
}

/// `y^T S^-1 y`; infinite if S is not positive definite.
fn quadratic(s: &Matrix3<f64>, y: &Vector3<f64>) -> f64 {
    match s.cholesky() {
        Some(factor) => y.dot(&factor.solve(y)),
        None => f64::INFINITY,
    }
}
