//! The Kalman update: components of a measurement one after the other, with bounded influence.
//!
//! A measurement whose normalised innovation squared (NIS) passes the gate is not thrown away; its
//! noise is taken for so large that the NIS is at the gate. Its pull then falls with its distance,
//! a filter that has gone astray still comes back, and no good measurement is lost near the gate.
//! Bar-Shalom, Li & Kirubarajan (2001) ch. 5.4 for the NIS, Huber (1981) for bounded influence.

use nalgebra::{Matrix3, Vector3};

use super::belief::{Belief, Column, Row, Update, add_scaled};
use super::interval::Interval;
use super::sensor::Observation;
use super::transition::Transition;

/// Looks on while a belief changes: detection banks, smoothers.
pub trait Witness<const N: usize> {
    /// The errors of the states were propagated by F, and got noise of covariance Q.
    fn predicted(&mut self, f: &Transition<N>) {
        let _ = f;
    }

    /// The prediction was driven by what an interval says.
    fn driven(&mut self, interval: &Interval) {
        let _ = interval;
    }

    /// The next measurement fused changes by this, directly, with the thrust that each thruster loses.
    fn direct(&mut self, effect: [f64; 8]) {
        let _ = effect;
    }

    /// A scalar measurement was fused.
    fn updated(&mut self, row: &Row<N>, gain: &Column<N>, innovation: f64, s: f64) {
        let _ = (row, gain, innovation, s);
    }

    /// At one instant the errors of the states became F times what they were, plus noise: some
    /// states were given up.
    fn given_up(&mut self, f: &Transition<N>) {
        let _ = f;
    }
}

impl<const N: usize> Witness<N> for () {}

/// Two look on.
pub struct Both<'a, A, B>(pub &'a mut A, pub &'a mut B);

impl<const N: usize, A: Witness<N>, B: Witness<N>> Witness<N> for Both<'_, A, B> {
    fn predicted(&mut self, f: &Transition<N>) {
        self.0.predicted(f);
        self.1.predicted(f);
    }

    fn driven(&mut self, interval: &Interval) {
        self.0.driven(interval);
        self.1.driven(interval);
    }

    fn direct(&mut self, effect: [f64; 8]) {
        self.0.direct(effect);
        self.1.direct(effect);
    }

    fn updated(&mut self, row: &Row<N>, gain: &Column<N>, innovation: f64, s: f64) {
        self.0.updated(row, gain, innovation, s);
        self.1.updated(row, gain, innovation, s);
    }

    fn given_up(&mut self, f: &Transition<N>) {
        self.0.given_up(f);
        self.1.given_up(f);
    }
}

/// How a measurement fits what was predicted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict<const N: usize> {
    /// `P h` of each component.
    correlations: [Column<N>; 3],
    /// Standard deviations of the innovation as predicted, before any limit.
    pub sigma: [f64; 3],
    /// Normalised innovation squared, before any limit.
    pub nis: f64,
    /// Factor on the variance of the noise that brings the NIS down to the gate; 1 within it.
    pub inflation: f64,
}

impl<const N: usize> Verdict<N> {
    /// Whether the influence of the measurement is limited.
    #[must_use]
    pub fn is_limited(&self) -> bool {
        self.inflation > 1.0
    }
}

/// Quantiles of the chi-square distribution at 99.9 % for one, two and three degrees of freedom.
pub const GATE: [f64; 3] = [10.83, 13.82, 16.27];

/// Judges and fuses an observation; gives the correction of the states, which the process applies to
/// its mean.
pub fn fuse<const N: usize>(
    belief: &mut Belief<N>,
    observation: &Observation<N>,
    gate: f64,
    witness: &mut impl Witness<N>,
) -> Column<N> {
    let verdict = judge(belief, observation, gate);
    absorb(belief, observation, verdict, witness)
}

