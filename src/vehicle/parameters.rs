//! Coefficients of the vehicle as plain numbers, and their validation.

use super::added_mass::AddedMass;
use super::{Propulsion, presets};
use crate::ParameterError;
use crate::axes;
use crate::error::declared;
use fmu_quantity::{Enumeration, Member, Variables};
use nalgebra::{Matrix3, Matrix6};

/// Named sets of coefficients.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
pub enum ParameterSet {
    /// UUV Simulator, added mass and inertia as full matrices
    #[default]
    Uuv,
    /// UUV Simulator, added mass and inertia diagonal
    UuvDiagonal,
    /// Tables 3 to 6 of the paper, misprints mended, diagonal
    Paper,
}

/// Inertia about the centre of gravity, body: elements of the matrix, not its negated products.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
#[allow(missing_docs, reason = "the six elements are named by their indices")]
pub struct Inertia {
    #[var(unit = "kg.m2")]
    pub xx: f64,
    #[var(unit = "kg.m2")]
    pub yy: f64,
    #[var(unit = "kg.m2")]
    pub zz: f64,
    #[var(unit = "kg.m2")]
    pub xy: f64,
    #[var(unit = "kg.m2")]
    pub xz: f64,
    #[var(unit = "kg.m2")]
    pub yz: f64,
}

impl Inertia {
    /// The symmetric matrix.
    #[must_use]
    pub fn matrix(&self) -> [[f64; 3]; 3] {
        [[self.xx, self.xy, self.xz], [self.xy, self.yy, self.yz], [self.xz, self.yz, self.zz]]
    }

    /// Checks what is not declared: that the matrix is positive definite.
    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        let m = self.matrix();
        if Matrix3::from_fn(|i, j| m[i][j]).cholesky().is_none() {
            let values = [self.xx, self.yy, self.zz, self.xy, self.xz, self.yz];
            let value = format!("{values:?} (xx, yy, zz, xy, xz, yz)");
            return Err(ParameterError::new("inertia", value, "must be positive definite"));
        }
        Ok(())
    }
}

/// Diagonal of the linear damping matrix.
const LINEAR_DAMPING: [Member; 6] = [
    Member::new("u", "surge").unit("N.s/m").min(0.0),
    Member::new("v", "sway").unit("N.s/m").min(0.0),
    Member::new("w", "heave").unit("N.s/m").min(0.0),
    Member::new("p", "roll").unit("N.m.s/rad").min(0.0),
    Member::new("q", "pitch").unit("N.m.s/rad").min(0.0),
    Member::new("r", "yaw").unit("N.m.s/rad").min(0.0),
];

/// Diagonal of the quadratic damping matrix.
const QUADRATIC_DAMPING: [Member; 6] = [
    Member::new("u", "surge").unit("N.s2/m2").min(0.0),
    Member::new("v", "sway").unit("N.s2/m2").min(0.0),
    Member::new("w", "heave").unit("N.s2/m2").min(0.0),
    Member::new("p", "roll").unit("N.m.s2/rad2").min(0.0),
    Member::new("q", "pitch").unit("N.m.s2/rad2").min(0.0),
    Member::new("r", "yaw").unit("N.m.s2/rad2").min(0.0),
];

/// All coefficients of the six-degree-of-freedom model.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct Parameters {
    /// Dry mass
    #[var(unit = "kg", min = 1e-9, nominal = 1000.0)]
    pub mass: f64,
    /// Inertia about the centre of gravity, positive definite
    pub inertia: Inertia,
    /// Displaced volume
    #[var(unit = "m3", min = 1e-9)]
    pub volume: f64,
    /// Density of the water
    #[var(unit = "kg/m3", min = 1e-9, nominal = 1000.0)]
    pub density: f64,
    /// Acceleration of gravity
    #[var(unit = "m/s2", min = 0.0)]
    pub gravity: f64,
    /// Buoyancy; 0 computes it as density x gravity x volume, eq (17)
    ///
    /// Here `None` stands for 0.
    #[var(unit = "N", min = 0.0, nominal = 10000.0, via = Given)]
    pub buoyancy: Option<f64>,
    /// Centre of buoyancy from the centre of gravity, body frame; stable with z < 0
    ///
    /// Which is above.
    #[var(unit = "m", elements = axes::BODY)]
    pub centre_of_buoyancy: [f64; 3],
    /// Added mass
    ///
    /// M_A with positive sign; its upper triangle is declared.
    #[var(via = AddedMass)]
    pub added_mass: [[f64; 6]; 6],
    /// Linear damping, positive
    ///
    /// The diagonal of the matrix.
    #[var(elements = LINEAR_DAMPING)]
    pub linear_damping: [f64; 6],
    /// Quadratic damping, positive
    ///
    /// The diagonal of the matrix.
    #[var(elements = QUADRATIC_DAMPING)]
    pub quadratic_damping: [f64; 6],
    /// Thrusters.
    #[var(flatten)]
    pub propulsion: Propulsion,
}

/// A number that is absent as 0.
#[derive(Clone, Copy, Debug, Variables)]
struct Given {
    /// The number.
    #[var(flatten)]
    value: f64,
}

impl From<Option<f64>> for Given {
    fn from(value: Option<f64>) -> Self {
        Self { value: value.unwrap_or(0.0) }
    }
}

impl From<Given> for Option<f64> {
    fn from(Given { value }: Given) -> Self {
        (value != 0.0).then_some(value)
    }
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
        AddedMass::from(self.added_mass).into()
    }

    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        declared(self)?;
        self.inertia.check()?;
        self.check_added_mass()
    }

    fn check_added_mass(&self) -> Result<(), ParameterError> {
        let a = &self.added_mass;
        for (i, row) in a.iter().enumerate() {
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
