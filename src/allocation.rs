//! Thrust allocation: the wrench of eight thrusters and its least-squares inverse.
//!
//! `tau = T f`, `f = T^T (T T^T)^-1 tau`: Fossen (2011) ch. 12.3; the columns of T are eqs
//! (31)-(34) of the paper extended to six degrees of freedom.
//!
//! Thrusters that have lost thrust, and vehicles whose T has a rank below 6, use the pseudo-inverse
//! of the effective matrix by iterated Tikhonov regularization (Engl, Hanke & Neubauer 1996, ch.
//! 5): it is exact in directions in which the thrusters act, without huge thrusts in directions in
//! which they hardly act. A shortfall is shared by all axes alike. Favouring the controlled axes
//! looks better but is not: roll and pitch then lack damping, and without two thrusters the vehicle
//! may tumble.

use crate::ParameterError;
use crate::error::declared;
use crate::vehicle::Thruster;
use nalgebra::{Matrix6, SMatrix};
use serde::{Deserialize, Serialize};

/// Smallest pivot of T Tᵀ, relative to its largest diagonal element, that counts as rank 6.
const RANK_TOLERANCE: f64 = 1e-9;
/// Loss of thrust above which a thruster is not used.
const GONE: f64 = 0.99;
/// Regularization, relative to the largest diagonal element of T Tᵀ.
const DAMPING: f64 = 6e-3;
/// Iterations of the regularization.
const ITERATIONS: usize = 16;

/// Force of each thruster for a unit of each wrench component.
type Inverse = [[f64; 6]; 8];

/// The 6 x 8 allocation matrix and its pseudo-inverse.
#[derive(Clone, Debug, PartialEq)]
pub struct Allocation {
    /// Columns of T: wrench of one newton of each thruster.
    columns: [[f64; 6]; 8],
    /// The inverse with all thrusters healthy.
    inverse: Inverse,
    /// Regularization of T Tᵀ.
    damping: f64,
}

/// The inverse for thrusters that have lost thrust, kept until the losses change.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Degraded {
    loss: [f64; 8],
    inverse: Inverse,
}

impl Allocation {
    /// Builds both matrices. A thruster whose five coefficients are all zero is absent.
    ///
    /// # Errors
    /// A coefficient is not finite or too large to compute with, or all thrusters are absent.
    pub fn new(thrusters: &[Thruster; 8]) -> Result<Self, ParameterError> {
        for (i, thruster) in thrusters.iter().enumerate() {
            declared(thruster).map_err(|error| error.within(&format!("thruster[{i}]")))?;
        }
        let columns = thrusters.map(|t| if absent(&t) { [0.0; 6] } else { t.unit_wrench() });
        let gram = Matrix6::from_fn(|i, j| columns.iter().map(|c| c[i] * c[j]).sum::<f64>());
        let error = |reason| ParameterError::new("thrusters", "their geometry", reason);
        if !gram.iter().all(|element| element.is_finite()) {
            return Err(error("must be of a size that can be computed with"));
        }
        let scale = gram.diagonal().max();
        if scale <= 0.0 {
            return Err(error("at least one thruster must not be absent (all zero)"));
        }
        let mut allocation = Self { columns, inverse: [[0.0; 6]; 8], damping: DAMPING * scale };
        let threshold = RANK_TOLERANCE * scale;
        let gram_inverse = gram
            .cholesky()
            .filter(|f| f.l_dirty().diagonal().iter().all(|&d: &f64| d * d > threshold))
            .map(|f| f.inverse());
        allocation.inverse = gram_inverse.map_or_else(
            || allocation.regularized(&[0.0; 8]),
            |gram_inverse| {
                columns.map(|c| {
                    core::array::from_fn(|i| {
                        (0..6).map(|j| gram_inverse[(i, j)] * c[j]).sum::<f64>()
                    })
                })
            },
        );
        Ok(allocation)
    }

    /// Wrench `[X, Y, Z, K, M, N]` about the centre of gravity, body (N, N.m) of eight thrusts (N).
    #[must_use]
    pub fn wrench(&self, forces: &[f64; 8]) -> [f64; 6] {
        core::array::from_fn(|i| self.columns.iter().zip(forces).map(|(c, f)| c[i] * f).sum())
    }

    /// The smallest thrusts (in the sum of squares) that give a wrench; not limited.
    #[must_use]
    pub fn forces(&self, wrench: &[f64; 6]) -> [f64; 8] {
        forces(&self.inverse, wrench)
    }

    /// The smallest thrusts to command for a wrench when each thruster gives only `1 - loss` of its
    /// command; not limited. From a loss of 0.99 on, a thruster's command is zero.
    ///
    /// A loss outside 0 to 1 counts as the nearer of the two, a NaN as 0. `degraded` is a cache,
    /// initially `None`.
    /// is a cache, initially `None`.
    pub fn forces_with_loss(
        &self,
        loss: &[f64; 8],
        degraded: &mut Option<Degraded>,
        wrench: &[f64; 6],
    ) -> [f64; 8] {
        let loss = loss.map(|l| if l > 0.0 { l.min(1.0) } else { 0.0 });
        if loss == [0.0; 8] {
            return self.forces(wrench);
        }
        let known = degraded.take().filter(|d| d.loss == loss);
        let current = known.unwrap_or_else(|| Degraded { loss, inverse: self.regularized(&loss) });
        forces(&degraded.insert(current).inverse, wrench)
    }

    /// The pseudo-inverse X of the effective matrix A:
    /// `X_k+1 = X_k + A^T (A A^T + damping)^-1 (1 - A X_k)`.
    fn regularized(&self, loss: &[f64; 8]) -> Inverse {
        let a = SMatrix::<f64, 6, 8>::from_fn(|axis, i| match loss[i] < GONE {
            true => self.columns[i][axis] * (1.0 - loss[i]),
            false => 0.0,
        });
        let identity = Matrix6::identity();
        let Some(factor) = (a * a.transpose() + identity * self.damping).cholesky() else {
            return [[0.0; 6]; 8];
        };
        let step = a.transpose() * factor.inverse();
        let x = (1..ITERATIONS).fold(step, |x, _| x + step * (identity - a * x));
        core::array::from_fn(|i| core::array::from_fn(|axis| x[(i, axis)]))
    }
}

fn absent(t: &Thruster) -> bool {
    [t.lx, t.ly, t.lz, t.theta_deg, t.psi_deg] == [0.0; 5]
}

fn forces(inverse: &Inverse, wrench: &[f64; 6]) -> [f64; 8] {
    inverse.map(|row| row.iter().zip(wrench).map(|(a, w)| a * w).sum())
}
