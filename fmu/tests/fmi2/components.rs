//! Components for the tests: a mass on a spring (continuous), a sampled noise source, a component
//! that fails on demand.

use fmu_kit::{
    Component, Enumeration, Fault, Info, NoStates, ParameterError, Resources, Sampler, Time,
    Variables,
};
use serde::{Deserialize, Serialize};

#[path = "valve.rs"]
pub mod valve;

/// Named set of parameters
#[derive(Clone, Copy, Debug, Default, PartialEq, Enumeration)]
pub enum Set {
    /// A light mass
    #[default]
    Light,
    /// A heavy mass
    Heavy,
}

#[derive(Clone, Debug, Variables)]
pub struct SpringParameters {
    /// Which parameter set the others come from
    pub parameter_set: Set,
    /// Mass
    #[var(unit = "kg", min = 1e-3)]
    pub mass: f64,
    /// Stiffness
    #[var(unit = "N/m", min = 0.0)]
    pub stiffness: f64,
    /// Start position
    #[var(unit = "m")]
    pub start: f64,
    /// Sign of the force: 1 or -1
    #[var(min = -1, max = 1)]
    pub sign: i32,
    /// Whether the spring is there
    pub sprung: bool,
    /// A name, of no consequence
    pub label: String,
}

impl Default for SpringParameters {
    fn default() -> Self {
        Self {
            parameter_set: Set::Light,
            mass: 1.0,
            stiffness: 4.0,
            start: 1.0,
            sign: 1,
            sprung: true,
            label: "none".to_owned(),
        }
    }
}

#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Force {
    /// Force on the mass
    #[var(unit = "N", nominal = 10.0)]
    pub force: f64,
}

#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Motion {
    /// Position
    #[var(unit = "m")]
    pub x: f64,
    /// Velocity
    #[var(unit = "m/s", nominal = 2.0)]
    pub v: f64,
}

#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct SpringStates {
    /// State
    pub state: Motion,
}

#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct SpringOutputs {
    /// Position
    #[var(unit = "m")]
    pub position: f64,
    /// Acceleration
    #[var(unit = "m/s2")]
    pub acceleration: f64,
}

pub struct Spring {
    p: SpringParameters,
}

impl Spring {
    fn acceleration(&self, x: &SpringStates, u: &Force) -> f64 {
        let spring = if self.p.sprung { self.p.stiffness * x.state.x } else { 0.0 };
        (f64::from(self.p.sign) * u.force - spring) / self.p.mass
    }
}

impl Component for Spring {
    const INFO: Info = Info {
        integrator_step_s: 0.001,
        version: "1 < 2",
        ..Info::new("Spring", "A mass on a \"spring\" & nothing else")
    };
    type Parameters = SpringParameters;
    type Inputs = Force;
    type Outputs = SpringOutputs;
    type States = SpringStates;
    type Memory = ();

    fn preset(selected: &SpringParameters) -> SpringParameters {
        match selected.parameter_set {
            Set::Light => SpringParameters::default(),
            Set::Heavy => SpringParameters {
                parameter_set: Set::Heavy,
                mass: 100.0,
                stiffness: 400.0,
                start: 2.0,
                ..SpringParameters::default()
            },
        }
    }

    fn new(p: &SpringParameters, resources: &Resources) -> Result<Self, ParameterError> {
        if p.label == "from file" {
            let label = resources.read_to_string("label", "label.txt")?;
            return Ok(Self { p: SpringParameters { label, ..p.clone() } });
        }
        if p.mass == 13.0 {
            return Err(ParameterError::new("mass", "13 kg brings bad luck; choose another"));
        }
        Ok(Self { p: p.clone() })
    }

    fn initial(&self, _: Time, _: &Force) -> Result<(SpringStates, ()), Fault> {
        Ok((SpringStates { state: Motion { x: self.p.start, v: 0.0 } }, ()))
    }

    fn derivatives(&self, _: f64, (): &(), x: &SpringStates, u: &Force) -> SpringStates {
        SpringStates { state: Motion { x: x.state.v, v: self.acceleration(x, u) } }
    }

    fn outputs(&self, _: f64, (): &(), x: &SpringStates, u: &Force) -> SpringOutputs {
        SpringOutputs { position: x.state.x, acceleration: self.acceleration(x, u) }
    }
}

#[derive(Clone, Debug, Variables)]
pub struct NoiseParameters {
    /// Sampling rate
    #[var(unit = "Hz", min = 1e-3)]
    pub rate: f64,
    /// Seed of the noise
    pub seed: i32,
}

impl Default for NoiseParameters {
    fn default() -> Self {
        Self { rate: 7.0, seed: 1 }
    }
}

#[derive(Clone, Copy, Debug, Variables)]
pub struct Signal {
    /// What is measured
    pub signal: f64,
    /// 0: no new samples
    #[var(min = 0.0, max = 1.0)]
    pub enabled: f64,
    /// Not used by anything
    pub ignored: f64,
}

impl Default for Signal {
    fn default() -> Self {
        Self { signal: 0.0, enabled: 1.0, ignored: 0.0 }
    }
}

