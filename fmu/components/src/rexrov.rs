//! The vehicle: `rexrov::vehicle::Vehicle` with FMI variables, six degrees of freedom.

use crate::coefficients::{Coefficients, ParameterSet};
use crate::groups::{
    Acceleration, Attitude, Ned, Pose, Position, Quaternion, Thrust, Vector, Velocity, Wrench,
    parameter_error,
};
use fmu_kit::{Component, Enumeration, Fault, Info, ParameterError, Resources, Time, Variables};
use rexrov::vehicle::{self, Sensitivity, State, Vehicle};

/// Meaning of the thruster inputs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Enumeration)]
pub enum ThrusterMode {
    /// force demanded in N, through the lag of the rotor
    #[default]
    ForceWithLag,
    /// force in N that acts at once
    Force,
    /// rotor speed demanded in rad/s, through the lag of the rotor
    RotorSpeed,
}

impl From<ThrusterMode> for vehicle::ThrusterMode {
    fn from(mode: ThrusterMode) -> Self {
        match mode {
            ThrusterMode::ForceWithLag => Self::ForceWithLag,
            ThrusterMode::Force => Self::Force,
            ThrusterMode::RotorSpeed => Self::RotorSpeed,
        }
    }
}

/// State at the start.
#[derive(Clone, Copy, Debug, Variables)]
pub struct Start {
    /// position
    pub position: Position,
    /// attitude
    pub attitude: Attitude,
    /// velocity over ground, body frame
    pub velocity: Velocity,
}

impl Default for Start {
    /// Where the courses start, 20 m deep, at rest.
    fn default() -> Self {
        Self {
            position: Position { z: 20.0, ..Position::default() },
            attitude: Attitude::default(),
            velocity: Velocity::default(),
        }
    }
}

/// Parameters of the vehicle.
#[derive(Clone, Debug, Variables)]
pub struct Parameters {
    /// Named set that gives every coefficient not set otherwise
    pub parameter_set: ParameterSet,
    /// Meaning of the thruster inputs
    pub thruster_mode: ThrusterMode,
    /// State at the start
    pub initial: Start,
    /// Coefficients.
    #[var(flatten)]
    pub coefficients: Coefficients,
}

impl Default for Parameters {
    fn default() -> Self {
        let parameter_set = ParameterSet::default();
        Self {
            parameter_set,
            thruster_mode: ThrusterMode::default(),
            initial: Start::default(),
            coefficients: Coefficients::preset(parameter_set),
        }
    }
}

/// Demand on one thruster.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Demand {
    /// force demanded (thruster_mode ForceWithLag or Force)
    #[var(unit = "N", nominal = 1000.0)]
    pub force: f64,
    /// rotor speed demanded (thruster_mode RotorSpeed)
    #[var(unit = "rad/s", nominal = 1000.0)]
    pub speed: f64,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Inputs {
    /// Thruster
    pub thruster: [Demand; 8],
    /// External force and moment about the centre of gravity, body frame
    pub wrench: Wrench,
    /// Current of the water, steady
    pub current: Ned,
}

impl From<&Inputs> for vehicle::Inputs {
    fn from(u: &Inputs) -> Self {
        Self {
            thruster_force: u.thruster.map(|demand| demand.force),
            thruster_speed: u.thruster.map(|demand| demand.speed),
            wrench: u.wrench.into(),
            current_ned: u.current.into(),
        }
    }
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Outputs {
    /// Pose of the centre of gravity
    pub pose: Pose,
    /// Attitude, body to NED
    pub quaternion: Quaternion,
    /// Velocity over ground, body frame
    pub velocity: Velocity,
    /// Velocity over ground
    pub velocity_ned: Ned,
    /// Time derivative of the body-frame velocity
    pub acceleration: Acceleration,
    /// Specific force at the centre of gravity, body frame
    #[var(unit = "m/s2", nominal = 10.0)]
    pub specific_force: Vector,
    /// Thruster
    pub thruster: [Thrust; 8],
}

impl From<vehicle::Outputs> for Outputs {
    #[inline]
    fn from(y: vehicle::Outputs) -> Self {
        let ([x, y_east, z], [roll, pitch, yaw]) = (y.p_ned, y.euler);
        Self {
            pose: Pose { x, y: y_east, z, roll, pitch, yaw },
            quaternion: y.quaternion.into(),
            velocity: y.nu.into(),
            velocity_ned: y.v_ned.into(),
            acceleration: y.nu_dot.into(),
            specific_force: y.specific_force.into(),
            thruster: y.thrust.map(|thrust| Thrust { thrust }),
        }
    }
}

/// Rotor of one thruster.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Rotor {
    /// speed
    #[var(unit = "rad/s", nominal = 100.0)]
    pub speed: f64,
}

/// Continuous states, kept apart from the outputs by a name of their own.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Motion {
    /// position
    pub position: Position,
    /// attitude, body to NED, not exactly of unit length
    pub quaternion: AttitudeState,
    /// velocity over ground, body frame
    pub velocity: Velocity,
    /// rotor
    pub rotor: [Rotor; 8],
}

