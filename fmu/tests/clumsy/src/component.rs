//! A component that panics on command.

use fmu_kit::{Component, Fault, Info, NoStates, ParameterError, Resources, Time, Variables};

/// Input.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Command {
    /// Panics while this is not 0
    pub panic: f64,
}

/// Output.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Echo {
    /// The input
    pub echo: f64,
}

/// Panics on command.
pub struct Clumsy;

impl Component for Clumsy {
    const INFO: Info = Info::new("Clumsy", "Panics on command");
    type Parameters = ();
    type Inputs = Command;
    type Outputs = Echo;
    type States = NoStates;
    type Memory = ();

    fn new((): &(), _: &Resources) -> Result<Self, ParameterError> {
        Ok(Self)
    }

    fn initial(&self, _: Time, _: &Command) -> Result<(NoStates, ()), Fault> {
        Ok(((), ()))
    }

    fn outputs(&self, _: f64, (): &(), (): &NoStates, u: &Command) -> Echo {
        assert!(u.panic == 0.0, "told to panic");
        Echo { echo: u.panic }
    }
}
