//! A belief: the mean of a state and the covariance of its error.
//!
//! States are numbered; a process says what each number means. Its attitude, if it estimates all of
//! it, is a quaternion beside the numbers, and three of the numbers are the error of that attitude
//! (multiplicative: `q = q^ Exp(dtheta)`, dtheta along body axes; Solà 2017, ch. 5), zero in the mean.
//!
//! `N` is what a belief has room for; only the first `order` states exist, because some are optional.

use core::ops::{Index, IndexMut};

use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

use super::transition::Transition;

/// A column of numbers, one for each state: a mean, a gain.
pub type Column<const N: usize> = SVector<f64, N>;

/// A row of a Jacobian: derivatives by the states, most of which are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row<const N: usize> {
    values: Column<N>,
    /// Bit i: the derivative by state i may be other than zero.
    support: u64,
}

impl<const N: usize> Row<N> {
    /// Nothing depends on any state.
    #[must_use]
    pub fn zeros() -> Self {
        Self { values: Column::zeros(), support: 0 }
    }

    /// The states that matter, each with the derivative by it.
    pub fn iter(&self) -> impl Iterator<Item = (usize, f64)> {
        let mut rest = self.support;
        core::iter::from_fn(move || {
            let state = rest.trailing_zeros() as usize;
            rest &= rest.wrapping_sub(1);
            self.values.as_slice().get(state).map(|&value| (state, value))
        })
    }

    /// `h^T b`.
    #[must_use]
    pub fn dot(&self, b: &Column<N>) -> f64 {
        self.iter().map(|(state, h)| h * b[state]).sum()
    }

    /// The row with all its zeros, as a column.
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

/// Variances stop growing here: the state is unknown anyway, and all arithmetic stays finite.
const VARIANCE_LIMIT: f64 = 1e12;
/// Below this ratio of measurement noise to predicted variance, cancellation would eat the digits of
/// the short update, and Joseph's form is used.
const ILL_CONDITIONED: f64 = 1e-6;

/// Mean and covariance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Belief<const N: usize> {
    /// Mean of each state, in the units of the process.
    pub mean: Column<N>,
    /// Attitude from body to NED, `[w, x, y, z]`; used by processes that estimate all of it.
    pub attitude: [f64; 4],
    /// Covariance of the error, symmetric.
    pub covariance: SMatrix<f64, N, N>,
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
        let mut sum: Column<N> = Column::zeros();
        for (state, h) in row.iter() {
            let column = &self.covariance.as_slice()[state * N..(state + 1) * N];
            add_scaled(sum.as_mut_slice(), h, column);
        }
        sum
    }

    /// The covariance after an update with a scalar measurement: its row h of derivatives, the variance
    /// R of its noise, the gain `K = P h / S` and the variance S of its innovation.
    ///
    /// `P - K S K^T`, or where that would cancel, Joseph's `(I - K h^T) P (I - K h^T)^T + K R K^T`.
    pub fn condense(&mut self, row: &Row<N>, noise: f64, gain: &Column<N>, s: f64) {
        if noise < ILL_CONDITIONED * s {
            return self.condense_by_joseph(row, noise, gain, s);
        }
        // With g = K sqrt(S), g_i g_j is the same for (i, j) and (j, i): symmetry is exact.
        let g = gain * s.sqrt();
        let g = &g.as_slice()[..self.order];
        for (column, &own) in self.covariance.as_mut_slice().chunks_exact_mut(N).zip(g) {
            if own != 0.0 {
                for (p, other) in column.iter_mut().zip(g) {
                    *p -= own * other;
                }
            }
        }
    }

    fn condense_by_joseph(&mut self, row: &Row<N>, noise: f64, gain: &Column<N>, s: f64) {
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

    /// Variance of a linear combination of states.
    #[must_use]
    pub fn variance(&self, row: &Row<N>) -> f64 {
        row.dot(&self.correlate(row))
    }

    /// Forgets what a state has to do with the others and gives it a variance.
    pub fn decouple(&mut self, state: usize, variance: f64) {
        for j in 0..self.order {
            self.covariance[(state, j)] = 0.0;
            self.covariance[(j, state)] = 0.0;
        }
        self.covariance[(state, state)] = variance;
    }

    /// Keeps the covariance within what arithmetic can bear: variances neither negative nor beyond
    /// all use, and a matrix that rounding made indefinite is brought back by widening it.
    ///
    /// Where a variance was either, gives the factors on the errors.
    pub fn confine(&mut self) -> Option<Transition<N>> {
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

    /// Widens a covariance that rounding made indefinite until it is not.
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

    /// Whether the covariance is positive definite, up to states that are known exactly.
    ///
    /// Cholesky's pivots of the correlation matrix may not be negative by more than rounding.
    #[must_use]
    pub fn is_positive(&self) -> bool {
        let n = self.order;
        let scale: Column<N> = Column::from_fn(|i, _| {
            let variance = if i < n { self.covariance[(i, i)] } else { 0.0 };
            if variance > 0.0 { 1.0 / variance.sqrt() } else { 0.0 }
        });
        let mut l = SMatrix::<f64, N, N>::zeros();
        for j in 0..n {
            let mut column = self.covariance.column(j).component_mul(&scale) * scale[j];
            let column = &mut column.as_mut_slice()[j..n];
            for earlier in l.as_slice().chunks_exact(N).take(j) {
                add_scaled(column, -earlier[j], &earlier[j..n]);
            }
            let pivot = column[0];
            if pivot.is_nan() || pivot < -1e-9 || self.covariance[(j, j)] < 0.0 {
                return false;
            }
            let root = pivot.max(0.0).sqrt();
            if root > 1e-7 {
                let place = &mut l.as_mut_slice()[j * N..][j..n];
                place.iter_mut().zip(column).for_each(|(l, value)| *l = *value / root);
            }
        }
        true
    }

    /// Whether means and variances are numbers; what is not spreads to these with any measurement.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        (0..self.order).all(|i| self.mean[i].is_finite() && self.covariance[(i, i)].is_finite())
            && self.attitude.iter().all(|x| x.is_finite())
    }
}

/// `sum += factor * column`.
#[inline]
pub(super) fn add_scaled(sum: &mut [f64], factor: f64, column: &[f64]) {
    for (s, value) in sum.iter_mut().zip(column) {
        *s += factor * value;
    }
}
