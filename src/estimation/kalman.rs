//! The Kalman update: components of a measurement one after the other, with bounded influence.
//!
//! A measurement whose normalised innovation squared (NIS) exceeds the gate is not discarded; its
//! noise is increased until the NIS is at the gate. Its pull then decreases with its distance, a
//! filter that has gone astray still recovers, and no good measurement is lost near the gate.
//! Bar-Shalom, Li & Kirubarajan (2001) ch. 5.4 for the NIS, Huber (1981) for bounded influence.

use nalgebra::Matrix3;

use super::belief::{Belief, Column, Row, Update};
use super::interval::Interval;
use super::sensor::Observation;
use super::transition::Transition;

/// Observes changes of a belief: detection banks, smoothers.
pub trait Witness<const N: usize> {
    /// The errors of the states were propagated by F, with added noise of covariance Q.
    fn predicted(&mut self, f: &Transition<N>) {
        let _ = f;
    }

    /// The prediction was driven by the signals of an interval.
    fn driven(&mut self, interval: &Interval) {
        let _ = interval;
    }

    /// The direct effect on the next fused measurement of the thrust that each thruster loses.
    fn direct(&mut self, effect: [f64; 8]) {
        let _ = effect;
    }

    /// A scalar measurement was fused.
    fn updated(&mut self, row: &Row<N>, gain: &Column<N>, innovation: f64, s: f64) {
        let _ = (row, gain, innovation, s);
    }

    /// At one instant the errors of the states became F times their value, plus noise: some states
    /// were discarded.
    fn given_up(&mut self, f: &Transition<N>) {
        let _ = f;
    }
}

impl<const N: usize> Witness<N> for () {}

/// Two observers.
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

/// A measurement's components in sequence: the additional information of each beyond those before
/// it.
///
/// With `S = L D L^T`, the covariance of the innovation y, the innovations `L^-1 y` are independent and
/// their variances are D.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sequence {
    /// L, below its diagonal of ones.
    pub(super) weights: [[f64; 3]; 3],
    /// `L^-1 y`.
    pub(super) innovation: [f64; 3],
    /// D, and its inverse.
    pub(super) variance: [f64; 3],
    pub(super) share: [f64; 3],
}

impl Sequence {
    /// For the first `size` components, where `predicted` is the contribution of the states to S;
    /// nothing if S is not positive definite.
    fn new<const N: usize>(
        predicted: &Matrix3<f64>,
        observation: &Observation<N>,
        inflation: f64,
    ) -> Option<Self> {
        let Self { mut weights, mut innovation, mut variance, mut share } = Self::default();
        for i in 0..observation.size {
            let mut own = predicted[(i, i)] + observation.variance[i] * inflation;
            let mut y = observation.innovation[i];
            for k in 0..i {
                let mut shared = predicted[(i, k)];
                (0..k).for_each(|j| shared -= weights[i][j] * weights[k][j] * variance[j]);
                weights[i][k] = shared * share[k];
                own -= weights[i][k] * shared;
                y -= weights[i][k] * innovation[k];
            }
            if own.is_nan() || own <= 0.0 {
                return None;
            }
            (innovation[i], variance[i], share[i]) = (y, own, 1.0 / own);
        }
        Some(Self { weights, innovation, variance, share })
    }

    /// `y^T S^-1 y`.
    fn nis(&self, size: usize) -> f64 {
        (0..size).map(|i| self.innovation[i] * self.innovation[i] * self.share[i]).sum()
    }
}

/// How a measurement fits its prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict<const N: usize> {
    /// `P h` of each component.
    correlations: [Column<N>; 3],
    /// The components as they are fused, with limited influence; nothing if they cannot be fused.
    sequence: Option<Sequence>,
    /// Standard deviations of the innovation as predicted, before any limit.
    pub sigma: [f64; 3],
    /// Normalised innovation squared, before any limit.
    pub nis: f64,
    /// Factor on the variance of the noise that brings the NIS down to the gate; 1 within it.
    pub inflation: f64,
}

