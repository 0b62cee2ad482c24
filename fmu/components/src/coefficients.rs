//! The coefficients of the vehicle as FMI parameters: named sets, in which each value can be
//! changed.
//!
//! Shared by the vehicle and by the models inside filters.

use crate::added_mass::AddedMass;
use crate::groups::{Inertia, Mounting, Vector};
use fmu_kit::{Enumeration, Variables};
use rexrov::vehicle::{self, ReducedModel};

/// Named sets of coefficients.
#[derive(Clone, Copy, Debug, Default, PartialEq, Enumeration)]
pub enum ParameterSet {
    /// UUV Simulator, added mass and inertia as full matrices
    #[default]
    Uuv,
    /// UUV Simulator, added mass and inertia diagonal
    UuvDiagonal,
    /// Tables 3 to 6 of the paper, misprints mended, diagonal
    Paper,
}

impl From<ParameterSet> for vehicle::ParameterSet {
    fn from(set: ParameterSet) -> Self {
        match set {
            ParameterSet::Uuv => Self::Uuv,
            ParameterSet::UuvDiagonal => Self::UuvDiagonal,
            ParameterSet::Paper => Self::Paper,
        }
    }
}

/// All coefficients; those not set come from the parameter set.
#[derive(Clone, Debug, Variables)]
pub struct Coefficients {
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
    #[var(unit = "N", min = 0.0, nominal = 10000.0)]
    pub buoyancy: f64,
    /// Centre of buoyancy from the centre of gravity, body frame; stable with z < 0
    #[var(unit = "m")]
    pub centre_of_buoyancy: Vector,
    /// Added mass
    pub added_mass: AddedMass,
    /// Linear damping, positive
    pub linear_damping: LinearDamping,
    /// Quadratic damping, positive
    pub quadratic_damping: QuadraticDamping,
    /// Thruster
    pub thruster: [Mounting; 8],
    /// Time constant of the rotor speeds
    #[var(unit = "s", min = 1e-9)]
    pub rotor_time_constant: f64,
    /// Thrust over rotor speed squared
    #[var(unit = "N.s2/rad2", min = 1e-9, nominal = 1e-3)]
    pub thrust_gain: f64,
    /// Limit of the commanded thrust of each thruster, either sign
    #[var(unit = "N", min = 1e-9, nominal = 1000.0)]
    pub thrust_limit: f64,
}

crate::groups::group! {
    /// Diagonal of the linear damping matrix.
    LinearDamping = [
        /// surge
        #[var(unit = "N.s/m", min = 0.0)] u,
        /// sway
        #[var(unit = "N.s/m", min = 0.0)] v,
        /// heave
        #[var(unit = "N.s/m", min = 0.0)] w,
        /// roll
        #[var(unit = "N.m.s/rad", min = 0.0)] p,
        /// pitch
        #[var(unit = "N.m.s/rad", min = 0.0)] q,
        /// yaw
        #[var(unit = "N.m.s/rad", min = 0.0)] r; 6]
}

crate::groups::group! {
    /// Diagonal of the quadratic damping matrix.
    QuadraticDamping = [
        /// surge
        #[var(unit = "N.s2/m2", min = 0.0)] u,
        /// sway
        #[var(unit = "N.s2/m2", min = 0.0)] v,
        /// heave
        #[var(unit = "N.s2/m2", min = 0.0)] w,
        /// roll
        #[var(unit = "N.m.s2/rad2", min = 0.0)] p,
        /// pitch
        #[var(unit = "N.m.s2/rad2", min = 0.0)] q,
        /// yaw
        #[var(unit = "N.m.s2/rad2", min = 0.0)] r; 6]
}

impl Coefficients {
    /// The values of a named set.
    pub fn preset(set: ParameterSet) -> Self {
        vehicle::Parameters::preset(set.into()).into()
    }

    /// The model inside a filter. Its input is the thrusts themselves, so the meaning of the
    /// thruster inputs does not matter.
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn checked(&self) -> Result<vehicle::Parameters, ::rexrov::ParameterError> {
        let parameters = self.with_mode(vehicle::ThrusterMode::Force);
        ReducedModel::new(&parameters).map_err(|error| error.within("model"))?;
        Ok(parameters)
    }

    /// The parameters of the mathematics, with the meaning of the thruster inputs.
    pub fn with_mode(&self, mode: vehicle::ThrusterMode) -> vehicle::Parameters {
        vehicle::Parameters {
            mass: self.mass,
            inertia: self.inertia.into(),
            volume: self.volume,
            density: self.density,
            gravity: self.gravity,
            buoyancy: (self.buoyancy != 0.0).then_some(self.buoyancy),
            centre_of_buoyancy: self.centre_of_buoyancy.into(),
            added_mass: self.added_mass.into(),
            linear_damping: self.linear_damping.into(),
            quadratic_damping: self.quadratic_damping.into(),
            propulsion: vehicle::Propulsion {
                thrusters: self.thruster.map(Into::into),
                mode,
                rotor_time_constant: self.rotor_time_constant,
                thrust_gain: self.thrust_gain,
                thrust_limit: self.thrust_limit,
            },
        }
    }
}

impl From<vehicle::Parameters> for Coefficients {
    fn from(p: vehicle::Parameters) -> Self {
        Self {
            mass: p.mass,
            inertia: p.inertia.into(),
            volume: p.volume,
            density: p.density,
            gravity: p.gravity,
            buoyancy: p.buoyancy.unwrap_or(0.0),
            centre_of_buoyancy: p.centre_of_buoyancy.into(),
            added_mass: p.symmetric_added_mass().into(),
            linear_damping: p.linear_damping.into(),
            quadratic_damping: p.quadratic_damping.into(),
            thruster: p.propulsion.thrusters.map(Into::into),
            rotor_time_constant: p.propulsion.rotor_time_constant,
            thrust_gain: p.propulsion.thrust_gain,
            thrust_limit: p.propulsion.thrust_limit,
        }
    }
}