/// Fuses an observation that has been judged.
pub fn absorb<const N: usize>(
    belief: &mut Belief<N>,
    observation: &Observation<N>,
    verdict: Verdict<N>,
    witness: &mut impl Witness<N>,
) -> Column<N> {
    let mut correction: Column<N> = Column::zeros();
    let Verdict { correlations: mut gains, inflation, .. } = verdict;
    let mut variances = [(0.0, 0.0); 3];
    for i in 0..observation.size {
        let row = &observation.rows[i];
        let noise = observation.variance[i] * inflation;
        // The covariance has lost K S K^T with each component before.
        let (before, rest) = gains.split_at_mut(i);
        let gain = &mut rest[0];
        for (earlier, (_, s)) in before.iter().zip(&variances) {
            add_scaled(gain.as_mut_slice(), -row.dot(earlier) * s, earlier.as_slice());
        }
        let innovation = observation.innovation[i] - row.dot(&correction);
        let s = row.dot(gain) + noise;
        *gain *= 1.0 / s;
        add_scaled(correction.as_mut_slice(), innovation, gain.as_slice());
        witness.updated(row, gain, innovation, s);
        variances[i] = (noise, s);
    }
    let update = |i: usize| {
        let (noise, s) = variances[i];
        Update { row: &observation.rows[i], noise, gain: &gains[i], s }
    };
    match observation.size {
        1 => belief.condense(&[update(0)]),
        2 => belief.condense(&[update(0), update(1)]),
        _ => belief.condense(&[update(0), update(1), update(2)]),
    }
    correction
}

/// Compares an observation with its prediction; `gate` bounds its NIS, infinity lets everything in.
pub fn judge<const N: usize>(
    belief: &Belief<N>,
    observation: &Observation<N>,
    gate: f64,
) -> Verdict<N> {
    let n = observation.size;
    // Components that do not exist: unit variance, no innovation.
    let mut predicted = Matrix3::zeros();
    let mut noise = Vector3::repeat(1.0);
    let mut innovation = Vector3::zeros();
    let mut correlations = [Column::zeros(); 3];
    belief.correlate_all(&observation.rows[..n], &mut correlations);
    for i in 0..n {
        for j in i..n {
            let covariance = observation.rows[j].dot(&correlations[i]);
            predicted[(i, j)] = covariance;
            predicted[(j, i)] = covariance;
        }
        noise[i] = observation.variance[i];
        innovation[i] = observation.innovation[i];
    }
    if n == 1 {
        let (sigma, nis, inflation) = judge_scalar(predicted[(0, 0)], noise.x, innovation.x, gate);
        return Verdict { correlations, sigma: [sigma, 0.0, 0.0], nis, inflation };
    }
    let nis = |factor: f64| {
        quadratic(&(predicted + Matrix3::from_diagonal(&(noise * factor))), &innovation)
    };
    let sigma =
        core::array::from_fn(|i| if i < n { (predicted[(i, i)] + noise[i]).sqrt() } else { 0.0 });
    let plain = nis(1.0);
    if plain <= gate {
        return Verdict { correlations, sigma, nis: plain, inflation: 1.0 };
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
    Verdict { correlations, sigma, nis: plain, inflation: high }
}

fn judge_scalar(predicted: f64, noise: f64, innovation: f64, gate: f64) -> (f64, f64, f64) {
    let s = predicted + noise;
    let nis = innovation * innovation / s;
    // S at which the NIS is at the gate, less what is predicted.
    let limited = (innovation * innovation / gate - predicted) / noise;
    let inflation = if nis > gate { limited.max(1.0) } else { 1.0 };
    (s.sqrt(), nis, inflation)
}

/// `y^T S^-1 y`; infinite if S is not positive definite.
fn quadratic(s: &Matrix3<f64>, y: &Vector3<f64>) -> f64 {
    let (mut s, mut y, mut sum) = (*s, *y, 0.0);
    for i in 0..3 {
        let pivot = s[(i, i)];
        if pivot.is_nan() || pivot <= 0.0 {
            return f64::INFINITY;
        }
        sum += y[i] * y[i] / pivot;
        for j in i + 1..3 {
            let factor = s[(j, i)] / pivot;
            y[j] -= factor * y[i];
            (i + 1..=j).for_each(|k| s[(j, k)] -= factor * s[(k, i)]);
        }
    }
    sum
}
