//! Coefficients of the vehicle as plain numbers, and their validation.

use super::{Propulsion, presets};
use crate::ParameterError;
use crate::error::{each, finite, non_negative, positive};
use nalgebra::{Matrix3, Matrix6};

/// Named sets of coefficients.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ParameterSet {
    /// The values of UUV Simulator, added mass as full 6 x 6 matrix.
    #[default]
    Uuv,
    /// The values of UUV Simulator with diagonal added mass and inertia.
    UuvDiagonal,
    /// Tables 5 and 6 of the paper, with their misprints corrected; diagonal.
    Paper,
}

/// Inertia about the centre of gravity, body (kg.m2): elements of the matrix, not its negated
/// products.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "the six elements are named by their indices")]
pub struct Inertia {
    pub xx: f64,
    pub yy: f64,
    pub zz: f64,
    pub xy: f64,
    pub xz: f64,
    pub yz: f64,
}

impl Inertia {
    /// The symmetric matrix.
    #[must_use]
    pub fn matrix(&self) -> [[f64; 3]; 3] {
        [[self.xx, self.xy, self.xz], [self.xy, self.yy, self.yz], [self.xz, self.yz, self.zz]]
    }

    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        let names = ["xx", "yy", "zz", "xy", "xz", "yz"];
        let values = [self.xx, self.yy, self.zz, self.xy, self.xz, self.yz];
        for (name, value) in names.iter().zip(values) {
            finite(&format!("inertia.{name}"), value)?;
        }
        let m = self.matrix();
        if Matrix3::from_fn(|i, j| m[i][j]).cholesky().is_none() {
            let value = format!("{values:?} (xx, yy, zz, xy, xz, yz)");
            return Err(ParameterError::new("inertia", value, "must be positive definite"));
        }
        Ok(())
    }
}

/// All coefficients of the six-degree-of-freedom model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Dry mass (kg).
    pub mass: f64,
    /// Inertia about the centre of gravity (kg.m2).
    pub inertia: Inertia,
    /// Displaced volume (m3).
    pub volume: f64,
    /// Density of the water (kg/m3).
    pub density: f64,
    /// Acceleration of gravity (m/s2).
    pub gravity: f64,
    /// Buoyancy (N); `None` computes it as density x gravity x volume, eq (17).
    pub buoyancy: Option<f64>,
    /// Centre of buoyancy from the centre of gravity, body (m); stable with z < 0 (above).
    pub centre_of_buoyancy: [f64; 3],
    /// Added mass M_A, positive (kg, kg.m, kg.m2).
    pub added_mass: [[f64; 6]; 6],
    /// Diagonal of the linear damping, positive (N.s/m, N.m.s/rad).
    pub linear_damping: [f64; 6],
    /// Diagonal of the quadratic damping, positive (N.s2/m2, N.m.s2/rad2).
    pub quadratic_damping: [f64; 6],
    /// Thrusters.
    pub propulsion: Propulsion,
}

/// Largest difference between mirrored elements that counts as rounding in a printed table,
/// relative to the larger one (the simulator prints 10.774 and 10.775).
const ASYMMETRY: f64 = 1e-3;

impl Parameters {
    /// The coefficients of a named set.
    #[must_use]
    pub fn preset(set: ParameterSet) -> Self {
        match set {
            ParameterSet::Uuv => presets::uuv(),
            ParameterSet::UuvDiagonal => presets::uuv_diagonal(),
            ParameterSet::Paper => presets::paper(),
        }
    }

    /// Weight, eq (18) (N).
    #[must_use]
    pub fn weight(&self) -> f64 {
        self.mass * self.gravity
    }

    /// Buoyancy as given or from eq (17) (N).
    #[must_use]
    pub fn buoyancy_force(&self) -> f64 {
        self.buoyancy.unwrap_or(self.density * self.gravity * self.volume)
    }

    /// M = M_RB + M_A, eqs (8) and (12), with the added mass made exactly symmetric.
    #[must_use]
    pub fn mass_matrix(&self) -> [[f64; 6]; 6] {
        let mut m = self.symmetric_added_mass();
        let inertia = self.inertia.matrix();
        for i in 0..3 {
            m[i][i] += self.mass;
            for j in 0..3 {
                m[3 + i][3 + j] += inertia[i][j];
            }
        }
        m
    }

    /// The added mass with mirrored elements averaged: printed tables differ in the last digit.
    #[must_use]
    pub fn symmetric_added_mass(&self) -> [[f64; 6]; 6] {
        let a = &self.added_mass;
        core::array::from_fn(|i| core::array::from_fn(|j| 0.5 * (a[i][j] + a[j][i])))
    }

    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        positive("mass", self.mass)?;
        self.inertia.check()?;
        positive("volume", self.volume)?;
        positive("density", self.density)?;
        non_negative("gravity", self.gravity)?;
        self.buoyancy.map_or(Ok(()), |b| non_negative("buoyancy", b))?;
        each("centre_of_buoyancy", &self.centre_of_buoyancy, finite)?;
        each("linear_damping", &self.linear_damping, non_negative)?;
        each("quadratic_damping", &self.quadratic_damping, non_negative)?;
        self.check_added_mass()?;
        self.propulsion.check()
    }

    fn check_added_mass(&self) -> Result<(), ParameterError> {
        let a = &self.added_mass;
        for (i, row) in a.iter().enumerate() {
            each(&format!("added_mass[{i}]"), row, finite)?;
            for (j, &value) in row.iter().enumerate().take(i) {
                if (value - a[j][i]).abs() > ASYMMETRY * value.abs().max(a[j][i].abs()) {
                    let reason =
                        format!("must be symmetric, but added_mass[{j}][{i}] = {}", a[j][i]);
                    return Err(ParameterError::new(
                        format!("added_mass[{i}][{j}]"),
                        value,
                        &reason,
                    ));
                }
            }
        }
        let m = self.mass_matrix();
        if Matrix6::from_fn(|i, j| m[i][j]).cholesky().is_none() {
            let diagonal: [f64; 6] = core::array::from_fn(|i| a[i][i]);
            let reason = "mass matrix M_RB + M_A must be positive definite \
                          (added mass is entered with positive sign)";
            return Err(ParameterError::new(
                "added_mass",
                format!("{diagonal:?} (diagonal)"),
                reason,
            ));
        }
        Ok(())
    }
}

impl Default for Parameters {
    fn default() -> Self {
        Self::preset(ParameterSet::default())
    }
}
