//! Thrusters: geometry, rotor lag and the thrust curve.
//!
//! `w' = (w_cmd - w) / tau`, `T = gain w |w|` (the paper's look-up table from rpm to thrust, here
//! in rad/s); a damaged propeller loses a fraction of T. Axis of a thruster
//! `e = (cos th cos ps, cos th sin ps, -sin th)`, moment `r x e T`: eqs (31)-(34) of the paper,
//! with (33) and (34) corrected.

use super::Inputs;
use crate::vector::cross;
use fmu_quantity::{Enumeration, Variables};

/// Position and direction of a thruster, body frame.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct Thruster {
    /// place forward of the centre of gravity
    #[var(unit = "m")]
    pub lx: f64,
    /// place to starboard
    #[var(unit = "m")]
    pub ly: f64,
    /// place downwards
    #[var(unit = "m")]
    pub lz: f64,
    /// elevation of the axis above the horizontal
    #[var(unit = "deg")]
    pub theta_deg: f64,
    /// azimuth of the axis from forward, positive to starboard
    #[var(unit = "deg")]
    pub psi_deg: f64,
}

impl Thruster {
    /// Wrench `[X, Y, Z, K, M, N]` of one newton of thrust: a column of the allocation matrix.
    #[must_use]
    pub fn unit_wrench(&self) -> [f64; 6] {
        let (st, ct) = libm::sincos(self.theta_deg.to_radians());
        let (sp, cp) = libm::sincos(self.psi_deg.to_radians());
        let axis = [ct * cp, ct * sp, -st];
        let moment = cross([self.lx, self.ly, self.lz], axis);
        [axis[0], axis[1], axis[2], moment[0], moment[1], moment[2]]
    }
}

/// Meaning of the thruster inputs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
pub enum ThrusterMode {
    /// force demanded in N, through the lag of the rotor
    ///
    /// To rotor speed by the inverse curve, through the lag, to thrust.
    #[default]
    ForceWithLag,
    /// force in N that acts at once
    ///
    /// The rotor speeds keep their values.
    Force,
    /// rotor speed demanded in rad/s, through the lag of the rotor
    RotorSpeed,
}

/// The eight thrusters; they share one rotor and thrust curve.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct Propulsion {
    /// Thruster
    ///
    /// Numbered as in the paper, Tables 3 and 4.
    #[var(rename = "thruster")]
    pub thrusters: [Thruster; 8],
    /// Meaning of the thruster inputs; a parameter of the vehicle only, not of models in filters.
    #[var(skip)]
    pub mode: ThrusterMode,
    /// Time constant of the rotor speeds
    #[var(unit = "s", min = 1e-9)]
    pub rotor_time_constant: f64,
    /// Thrust over rotor speed squared
    #[var(unit = "N.s2/rad2", min = 1e-9, nominal = 1e-3)]
    pub thrust_gain: f64,
    /// Limit of the commanded thrust of each thruster, either sign
    ///
    /// It limits the speed command as well.
    #[var(unit = "N", min = 1e-9, nominal = 1000.0)]
    pub thrust_limit: f64,
}

impl Propulsion {
    /// The inputs that command the thrusters in this mode: forces (N) or rotor speeds (rad/s).
    #[inline(always)]
    pub(super) fn command<'a>(&self, inputs: &'a Inputs) -> &'a [f64; 8] {
        match self.mode {
            ThrusterMode::RotorSpeed => &inputs.thruster_speed,
            ThrusterMode::ForceWithLag | ThrusterMode::Force => &inputs.thruster_force,
        }
    }

    /// Where the right-hand side has kinks: the first eight cross zero where a command crosses its
    /// limit, of either sign. The others cross zero where it changes its sign, where the square
    /// root in [`Propulsion::speed`] is steep (and which a swing from one limit to the other cannot
    /// miss).
    ///
    /// A command at its limit counts as within it and a command of zero as positive, by one part in
    /// 10^12 of the limit, so that a thruster at rest or at full power is not permanently at a
    /// kink.
    #[must_use]
    #[inline]
    pub fn kinks(&self, inputs: &Inputs) -> ([f64; 8], [f64; 8]) {
        let command = self.command(inputs);
        let limit = match self.mode {
            ThrusterMode::RotorSpeed => self.speed(self.thrust_limit),
            ThrusterMode::ForceWithLag | ThrusterMode::Force => self.thrust_limit,
        };
        let margin = 1e-12 * limit;
        (command.map(|c| (limit - c.abs()) + margin), command.map(|c| c + margin))
    }

    /// Thrusts (N) over the square of the rotor speeds, including the losses of the propellers.
    #[inline(always)]
    pub(super) fn thrust_gains(&self, inputs: &Inputs) -> [f64; 8] {
        inputs.thruster_loss.map(|loss| self.thrust_gain * (1.0 - loss))
    }

    /// Thrusts (N) commanded in the mode `Force`, minus the losses of the propellers.
    #[inline(always)]
    pub(super) fn direct_thrust(&self, inputs: &Inputs) -> [f64; 8] {
        let clipped = self.clipped(&inputs.thruster_force);
        core::array::from_fn(|i| clipped[i] * (1.0 - inputs.thruster_loss[i]))
    }

    /// Commanded thrusts (N), clipped to the limit.
    #[inline(always)]
    pub(super) fn clipped(&self, thrust: &[f64; 8]) -> [f64; 8] {
        thrust.map(|f| f.clamp(-self.thrust_limit, self.thrust_limit))
    }

    /// Rotor speeds (rad/s) for commanded thrusts (N).
    #[inline(always)]
    pub(super) fn speeds(&self, thrust: &[f64; 8]) -> [f64; 8] {
        self.clipped(thrust).map(|f| self.speed(f))
    }

    /// Thrust (N) of an intact propeller at a rotor speed (rad/s).
    #[must_use]
    #[inline(always)]
    pub fn thrust(&self, speed: f64) -> f64 {
        self.thrust_gain * speed * speed.abs()
    }

    /// Rotor speed (rad/s) that gives a thrust (N): the inverse of [`Propulsion::thrust`].
    #[must_use]
    #[inline(always)]
    pub fn speed(&self, thrust: f64) -> f64 {
        (thrust.abs() / self.thrust_gain).sqrt().copysign(thrust)
    }
}
