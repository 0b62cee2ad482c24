//! How communication steps are made, whatever the algorithm.

use clap::Args;
use cosim::{Input, Overrides};

use super::values;

#[derive(Args)]
pub(crate) struct Stepping {
    /// What inputs do during a step: hold their value, or change linearly (second order); for all
    /// inputs, or for a name or pattern (repeatable)
    #[arg(long, value_name = "[COMPONENT.INPUT=]hold|linear", value_parser = values::input)]
    input: Vec<(String, Input)>,
    /// Adapt the communication step to this relative tolerance: steps with a greater error are
    /// rejected
    #[arg(long, value_name = "TOLERANCE")]
    step_control: Option<f64>,
    /// Repeat a step that an FMU discards with smaller steps, reduced up to N times
    #[arg(long, value_name = "N", default_value_t = 0)]
    retries: u32,
}

impl Stepping {
    pub(crate) fn add_to(&self, overrides: Overrides) -> Overrides {
        let inputs = self.input.iter();
        let overrides =
            inputs.fold(overrides, |overrides, (name, input)| overrides.input(name, *input));
        let overrides = overrides.retries(self.retries);
        match self.step_control {
            Some(tolerance) => overrides.step_control(tolerance),
            None => overrides,
        }
    }
}
