//! `cosim simulate`: simulates one FMU.

use std::path::PathBuf;

use clap::Args;
use cosim::fmi::InterfaceType;
use cosim::{Overrides, Recording, Result, System};

use super::interrupt;
use super::isolate::{self, Isolation};
use super::logging::Logging;
use super::output::Output;
use super::problems;
use super::solver::Solver;
use super::stepping::Stepping;
use super::values;

/// Simulate one FMU
#[derive(Args)]
pub(crate) struct Simulate {
    /// The FMU
    file: PathBuf,
    /// Set another start value for a parameter or input (repeatable)
    #[arg(long, value_name = "VARIABLE=VALUE", value_parser = values::assignment)]
    start_value: Vec<(String, String)>,
    /// Drive inputs by the columns of this CSV file, whose first column is the time
    #[arg(long, value_name = "FILE")]
    input_file: Option<PathBuf>,
    /// Start time (default: of the FMU, or 0)
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds, allow_negative_numbers = true)]
    start_time: Option<f64>,
    /// Stop time (default: of the FMU, or one second after the start)
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds, allow_negative_numbers = true)]
    stop_time: Option<f64>,
    /// Communication step (default: of the FMU, or the output interval)
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds)]
    step_size: Option<f64>,
    /// me: model exchange with our solver, cs: co-simulation (default: cs if the FMU supports it)
    #[arg(long, value_name = "me|cs")]
    interface_type: Option<InterfaceType>,
    #[command(flatten)]
    solver: Solver,
    #[command(flatten)]
    stepping: Stepping,
    /// The tool that the FMU needs (needsExecutionTool) is installed here
    #[arg(long)]
    execution_tool: bool,
    #[command(flatten)]
    logging: Logging,
    #[command(flatten)]
    output: Output,
    #[command(flatten)]
    isolation: Isolation,
}

impl Simulate {
    pub(crate) fn run(self) -> Result<u8> {
        interrupt::begin();
        problems::reported(self.output.format, self.computed())
    }

    fn computed(&self) -> Result<u8> {
        self.isolation.check(false)?;
        let overrides = match self.isolation.wanted() {
            true => self.overrides(),
            false => self.logging.add_to(self.overrides())?,
        };
        let inputs = self.input_file.as_ref().map(Recording::read_csv).transpose()?;
        let system = System::single(&self.file, &overrides, inputs.as_ref().map(Recording::table))?;
        if self.isolation.wanted() {
            self.output.unwatched()?;
            let written = self.output.written(&system, self.logging.file())?;
            return isolate::supervise(written, self.execution_tool);
        }
        self.logging.begin()?;
        interrupt::watch();
        let shut = || self.isolation.shut(self.execution_tool);
        self.output.run(&system, None, &shut).map(|()| 0)
    }

    fn overrides(&self) -> Overrides {
        let mut overrides =
            self.output.add_to(Overrides::new().execution_tools(self.execution_tool));
        for (name, value) in &self.start_value {
            overrides = overrides.start_value(name, value);
        }
        if let Some(seconds) = self.start_time {
            overrides = overrides.start_time(seconds);
        }
        if let Some(seconds) = self.stop_time {
            overrides = overrides.stop_time(seconds);
        }
        if let Some(seconds) = self.step_size {
            overrides = overrides.step("", seconds);
        }
        if let Some(kind) = self.interface_type {
            overrides = overrides.interface("", kind);
        }
        self.stepping.add_to(self.solver.add_to(overrides))
    }
}
