//! `cosim run`: a system.

use std::path::PathBuf;

use clap::Args;
use cosim::{Algorithm, Overrides, Result, System};

use super::output::Output;
use super::values;

/// Run a system description (.ssd) or package (.ssp)
#[derive(Args)]
pub(crate) struct Run {
    /// The system
    file: PathBuf,
    #[command(flatten)]
    changes: Changes,
    #[command(flatten)]
    output: Output,
}

/// Changes to the file.
#[derive(Args)]
struct Changes {
    /// Give a parameter or input another start value (repeatable)
    #[arg(long, value_name = "COMPONENT.VARIABLE=VALUE", value_parser = values::assignment)]
    start_value: Vec<(String, String)>,
    /// Put another FMU in the place of a component's (repeatable)
    #[arg(long, value_name = "COMPONENT=FMU", value_parser = values::assignment)]
    replace: Vec<(String, String)>,
    /// Step a component by this many seconds (repeatable)
    #[arg(long, value_name = "COMPONENT=SECONDS", value_parser = values::step)]
    step: Vec<(String, f64)>,
    /// jacobi: all inputs are of the step's beginning; gauss-seidel: with direct feed-through of
    /// its end
    #[arg(long)]
    algorithm: Option<Algorithm>,
    /// First instant
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds, allow_negative_numbers = true)]
    start_time: Option<f64>,
    /// Last instant
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds, allow_negative_numbers = true)]
    stop_time: Option<f64>,
    /// Ask the FMUs for debug messages, which are shown when one fails
    #[arg(long)]
    debug_logging: bool,
}

impl Run {
    pub(crate) fn run(self) -> Result<()> {
        let overrides = self.overrides();
        self.output.run(&System::load(&self.file, &overrides)?)
    }

    fn overrides(&self) -> Overrides {
        let changes = &self.changes;
        let mut overrides = Overrides::new()
            .debug_logging(changes.debug_logging)
            .output_variables(&self.output.output_variable);
        for (name, value) in &changes.start_value {
            overrides = overrides.start_value(name, value);
        }
        for (component, fmu) in &changes.replace {
            overrides = overrides.replace(component, fmu);
        }
        for (component, seconds) in &changes.step {
            overrides = overrides.step(component, *seconds);
        }
        if let Some(algorithm) = changes.algorithm {
            overrides = overrides.algorithm(algorithm);
        }
        if let Some(seconds) = changes.start_time {
            overrides = overrides.start_time(seconds);
        }
        if let Some(seconds) = changes.stop_time {
            overrides = overrides.stop_time(seconds);
        }
        match self.output.output_interval {
            Some(seconds) => overrides.output_interval(seconds),
            None => overrides,
        }
    }
}
