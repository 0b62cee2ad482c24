//! A belief: the mean of a state and the covariance of its error.
//!
//! States are numbered; a process says what each number means. Its attitude, if it estimates all of
//! it, is a quaternion beside the numbers, and three of the numbers are the error of that attitude
//! (multiplicative: `q = q^ Exp(dtheta)`, dtheta along body axes; Solà 2017, ch. 5), zero in the mean.
//!
//! `N` is what a belief has room for; only the first `order` states exist, because some are optional.

use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

use super::transition::Transition;

/// A column of numbers, one for each state: a mean, a gain, a row of a Jacobian.
pub type Column<const N: usize> = SVector<f64, N>;

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
        f.propagate(&mut self.covariance);
    }

    /// Adds independent noise to a state.
    pub fn add_noise(&mut self, state: usize, variance: f64) {
        self.covariance[(state, state)] += variance;
    }

    /// `P h` of a row of derivatives, most of which are zero.
    #[must_use]
    pub fn correlate(&self, row: &Column<N>) -> Column<N> {
        let mut sum: Column<N> = Column::zeros();
        for (column, &h) in self.covariance.as_slice().chunks_exact(N).zip(row.as_slice()) {
            if h != 0.0 {
                add_scaled(sum.as_mut_slice(), h, column);
            }
        }
        sum
    }

    /// The covariance after an update with a scalar measurement: its row h of derivatives, the variance
    /// R of its noise, the gain `K = P h / S` and the variance S of its innovation.
    ///
    /// `P - K S K^T`, or where that would cancel, Joseph's `(I - K h^T) P (I - K h^T)^T + K R K^T`.
    pub fn condense(&mut self, row: &Column<N>, noise: f64, gain: &Column<N>, s: f64) {
        if noise < ILL_CONDITIONED * s {
            return self.condense_by_joseph(row, noise, gain, s);
        }
        // (k_i k_j) s is the same for (i, j) and (j, i): symmetry is exact.
        let gain = gain.as_slice();
        for (column, &own) in self.covariance.as_mut_slice().chunks_exact_mut(N).zip(gain) {
            if own != 0.0 {
                for (p, k) in column.iter_mut().zip(gain) {
                    *p -= (k * own) * s;
                }
            }
        }
    }

    fn condense_by_joseph(&mut self, row: &Column<N>, noise: f64, gain: &Column<N>, s: f64) {
        let correlation = gain * s;
        let reduced = self.covariance - gain * correlation.transpose();
        let rest = reduced * row;
        let joseph =
            reduced - rest * gain.transpose() + gain * gain.transpose() * noise;
        self.covariance = (joseph + joseph.transpose()) * 0.5;
    }

    /// Adds the product of a column with itself to the covariance.
    pub fn widen(&mut self, direction: &Column<N>) {
        self.covariance += direction * direction.transpose();
    }

    /// Variance of a linear combination of states.
    #[must_use]
    pub fn variance(&self, row: &Column<N>) -> f64 {
        dot(row, &self.correlate(row))
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
            for i in j..n {
                let mut sum = self.covariance[(i, j)] * scale[i] * scale[j];
                for k in 0..j {
                    sum -= l[(i, k)] * l[(j, k)];
                }
                if i == j {
                    if sum.is_nan() || sum < -1e-9 {
                        return false;
                    }
                    l[(j, j)] = sum.max(0.0).sqrt();
                } else if l[(j, j)] > 1e-7 {
                    l[(i, j)] = sum / l[(j, j)];
                }
            }
        }
        (0..n).all(|i| self.covariance[(i, i)] >= 0.0)
    }

    /// Whether means and variances are numbers; what is not spreads to these with any measurement.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        (0..self.order).all(|i| self.mean[i].is_finite() && self.covariance[(i, i)].is_finite())
            && self.attitude.iter().all(|x| x.is_finite())
    }
}

/// Sum of products; most of the elements of `row` are zero.
#[inline]
pub(super) fn dot<const N: usize>(row: &Column<N>, b: &Column<N>) -> f64 {
    let pairs = row.as_slice().iter().zip(b.as_slice());
    pairs.filter(|(h, _)| **h != 0.0).map(|(h, b)| h * b).sum()
}

/// `sum += factor * column`.
#[inline]
pub(super) fn add_scaled(sum: &mut [f64], factor: f64, column: &[f64]) {
    for (s, value) in sum.iter_mut().zip(column) {
        *s += factor * value;
    }
}
