//! Thrust allocation: wrench of eight thrusters and its inverse of least squares.
//!
//! `tau = T f`, `f = T^T (T T^T)^-1 tau`: Fossen (2011) ch. 12.3; the columns of T are eqs
//! (31)-(34) of the paper extended to six degrees of freedom.

use crate::ParameterError;
use crate::vehicle::Thruster;
use nalgebra::Matrix6;

/// Smallest pivot of T Tᵀ, relative to its largest diagonal element, that counts as rank 6.
const RANK_TOLERANCE: f64 = 1e-9;

/// The 6 x 8 allocation matrix and its pseudo-inverse.
#[derive(Clone, Debug, PartialEq)]
pub struct Allocation {
    /// Columns of T: wrench of one newton of each thruster.
    columns: [[f64; 6]; 8],
    /// Rows of the pseudo-inverse: force of each thruster for a unit of each wrench component.
    inverse: [[f64; 6]; 8],
}

impl Allocation {
    /// Builds both matrices.
    ///
    /// # Errors
    /// A coefficient is not finite, or the thrusters cannot act in all six degrees of freedom.
    pub fn new(thrusters: &[Thruster; 8]) -> Result<Self, ParameterError> {
        thrusters.iter().enumerate().try_for_each(|(i, t)| t.check(i))?;
        let columns = thrusters.map(|t| t.unit_wrench());
        let gram = Matrix6::from_fn(|i, j| columns.iter().map(|c| c[i] * c[j]).sum::<f64>());
        let threshold = RANK_TOLERANCE * gram.diagonal().max();
        let gram_inverse = gram
            .cholesky()
            .filter(|f| f.l_dirty().diagonal().iter().all(|&d: &f64| d * d > threshold))
            .map(|f| f.inverse());
        let Some(gram_inverse) = gram_inverse else {
            let reason = "the thrusters must be able to act in all six degrees of freedom \
                          (the allocation matrix has a rank below 6)";
            return Err(ParameterError::new("thrusters", "their geometry", reason));
        };
        let inverse = columns.map(|c| {
            core::array::from_fn(|i| (0..6).map(|j| gram_inverse[(i, j)] * c[j]).sum::<f64>())
        });
        Ok(Self { columns, inverse })
    }

    /// Wrench `[X, Y, Z, K, M, N]` about the centre of gravity, body (N, N.m) of eight thrusts (N).
    #[must_use]
    pub fn wrench(&self, forces: &[f64; 8]) -> [f64; 6] {
        core::array::from_fn(|i| self.columns.iter().zip(forces).map(|(c, f)| c[i] * f).sum())
    }

    /// The smallest thrusts (in the sum of squares) that give a wrench; not limited.
    #[must_use]
    pub fn forces(&self, wrench: &[f64; 6]) -> [f64; 8] {
        self.inverse.map(|row| row.iter().zip(wrench).map(|(a, w)| a * w).sum())
    }
}
