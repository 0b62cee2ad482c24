//! What the command line changes of a system description.

use clap::Args;
use cosim::fmi::InterfaceType;
use cosim::{Algorithm, Overrides};

use super::solver::Solver;
use super::stepping::Stepping;
use super::values;

/// Changes to the file.
#[derive(Args)]
pub(crate) struct Changes {
    /// Give a parameter or input another start value (repeatable)
    #[arg(long, value_name = "COMPONENT.VARIABLE=VALUE", value_parser = values::assignment)]
    start_value: Vec<(String, String)>,
    /// Put another FMU in the place of a component's (repeatable)
    #[arg(long, value_name = "COMPONENT=FMU", value_parser = values::assignment)]
    replace: Vec<(String, String)>,
    /// Leave out a component that no other one needs (repeatable)
    #[arg(long, value_name = "COMPONENT")]
    without: Vec<String>,
    /// Step a component by this many seconds; * and ? stand for parts of names (repeatable)
    #[arg(long, value_name = "COMPONENT=SECONDS", value_parser = values::step)]
    step: Vec<(String, f64)>,
    /// Step all components by this many seconds, but those named by --step
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds)]
    step_size: Option<f64>,
    /// jacobi: all inputs are of the step's beginning; gauss-seidel: with direct feed-through of
    /// its end; iterative: and algebraic loops are solved at each step
    #[arg(long)]
    algorithm: Option<Algorithm>,
    /// Drive a component's FMU by model exchange or by co-simulation; * and ? stand for parts of
    /// names (repeatable)
    #[arg(long, value_name = "COMPONENT=me|cs", value_parser = values::interface)]
    interface_type: Vec<(String, InterfaceType)>,
    #[command(flatten)]
    solver: Solver,
    /// The tools that FMUs need (needsExecutionTool) are installed here
    #[arg(long)]
    execution_tool: bool,
    #[command(flatten)]
    stepping: Stepping,
    /// First instant
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds, allow_negative_numbers = true)]
    start_time: Option<f64>,
    /// Last instant
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds, allow_negative_numbers = true)]
    stop_time: Option<f64>,
}

impl Changes {
    /// Whether FMUs may start their tools.
    pub(crate) fn starts_tools(&self) -> bool {
        self.execution_tool
    }

    /// Start values that are files, such as courses.
    pub(crate) fn files(&self) -> impl Iterator<Item = String> {
        let values = self.start_value.iter().map(|(_, value)| value);
        values.filter(|value| std::path::Path::new(value).is_file()).cloned()
    }

    pub(crate) fn overrides(&self) -> Overrides {
        let mut overrides = Overrides::new().execution_tools(self.execution_tool);
        for (name, value) in &self.start_value {
            overrides = overrides.start_value(name, value);
        }
        for (component, fmu) in &self.replace {
            overrides = overrides.replace(component, fmu);
        }
        for component in &self.without {
            overrides = overrides.without(component);
        }
        if let Some(seconds) = self.step_size {
            overrides = overrides.step("", seconds);
        }
        for (component, seconds) in &self.step {
            overrides = overrides.step(component, *seconds);
        }
        if let Some(algorithm) = self.algorithm {
            overrides = overrides.algorithm(algorithm);
        }
        if let Some(seconds) = self.start_time {
            overrides = overrides.start_time(seconds);
        }
        if let Some(seconds) = self.stop_time {
            overrides = overrides.stop_time(seconds);
        }
        for (component, kind) in &self.interface_type {
            overrides = overrides.interface(component, *kind);
        }
        self.stepping.add_to(self.solver.add_to(overrides))
    }
}