crate::groups::group! {
    /// The attitude while it is integrated.
    AttitudeState = [
        /// scalar part
        w,
        /// x
        x,
        /// y
        y,
        /// z
        z; 4]
}

/// Continuous states.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct States {
    /// State
    pub state: Motion,
}

impl From<State> for States {
    fn from(s: State) -> Self {
        Self {
            state: Motion {
                position: s.p_ned.into(),
                quaternion: s.quaternion.into(),
                velocity: s.nu.into(),
                rotor: s.rotor_speed.map(|speed| Rotor { speed }),
            },
        }
    }
}

impl From<&States> for State {
    fn from(States { state }: &States) -> Self {
        Self {
            p_ned: state.position.into(),
            quaternion: state.quaternion.into(),
            nu: state.velocity.into(),
            rotor_speed: state.rotor.map(|rotor| rotor.speed),
        }
    }
}

/// Event indicators: commands that cross their limits, commands that change their sign.
const KINKS: [&str; 16] = [
    "thruster[0] limit",
    "thruster[1] limit",
    "thruster[2] limit",
    "thruster[3] limit",
    "thruster[4] limit",
    "thruster[5] limit",
    "thruster[6] limit",
    "thruster[7] limit",
    "thruster[0] reversal",
    "thruster[1] reversal",
    "thruster[2] reversal",
    "thruster[3] reversal",
    "thruster[4] reversal",
    "thruster[5] reversal",
    "thruster[6] reversal",
    "thruster[7] reversal",
];

/// The vehicle with its constants, and its state at the start.
pub struct RexRov {
    vehicle: Vehicle,
    initial: States,
}

impl Component for RexRov {
    const INFO: Info = Info {
        stop_time_s: 60.0,
        ..crate::info(
            "RexROV",
            "RexROV underwater vehicle, six degrees of freedom, eight thrusters",
        )
    };
    const INDICATORS: &[&str] = &KINKS;
    const KINKS_OF_INPUTS: bool = true;
    const TANGENT: bool = true;
    type Parameters = Parameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type States = States;
    type Memory = ();

    fn preset(selected: &Parameters) -> Parameters {
        Parameters {
            coefficients: Coefficients::preset(selected.parameter_set),
            ..Parameters::default()
        }
    }

    fn new(p: &Parameters, _: &Resources) -> Result<Self, ParameterError> {
        let coefficients = p.coefficients.with_mode(p.thruster_mode.into());
        let vehicle = Vehicle::new(&coefficients).map_err(parameter_error)?;
        let state = State {
            nu: p.initial.velocity.into(),
            ..State::at_rest(p.initial.position.into(), p.initial.attitude.into())
        };
        Ok(Self { vehicle, initial: state.into() })
    }

    fn initial(&self, _: Time, _: &Inputs) -> Result<(States, ()), Fault> {
        Ok((self.initial, ()))
    }

    fn derivatives(&self, _: f64, (): &(), x: &States, u: &Inputs) -> States {
        self.vehicle.derivative(&x.into(), &u.into()).into()
    }

    fn held_derivatives(&self, (): &(), u: &Inputs) -> impl Fn(f64, &States) -> States {
        let drive = self.vehicle.drive(&u.into());
        move |_, x| self.vehicle.rate(&x.into(), &drive).into()
    }

    #[inline]
    fn outputs(&self, _: f64, (): &(), x: &States, u: &Inputs) -> Outputs {
        self.vehicle.outputs(&x.into(), &u.into()).into()
    }

    fn tangent(
        &self,
        _: f64,
        (): &(),
        x: &States,
        u: &Inputs,
        dx: &States,
        du: &Inputs,
    ) -> (States, Outputs) {
        let (x, u) = (x.into(), u.into());
        let (derivatives, outputs) = self.vehicle.tangent(&x, &u).along(&dx.into(), &du.into());
        (derivatives.into(), outputs.into())
    }

    fn indicators(&self, _: f64, (): &(), _: &States, u: &Inputs, indicators: &mut [f64]) {
        let (limit, reversal) = self.vehicle.kinks(&u.into());
        for (indicator, kink) in indicators.iter_mut().zip(limit.into_iter().chain(reversal)) {
            *indicator = kink;
        }
    }

    fn initial_tangent(
        &self,
        x: &States,
        u: &Inputs,
        p: &Parameters,
        dp: &Parameters,
        _: &Inputs,
    ) -> (States, States, Outputs) {
        let coefficients = |p: &Parameters| p.coefficients.with_mode(p.thruster_mode.into());
        let along = Sensitivity::new(&coefficients(p), &coefficients(dp));
        let (x, u) = (x.into(), u.into());
        let (derivatives, outputs) = self.vehicle.tangent(&x, &u).with_coefficients(&along);
        let Start { position, attitude, velocity } = dp.initial;
        let turned = State::d_at_rest(position.into(), p.initial.attitude.into(), attitude.into());
        let states = State { nu: velocity.into(), ..turned };
        (states.into(), derivatives.into(), outputs.into())
    }
}
