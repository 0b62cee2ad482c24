//! The vehicle: `rexrov::vehicle::Vehicle` with FMI variables, six degrees of freedom.

use crate::coefficients::{Coefficients, ParameterSet};
use crate::direct::Direct;
use crate::groups::{Attitude, Position, Velocity, parameter_error};
use fmu_kit::{Component, Enumeration, Fault, Info, ParameterError, Resources, Time, Variables};
use rexrov::vehicle::{self, Inputs, Outputs, Sensitivity, State, Vehicle};

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
    /// The start of the courses, 20 m deep, at rest.
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
    initial: State,
}

impl Component for RexRov {
    const INFO: Info = Info {
        stop_time_s: 60.0,
        // Accurate to a millionth of each signal's peak over a minute in which commands jump.
        integrator_step_s: 0.01,
        moving_step_s: 0.004,
        ..crate::info(
            "RexROV",
            "RexROV underwater vehicle, six degrees of freedom, eight thrusters",
        )
    };
    const INDICATORS: &[&str] = &KINKS;
    const KINKS_OF_INPUTS: bool = true;
    const TANGENT: bool = true;
    type Parameters = Parameters;
    type Inputs = Direct<Inputs>;
    type Outputs = Direct<Outputs>;
    type States = Direct<State>;
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
        let initial = State {
            nu: p.initial.velocity.into(),
            ..State::at_rest(p.initial.position.into(), p.initial.attitude.into())
        };
        Ok(Self { vehicle, initial })
    }

    fn initial(&self, _: Time, _: &Direct<Inputs>) -> Result<(Direct<State>, ()), Fault> {
        Ok((Direct(self.initial), ()))
    }

    fn derivatives(
        &self,
        _: f64,
        (): &(),
        Direct(x): &Direct<State>,
        Direct(u): &Direct<Inputs>,
    ) -> Direct<State> {
        Direct(self.vehicle.derivative(x, u))
    }

    fn held_derivatives(
        &self,
        (): &(),
        Direct(u): &Direct<Inputs>,
    ) -> impl Fn(f64, &Direct<State>, Option<&Direct<Outputs>>) -> Direct<State> {
        let drive = self.vehicle.drive(u);
        move |_, Direct(x), known| {
            Direct(match known {
                Some(Direct(y)) => self.vehicle.rate_beside(x, y, &drive),
                None => self.vehicle.rate(x, &drive),
            })
        }
    }

    #[inline]
    fn held_step(
        &self,
        (): &(),
        Direct(u): &Direct<Inputs>,
    ) -> impl Fn(&mut Direct<State>, f64, f64, Option<&Direct<Outputs>>) {
        let drive = self.vehicle.drive(u);
        move |Direct(x), _, h, known| self.vehicle.advance(x, &drive, h, known.map(|Direct(y)| y))
    }

    #[inline]
    fn outputs(
        &self,
        _: f64,
        (): &(),
        Direct(x): &Direct<State>,
        Direct(u): &Direct<Inputs>,
    ) -> Direct<Outputs> {
        Direct(self.vehicle.outputs(x, u))
    }

    #[inline(always)]
    fn tangent(
        &self,
        _: f64,
        (): &(),
        Direct(x): &Direct<State>,
        Direct(u): &Direct<Inputs>,
        Direct(dx): &Direct<State>,
        Direct(du): &Direct<Inputs>,
    ) -> (Direct<State>, Direct<Outputs>) {
        let (derivatives, outputs) = self.vehicle.tangent(x, u).along(dx, du);
        (Direct(derivatives), Direct(outputs))
    }

    fn indicators(
        &self,
        _: f64,
        (): &(),
        _: &Direct<State>,
        Direct(u): &Direct<Inputs>,
        indicators: &mut [f64],
    ) {
        let (limit, reversal) = self.vehicle.kinks(u);
        for (indicator, kink) in indicators.iter_mut().zip(limit.into_iter().chain(reversal)) {
            *indicator = kink;
        }
    }

    fn initial_tangent(
        &self,
        Direct(x): &Direct<State>,
        Direct(u): &Direct<Inputs>,
        p: &Parameters,
        dp: &Parameters,
        _: &Direct<Inputs>,
    ) -> (Direct<State>, Direct<State>, Direct<Outputs>) {
        let coefficients = |p: &Parameters| p.coefficients.with_mode(p.thruster_mode.into());
        let along = Sensitivity::new(&coefficients(p), &coefficients(dp));
        let (derivatives, outputs) = self.vehicle.tangent(x, u).with_coefficients(&along);
        let Start { position, attitude, velocity } = dp.initial;
        let turned = State::d_at_rest(position.into(), p.initial.attitude.into(), attitude.into());
        let states = State { nu: velocity.into(), ..turned };
        (Direct(states), Direct(derivatives), Direct(outputs))
    }
}
