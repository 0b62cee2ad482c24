//! State, inputs and outputs of the vehicle model. World NED, body FRD, SI units.

use crate::attitude;
use crate::axes;
use fmu_quantity::{Count, Declarations, Field, Member, Reader, Variables, Writer};

/// A quaternion from body to NED.
const QUATERNION: [Member; 4] = [
    Member::new("w", "scalar part"),
    Member::new("x", "x"),
    Member::new("y", "y"),
    Member::new("z", "z"),
];

/// The inputs of a thruster.
const DEMAND: [Member; 3] = [
    Member::new("force", "force demanded (thruster_mode ForceWithLag or Force)")
        .unit("N")
        .nominal(1000.0),
    Member::new("speed", "rotor speed demanded (thruster_mode RotorSpeed)")
        .unit("rad/s")
        .nominal(1000.0),
    Member::new(
        "loss",
        "fraction of the thrust lost: 0 sound, 1 propeller lost, 2 turning the wrong way; the rotor \
         turns as demanded",
    )
    .unit("1"),
];

/// Continuous state, and in the same shape its time derivative.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct State {
    /// position
    ///
    /// Of the centre of gravity.
    #[var(rename = "position", elements = axes::NED)]
    pub p_ned: [f64; 3],
    /// attitude, body to NED, not exactly of unit length
    ///
    /// No code relies on its length.
    #[var(elements = QUATERNION)]
    pub quaternion: [f64; 4],
    /// velocity over ground, body frame
    #[var(rename = "velocity", elements = axes::VELOCITY)]
    pub nu: [f64; 6],
    /// rotor
    #[var(rename = "rotor", each = axes::ROTOR_SPEED)]
    pub rotor_speed: [f64; 8],
}

impl State {
    /// No change.
    pub const ZERO: Self =
        Self { p_ned: [0.0; 3], quaternion: [0.0; 4], nu: [0.0; 6], rotor_speed: [0.0; 8] };

    /// At rest, rotors stopped, at a position and an attitude `[roll, pitch, yaw]` (rad).
    #[must_use]
    pub fn at_rest(p_ned: [f64; 3], euler: [f64; 3]) -> Self {
        Self { p_ned, quaternion: attitude::from_euler(euler), nu: [0.0; 6], rotor_speed: [0.0; 8] }
    }

    /// Change of [`State::at_rest`] at an attitude as position and attitude change.
    #[must_use]
    pub fn d_at_rest(d_p_ned: [f64; 3], euler: [f64; 3], d_euler: [f64; 3]) -> Self {
        Self { p_ned: d_p_ned, quaternion: attitude::d_from_euler(euler, d_euler), ..Self::ZERO }
    }
}

impl Default for State {
    fn default() -> Self {
        Self::at_rest([0.0; 3], [0.0; 3])
    }
}

/// Inputs of the vehicle; held constant over an integration step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inputs {
    /// Commanded thrusts (N), used by `ForceWithLag` and `Force`.
    pub thruster_force: [f64; 8],
    /// Commanded rotor speeds (rad/s), used by `RotorSpeed`.
    pub thruster_speed: [f64; 8],
    /// Fraction of the thrust that each propeller loses: 0 intact, 1 lost, 2 turning the wrong way.
    pub thruster_loss: [f64; 8],
    /// External wrench `[X, Y, Z, K, M, N]` about the centre of gravity, body (N, N.m).
    pub wrench: [f64; 6],
    /// Steady, irrotational current, NED (m/s).
    pub current_ned: [f64; 3],
}

impl Inputs {
    /// Force, speed and loss of each thruster.
    #[inline(always)]
    fn demands(&self) -> [[f64; 3]; 8] {
        core::array::from_fn(|i| {
            [self.thruster_force[i], self.thruster_speed[i], self.thruster_loss[i]]
        })
    }
}

/// Not derived: the inputs of a thruster are declared together.
impl Variables for Inputs {
    const COUNT: Count = f64::COUNT.times(3 * 8 + 6 + 3);

    fn declare(&self, at: &Field, into: &mut Declarations) {
        let thruster = at.member(&Member::new("thruster", "Thruster"));
        for (i, demand) in self.demands().iter().enumerate() {
            thruster.element(i).elements(demand, &DEMAND, into);
        }
        let about = "External force and moment about the centre of gravity, body frame";
        at.member(&Member::new("wrench", about)).elements(&self.wrench, &axes::WRENCH, into);
        let current = at.member(&Member::new("current", "Current of the water, steady"));
        current.elements(&self.current_ned, &axes::NED_VELOCITY, into);
    }

    #[inline(always)]
    fn load(from: &mut Reader<'_>) -> Self {
        let thruster: [[f64; 3]; 8] = Variables::load(from);
        Self {
            thruster_force: thruster.map(|[force, ..]| force),
            thruster_speed: thruster.map(|[_, speed, _]| speed),
            thruster_loss: thruster.map(|[.., loss]| loss),
            wrench: Variables::load(from),
            current_ned: Variables::load(from),
        }
    }

    #[inline(always)]
    fn store(&self, into: &mut Writer<'_>) {
        self.demands().store(into);
        self.wrench.store(into);
        self.current_ned.store(into);
    }

    #[inline(always)]
    fn zip_reals(&mut self, other: &Self, f: &mut impl FnMut(&mut f64, f64)) {
        for i in 0..8 {
            f(&mut self.thruster_force[i], other.thruster_force[i]);
            f(&mut self.thruster_speed[i], other.thruster_speed[i]);
            f(&mut self.thruster_loss[i], other.thruster_loss[i]);
        }
        self.wrench.zip_reals(&other.wrench, f);
        self.current_ned.zip_reals(&other.current_ned, f);
    }
}

/// Observable quantities of the vehicle, without sensor errors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Variables)]
pub struct Outputs {
    /// Pose of the centre of gravity
    #[var(rename = "pose", elements = axes::NED)]
    pub p_ned: [f64; 3],
    /// Pose of the centre of gravity
    ///
    /// Its part roll, pitch, yaw.
    #[var(rename = "pose", elements = axes::EULER)]
    pub euler: [f64; 3],
    /// Attitude, body to NED
    ///
    /// Of unit length.
    #[var(min = -1.0, max = 1.0, elements = QUATERNION)]
    pub quaternion: [f64; 4],
    /// Velocity over ground, body frame
    #[var(rename = "velocity", elements = axes::VELOCITY)]
    pub nu: [f64; 6],
    /// Velocity over ground
    #[var(rename = "velocity_ned", elements = axes::NED_VELOCITY)]
    pub v_ned: [f64; 3],
    /// Time derivative of the body-frame velocity
    ///
    /// Of `nu`: not the inertial acceleration.
    #[var(rename = "acceleration", elements = axes::ACCELERATION)]
    pub nu_dot: [f64; 6],
    /// Specific force at the centre of gravity, body frame
    ///
    /// At rest -g on z.
    #[var(unit = "m/s2", nominal = 10.0, elements = axes::BODY)]
    pub specific_force: [f64; 3],
    /// Thruster
    #[var(rename = "thruster", each = axes::THRUST)]
    pub thrust: [f64; 8],
    /// Rotor; where a force acts at once, with the speed of a sound propeller for it
    #[var(rename = "rotor", each = axes::ROTOR_SPEED)]
    pub rotor_speed: [f64; 8],
}
