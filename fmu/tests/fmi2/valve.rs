//! A component with inputs and outputs other than Reals and parameters that change during a
//! simulation.

use fmu_kit::{Component, Enumeration, Info, ParameterError, Resources, Text, Variables};

/// Where a valve is
#[derive(Clone, Copy, Debug, Default, PartialEq, Enumeration)]
pub enum Mode {
    /// Nothing flows
    #[default]
    Shut,
    /// It flows
    Open,
}

#[derive(Clone, Variables)]
pub struct Settings {
    /// Flow through the open valve
    #[var(unit = "m3/s", start = 2.0, min = 0.0, tunable)]
    pub capacity: f64,
    /// Pulses of a unit of volume
    #[var(start = 10, tunable)]
    pub pulses: i32,
    /// Pulses at the start
    pub first: i32,
}

#[derive(Clone, Copy, Variables)]
pub struct Commands {
    /// Whether there is power
    #[var(start = true)]
    pub powered: bool,
    /// What is wanted
    pub mode: Mode,
    /// Pulses of others
    pub others: i32,
    /// Who commands it
    pub by: Text<16>,
    /// Part of the flow
    #[var(start = 1.0)]
    pub part: f64,
}

#[derive(Clone, Copy, Default, Variables)]
pub struct Shown {
    /// Whether it flows
    pub flowing: bool,
    /// Where the valve is
    pub is: Mode,
    /// Pulses
    pub count: i32,
    /// Who commands it, and what
    pub label: Text<24>,
    /// Flow
    #[var(unit = "m3/s")]
    pub flow: f64,
}

#[derive(Clone, Copy, Default, Variables)]
pub struct Volume {
    /// Volume that has passed
    #[var(unit = "m3")]
    pub volume: f64,
}

pub struct Valve(Settings);

impl Valve {
    fn flow(&self, u: &Commands) -> f64 {
        let open = u.powered && u.mode == Mode::Open;
        if open { self.0.capacity * u.part } else { 0.0 }
    }
}

impl Component for Valve {
    const INFO: Info = Info::new("Valve", "A valve with a meter");
    type Parameters = Settings;
    type Inputs = Commands;
    type Outputs = Shown;
    type States = Volume;
    type Memory = ();

    fn new(settings: &Settings, _: &Resources) -> Result<Self, ParameterError> {
        Ok(Self(settings.clone()))
    }

    fn derivatives(&self, _: f64, (): &(), _: &Volume, u: &Commands) -> Volume {
        Volume { volume: self.flow(u) }
    }

    fn outputs(&self, _: f64, (): &(), x: &Volume, u: &Commands) -> Shown {
        let flow = self.flow(u);
        let own = (x.volume * f64::from(self.0.pulses) + 1e-9).floor() as i32;
        let count = self.0.first + own + u.others;
        let label = Text::new(&format!("{}: {:?}", u.by.as_str(), u.mode));
        Shown { flowing: flow > 0.0, is: u.mode, count, label, flow }
    }
}