#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Sample {
    /// Signal with noise
    pub value: f64,
    /// Samples taken
    pub count: f64,
    /// Time of the newest sample
    #[var(unit = "s")]
    pub stamp: f64,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct NoiseMemory {
    sampler: Sampler,
    random: u64,
    newest: Sample,
}

pub struct Noise {
    period_s: f64,
    seed: u64,
}

impl Noise {
    fn sample(&self, now: Time, m: &mut NoiseMemory, u: &Signal) {
        if u.enabled < 0.5 {
            return;
        }
        m.random = m.random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let noise = (m.random >> 40) as f64 * 1e-9;
        let count = m.newest.count + 1.0;
        m.newest = Sample { value: u.signal + noise, count, stamp: now.seconds() };
    }
}

impl Component for Noise {
    const INFO: Info = Info { sampled: true, ..Info::new("Noise", "Samples a signal with noise") };
    type Parameters = NoiseParameters;
    type Inputs = Signal;
    type Outputs = Sample;
    type States = NoStates;
    type Memory = NoiseMemory;

    fn new(p: &NoiseParameters, _: &Resources) -> Result<Self, ParameterError> {
        Ok(Self { period_s: 1.0 / p.rate, seed: p.seed as u64 })
    }

    fn initial(&self, start: Time, u: &Signal) -> Result<(NoStates, NoiseMemory), Fault> {
        let sampler = Sampler::new(start, self.period_s);
        let mut memory = NoiseMemory { sampler, random: self.seed, newest: Sample::default() };
        self.sample(start, &mut memory, u);
        Ok(((), memory))
    }

    fn outputs(&self, _: f64, m: &NoiseMemory, (): &NoStates, _: &Signal) -> Sample {
        m.newest
    }

    fn next_event(&self, m: &NoiseMemory) -> Option<Time> {
        Some(m.sampler.next())
    }

    fn event(
        &self,
        now: Time,
        m: &mut NoiseMemory,
        (): &mut NoStates,
        u: &Signal,
    ) -> Result<(), Fault> {
        m.sampler.advance();
        self.sample(now, m, u);
        Ok(())
    }
}

/// Commands of the component that fails.
pub mod command {
    pub const PANIC: f64 = 1.0;
    pub const FAULT: f64 = 2.0;
    pub const NOT_FINITE: f64 = 3.0;
    pub const STUCK: f64 = 4.0;
    pub const PANIC_AT_LENGTH: f64 = 5.0;
}

#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Command {
    /// What to do
    pub command: f64,
}

#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Echo {
    /// The command
    pub echo: f64,
    /// Always the same
    pub constant: f64,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Clumsiness {
    sampler: Sampler,
}

pub struct Clumsy;

impl Component for Clumsy {
    const INFO: Info = Info { sampled: true, ..Info::new("Clumsy", "Fails on command") };
    type Parameters = ();
    type Inputs = Command;
    type Outputs = Echo;
    type States = NoStates;
    type Memory = Clumsiness;

    fn new((): &(), _: &Resources) -> Result<Self, ParameterError> {
        Ok(Self)
    }

    fn initial(&self, start: Time, _: &Command) -> Result<(NoStates, Clumsiness), Fault> {
        Ok(((), Clumsiness { sampler: Sampler::new(start, 0.1) }))
    }

    fn outputs(&self, _: f64, _: &Clumsiness, (): &NoStates, u: &Command) -> Echo {
        let not_finite = u.command == command::NOT_FINITE;
        let echo = if not_finite { f64::NAN } else { u.command };
        Echo { echo, constant: 1.0 }
    }

    fn next_event(&self, m: &Clumsiness) -> Option<Time> {
        Some(m.sampler.next())
    }

    fn event(
        &self,
        _: Time,
        m: &mut Clumsiness,
        (): &mut NoStates,
        u: &Command,
    ) -> Result<(), Fault> {
        match u.command {
            command::PANIC => panic!("told to, {}", u.command),
            command::PANIC_AT_LENGTH => assert_eq!(u.command, 0.0, "with\na second line"),
            command::FAULT => return Err(Fault::new("told to fail")),
            command::STUCK => return Ok(()),
            _ => m.sampler.advance(),
        }
        Ok(())
    }
}

/// A component whose author offers it for co-simulation only.
pub struct Solitary;

impl Component for Solitary {
    const INFO: Info =
        Info { model_exchange: false, ..Info::new("Solitary", "Co-simulation only") };
    type Parameters = ();
    type Inputs = ();
    type Outputs = ();
    type States = NoStates;
    type Memory = ();

    fn new((): &(), _: &Resources) -> Result<Self, ParameterError> {
        Ok(Self)
    }

    fn initial(&self, _: Time, (): &()) -> Result<(NoStates, ()), Fault> {
        Ok(((), ()))
    }

    fn outputs(&self, _: f64, (): &(), (): &NoStates, (): &()) {}
}

use crate::hybrid::{Ball, Chatterer, Clipper, Limiter, Pendulum};

fmu_kit::export!(
    Spring,
    Noise,
    Clumsy,
    Solitary,
    Ball,
    Limiter,
    Chatterer,
    Pendulum,
    Clipper,
    valve::Valve
);
