//! A belief: the mean of a state and the covariance of its error.
//!
//! States are numbered, and a process defines what each number means. If the process estimates the
//! full attitude, the attitude is a quaternion beside the numbers, and three of the numbers are its
//! error (multiplicative: `q = q^ Exp(dtheta)`, dtheta along body axes; Solà 2017, ch. 5), which is
//! zero in the mean.
//!
//! `N` is the capacity of a belief; only the first `order` states exist, because some are optional.

use core::ops::{Index, IndexMut};

use nalgebra::{ArrayStorage, SMatrix, SVector};
use serde::{Deserialize, Serialize};

use super::kalman::Sequence;
use super::lanes::{correlate, factorize, reduce, weigh, with_length};
use super::transition::Transition;

/// A column of numbers, one for each state: a mean, a gain.
pub type Column<const N: usize> = SVector<f64, N>;

/// A row of a Jacobian: derivatives by the states, most of them zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row<const N: usize> {
    values: Column<N>,
    /// Bit i: the derivative by state i may be non-zero.
    support: u64,
}

impl<const N: usize> Row<N> {
    /// Three rows that depend on no state.
    pub(super) const NONE: [Self; 3] =
        [Self { values: Column::from_array_storage(ArrayStorage([[0.0; N]])), support: 0 }; 3];

    /// A row that depends on no state.
    #[must_use]
    pub fn zeros() -> Self {
        Self::NONE[0]
    }

    /// The states with non-zero derivatives, each with the derivative by it.
    #[inline(always)]
    pub fn iter(&self) -> impl Iterator<Item = (usize, f64)> {
        states_in(self.support).map(|state| (state, self.values[state]))
    }

    /// `h^T b`.
    #[must_use]
    #[inline(always)]
    pub fn dot(&self, b: &impl Index<usize, Output = f64>) -> f64 {
        self.iter().map(|(state, h)| h * b[state]).sum()
    }

    /// The full row, including zeros, as a column.
    #[must_use]
    pub fn dense(&self) -> &Column<N> {
        &self.values
    }
}

impl<const N: usize> Index<usize> for Row<N> {
    type Output = f64;

    fn index(&self, state: usize) -> &f64 {
        &self.values[state]
    }
}

impl<const N: usize> IndexMut<usize> for Row<N> {
    fn index_mut(&mut self, state: usize) -> &mut f64 {
        self.support |= 1 << state;
        &mut self.values[state]
    }
}

/// The states whose bits are set, in order.
#[inline(always)]
pub(super) fn states_in(mut set: u64) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let state = set.trailing_zeros() as usize;
        (set != 0).then(|| {
            set &= set - 1;
            state
        })
    })
}

/// Variances stop growing here: the state is unknown anyway, and all arithmetic stays finite.
const VARIANCE_LIMIT: f64 = 1e12;
/// Below this ratio of measurement noise to predicted variance, cancellation would lose the digits
/// of the short update, so Joseph's form is used.
const ILL_CONDITIONED: f64 = 1e-6;

/// A scalar measurement that was fused: its row h of derivatives, the variance R of its noise, the gain
/// `K = P h / S`, and the variance S of its innovation.
pub(super) struct Update<'a, const N: usize> {
    pub(super) row: &'a Row<N>,
    pub(super) noise: f64,
    pub(super) gain: &'a Column<N>,
    pub(super) s: f64,
}

/// Mean and covariance.
// Aligned because a vector across two cache lines takes twice the time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[repr(C, align(64))]
pub struct Belief<const N: usize> {
    /// Covariance of the error, symmetric.
    pub covariance: SMatrix<f64, N, N>,
    /// Mean of each state, in the units of the process.
    pub mean: Column<N>,
    /// Attitude from body to NED, `[w, x, y, z]`; used by processes that estimate the full
    /// attitude.
    pub attitude: [f64; 4],
    order: usize,
}

impl<const N: usize> Belief<N> {
    /// Independent states with the given means and standard deviations.
    #[must_use]
    pub fn new(order: usize, mean: Column<N>, sigma: &Column<N>, attitude: [f64; 4]) -> Self {
        let covariance = SMatrix::from_diagonal(&sigma.component_mul(sigma));
        Self { mean, attitude, covariance, order: order.min(N) }
    }

    /// How many states exist.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// `P <- F P F^T`, then the process noise is added by the caller.
    pub fn propagate(&mut self, f: &Transition<N>) {
        f.propagate(&mut self.covariance, self.order);
    }

    /// Adds independent noise to a state.
    pub fn add_noise(&mut self, state: usize, variance: f64) {
        self.covariance[(state, state)] += variance;
    }

