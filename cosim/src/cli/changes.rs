//! Changes to a system description from the command line.

use clap::Args;
use cosim::fmi::InterfaceType;
use cosim::{Algorithm, Overrides};

use super::solver::Solver;
use super::stepping::Stepping;
use super::values;

/// Changes to the file.
#[derive(Args)]
pub(crate) struct Changes {
    /// Set another start value for a parameter or input (repeatable)
    #[arg(long, value_name = "COMPONENT.VARIABLE=VALUE", value_parser = values::assignment)]
    start_value: Vec<(String, String)>,
    /// Replace the FMU of a component; * and ? match parts of names (repeatable)
    #[arg(long, value_name = "COMPONENT=FMU", value_parser = values::assignment)]
    replace: Vec<(String, String)>,
    /// Omit a component that no other component needs (repeatable)
    #[arg(long, value_name = "COMPONENT")]
    without: Vec<String>,
    /// Step a component by this many seconds; * and ? match parts of names (repeatable)
    #[arg(long, value_name = "COMPONENT=SECONDS", value_parser = values::step)]
    step: Vec<(String, f64)>,
    /// Step all components by this many seconds, except those named by --step
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds)]
    step_size: Option<f64>,
    /// jacobi: all inputs are from the start of the step; gauss-seidel: inputs with direct
    /// feed-through are from its end; iterative: also solves algebraic loops at each step
    #[arg(long)]
    algorithm: Option<Algorithm>,
    /// Use model exchange or co-simulation for the FMU of a component; * and ? match parts of names
    /// (repeatable)
    #[arg(long, value_name = "COMPONENT=me|cs", value_parser = values::interface)]
    interface_type: Vec<(String, InterfaceType)>,
    #[command(flatten)]
    solver: Solver,
    /// The tools that FMUs need (needsExecutionTool) are installed here
    #[arg(long)]
    execution_tool: bool,
    #[command(flatten)]
    stepping: Stepping,
    /// Start time
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds, allow_negative_numbers = true)]
    start_time: Option<f64>,
    /// Stop time
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds, allow_negative_numbers = true)]
    stop_time: Option<f64>,
}

impl Changes {
    /// Whether FMUs may start their tools.
    pub(crate) fn starts_tools(&self) -> bool {
        self.execution_tool
    }

    /// Start values that are files, such as course files.
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
