//! The vehicle: `rexrov::vehicle::Vehicle` as a component, six degrees of freedom.

use crate::parameter_error;
use fmu_kit::{Component, Fault, Info, ParameterError, Resources, Time, Variables};
use rexrov::axes;
use rexrov::vehicle::{
    self, Inputs, Outputs, ParameterSet, Sensitivity, State, ThrusterMode, Vehicle,
};

/// State at the start.
///
/// Those of the courses: 20 m deep, at rest.
#[derive(Clone, Copy, Debug, Variables)]
pub struct Start {
    /// position
    #[var(elements = axes::NED, start = [0.0, 0.0, 20.0])]
    pub position: [f64; 3],
    /// attitude
    #[var(elements = axes::EULER)]
    pub attitude: [f64; 3],
    /// velocity over ground, body frame
    #[var(elements = axes::VELOCITY)]
    pub velocity: [f64; 6],
}

/// Parameters of the vehicle.
#[derive(Clone, Debug, Default, Variables)]
pub struct Parameters {
    /// Named set that gives every coefficient not set otherwise
    pub parameter_set: ParameterSet,
    /// Meaning of the thruster inputs
    pub thruster_mode: ThrusterMode,
    /// State at the start
    pub initial: Start,
    /// Coefficients.
    #[var(flatten)]
    pub coefficients: vehicle::Parameters,
}

impl Parameters {
    /// The coefficients with the meaning of the thruster inputs.
    fn vehicle(&self) -> vehicle::Parameters {
        let mut coefficients = self.coefficients;
        coefficients.propulsion.mode = self.thruster_mode;
        coefficients
    }
}

/// Continuous states, separated from the outputs by their own name.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct States {
    /// State
    pub state: State,
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
    type Inputs = Inputs;
    type Outputs = Outputs;
    type States = States;
    type Memory = ();

    fn preset(selected: &Parameters) -> Parameters {
        let coefficients = vehicle::Parameters::preset(selected.parameter_set);
        Parameters { coefficients, ..Parameters::default() }
    }

    fn new(p: &Parameters, _: &Resources) -> Result<Self, ParameterError> {
        let vehicle = Vehicle::new(&p.vehicle()).map_err(parameter_error)?;
        let Start { position, attitude, velocity } = p.initial;
        Ok(Self { vehicle, initial: State { nu: velocity, ..State::at_rest(position, attitude) } })
    }

    fn initial(&self, _: Time, _: &Inputs) -> Result<(States, ()), Fault> {
        Ok((States { state: self.initial }, ()))
    }

    fn derivatives(&self, _: f64, (): &(), x: &States, u: &Inputs) -> States {
        States { state: self.vehicle.derivative(&x.state, u) }
    }

    fn held_derivatives(
        &self,
        (): &(),
        u: &Inputs,
    ) -> impl Fn(f64, &States, Option<&Outputs>) -> States {
        let drive = self.vehicle.drive(u);
        move |_, States { state }, known| States {
            state: match known {
                Some(y) => self.vehicle.rate_beside(state, y, &drive),
                None => self.vehicle.rate(state, &drive),
            },
        }
    }

    #[inline]
    fn held_step(&self, (): &(), u: &Inputs) -> impl Fn(&mut States, f64, f64, Option<&Outputs>) {
        let drive = self.vehicle.drive(u);
        move |States { state }, _, h, known| self.vehicle.advance(state, &drive, h, known)
    }

    #[inline]
    fn outputs(&self, _: f64, (): &(), x: &States, u: &Inputs) -> Outputs {
        self.vehicle.outputs(&x.state, u)
    }

    #[inline(always)]
    fn tangent(
        &self,
        _: f64,
        (): &(),
        x: &States,
        u: &Inputs,
        dx: &States,
        du: &Inputs,
    ) -> (States, Outputs) {
        let (state, outputs) = self.vehicle.tangent(&x.state, u).along(&dx.state, du);
        (States { state }, outputs)
    }

    fn indicators(&self, _: f64, (): &(), _: &States, u: &Inputs, indicators: &mut [f64]) {
        let (limit, reversal) = self.vehicle.kinks(u);
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
        let along = Sensitivity::new(&p.vehicle(), &dp.vehicle());
        let (rate, outputs) = self.vehicle.tangent(&x.state, u).with_coefficients(&along);
        let Start { position, attitude, velocity } = dp.initial;
        let turned = State::d_at_rest(position, p.initial.attitude, attitude);
        let state = State { nu: velocity, ..turned };
        (States { state }, States { state: rate }, outputs)
    }
}