impl<const N: usize> Verdict<N> {
    /// Not judged yet.
    pub(super) fn new() -> Self {
        Self {
            correlations: [Column::zeros(); 3],
            sequence: None,
            sigma: [0.0; 3],
            nis: f64::INFINITY,
            inflation: 1.0,
        }
    }

    /// Compares an observation with its prediction, once; `gate` bounds its NIS, infinity accepts
    /// everything.
    pub(super) fn judge(&mut self, belief: &Belief<N>, observation: &Observation<N>, gate: f64) {
        let n = observation.size;
        let correlations = &mut self.correlations;
        belief.correlate_all(&observation.rows[..n], correlations);
        let mut predicted = Matrix3::zeros();
        for i in 0..n {
            for j in 0..=i {
                predicted[(i, j)] = observation.rows[i].dot(&correlations[j]);
            }
            self.sigma[i] = (predicted[(i, i)] + observation.variance[i]).sqrt();
        }
        let sequence = |inflation: f64| Sequence::new(&predicted, observation, inflation);
        let nis = |sequence: &Option<Sequence>| {
            sequence.as_ref().map_or(f64::INFINITY, |sequence| sequence.nis(n))
        };
        self.sequence = sequence(1.0);
        self.nis = nis(&self.sequence);
        if self.nis.is_nan() || self.nis > gate {
            self.inflation = limit(self.nis, gate, |inflation| nis(&sequence(inflation)));
            self.sequence = sequence(self.inflation);
        }
    }

    /// Whether the influence of the measurement is limited.
    #[must_use]
    pub fn is_limited(&self) -> bool {
        self.inflation > 1.0
    }
}

/// Quantiles of the chi-square distribution at 99.9 % for one, two and three degrees of freedom.
pub const GATE: [f64; 3] = [10.83, 13.82, 16.27];

/// Evaluates and fuses an observation; returns the correction of the states, which the process
/// applies to its mean.
pub fn fuse<const N: usize>(
    belief: &mut Belief<N>,
    observation: &Observation<N>,
    gate: f64,
    witness: &mut impl Witness<N>,
) -> Column<N> {
    let mut verdict = Verdict::new();
    verdict.judge(belief, observation, gate);
    absorb(belief, observation, &mut verdict, witness)
}

/// Fuses an observation that has been evaluated; its correlations become gains. If its innovation
/// would have no variance, nothing changes.
pub(super) fn absorb<const N: usize>(
    belief: &mut Belief<N>,
    observation: &Observation<N>,
    verdict: &mut Verdict<N>,
    witness: &mut impl Witness<N>,
) -> Column<N> {
    let mut correction: Column<N> = Column::zeros();
    let Verdict { correlations: gains, sequence, inflation, .. } = verdict;
    let Some(sequence) = sequence else { return correction };
    belief.weigh(gains, observation.size, sequence, &mut correction);
    for i in 0..observation.size {
        let row = &observation.rows[i];
        witness.updated(row, &gains[i], sequence.innovation[i], sequence.variance[i]);
    }
    let update = |i: usize| Update {
        row: &observation.rows[i],
        noise: observation.variance[i] * *inflation,
        gain: &gains[i],
        s: sequence.variance[i],
    };
    match observation.size {
        1 => belief.condense(&[update(0)]),
        2 => belief.condense(&[update(0), update(1)]),
        _ => belief.condense(&[update(0), update(1), update(2)]),
    }
    correction
}

/// The factor on the noise that brings a NIS of `plain` down to the gate.
fn limit(plain: f64, gate: f64, nis: impl Fn(f64) -> f64) -> f64 {
    // The NIS decreases with the factor; without predicted variance it would be plain / factor.
    let (mut low, mut high) = (1.0, plain / gate);
    while nis(high) > gate && high < 1e30 {
        high *= 4.0;
    }
    for _ in 0..30 {
        let middle = (low * high).sqrt();
        if nis(middle) > gate { low = middle } else { high = middle }
    }
    high
}