    /// `P h`.
    #[must_use]
    pub fn correlate(&self, row: &Row<N>) -> Column<N> {
        let mut sum = Column::zeros();
        self.correlate_all(core::slice::from_ref(row), core::slice::from_mut(&mut sum));
        sum
    }

    /// `P h` of several rows; the output must be zero before.
    pub(super) fn correlate_all(&self, rows: &[Row<N>], into: &mut [Column<N>]) {
        with_length!(self.order, N, correlate(&self.covariance.data.0, rows, into));
    }

    /// The gains of a measurement's components from their correlations, which they replace, and the
    /// resulting correction of the states, which must be zero before.
    pub(super) fn weigh(
        &self,
        correlations: &mut [Column<N>; 3],
        size: usize,
        sequence: &Sequence,
        correction: &mut Column<N>,
    ) {
        let correlations = &mut correlations[..size];
        with_length!(self.order, N, weigh(correlations, sequence, correction));
    }

    /// The covariance after updates with `K` scalar measurements, one after the other.
    ///
    /// `P - K S K^T`, or, where that would cancel, Joseph's
    /// `(I - K h^T) P (I - K h^T)^T + K R K^T`.
    pub(super) fn condense<const K: usize>(&mut self, updates: &[Update<'_, N>; K]) {
        if updates.iter().any(|u| u.noise < ILL_CONDITIONED * u.s) {
            return updates.iter().for_each(|u| self.condense_by_joseph(u));
        }
        let gains = updates.each_ref().map(|u| (u.gain, u.s));
        let states = (1 << self.order) - 1;
        with_length!(self.order, N, reduce::<K>(&mut self.covariance.data.0, states, &gains));
    }

    fn condense_by_joseph(&mut self, &Update { row, noise, gain, s }: &Update<'_, N>) {
        let correlation = gain * s;
        let reduced = self.covariance - gain * correlation.transpose();
        let rest = reduced * row.dense();
        let joseph = reduced - rest * gain.transpose() + gain * gain.transpose() * noise;
        self.covariance = (joseph + joseph.transpose()) * 0.5;
    }

    /// Adds the product of a column with itself to the covariance.
    pub fn widen(&mut self, direction: &Column<N>) {
        self.covariance += direction * direction.transpose();
    }

    /// Removes a state's correlations with the others and sets its variance.
    pub fn decouple(&mut self, state: usize, variance: f64) {
        for j in 0..self.order {
            self.covariance[(state, j)] = 0.0;
            self.covariance[(j, state)] = 0.0;
        }
        self.covariance[(state, state)] = variance;
    }

    /// Keeps the covariance within what the arithmetic can handle: variances neither negative nor
    /// too large, and a matrix that rounding made indefinite is restored by increasing its
    /// diagonal.
    ///
    /// If a variance was out of range, returns the factors on the errors.
    pub fn confine(&mut self) -> Option<Transition<N>> {
        let sound = 0.0..=VARIANCE_LIMIT;
        if (0..self.order).all(|i| sound.contains(&self.covariance[(i, i)])) {
            return None;
        }
        let mut factors = None;
        let mut limited = false;
        for i in 0..self.order {
            let variance = self.covariance[(i, i)];
            if variance < 0.0 {
                self.decouple(i, 0.0);
                factors.get_or_insert_with(Transition::identity).scale(i, 0.0);
            }
            if variance > VARIANCE_LIMIT {
                limited = true;
                let scale = (VARIANCE_LIMIT / variance).sqrt();
                for j in 0..self.order {
                    self.covariance[(i, j)] *= scale;
                    self.covariance[(j, i)] *= scale;
                }
                factors.get_or_insert_with(Transition::identity).scale(i, scale);
            }
        }
        if limited {
            self.restore_positive();
        }
        factors
    }

    /// Increases the diagonal of a covariance that rounding made indefinite until it is positive
    /// definite.
    pub fn restore_positive(&mut self) {
        let mut share = 1e-9;
        while share < 1.0 && !self.is_positive() {
            for i in 0..self.order {
                let variance = self.covariance[(i, i)].max(1e-12);
                self.covariance[(i, i)] = variance * (1.0 + share);
            }
            share *= 10.0;
        }
    }

    /// Whether the covariance is positive definite, except for exactly known states.
    ///
    /// Cholesky's pivots of the correlation matrix may not be negative by more than rounding.
    #[must_use]
    pub fn is_positive(&self) -> bool {
        let mut positive = true;
        with_length!(self.order, N, factorize(&self.covariance.data.0, &mut positive));
        positive
    }

    /// Whether means and variances are numbers; a NaN anywhere spreads to these with any
    /// measurement.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        (0..self.order).all(|i| self.mean[i].is_finite() && self.covariance[(i, i)].is_finite())
            && self.attitude.iter().all(|x| x.is_finite())
    }
}
