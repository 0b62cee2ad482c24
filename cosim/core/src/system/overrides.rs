//! Changes to a system description for a run.

use std::fmt::Display;
use std::path::PathBuf;
use std::sync::Arc;

use super::{Algorithm, Input};
use crate::solver::{Method, Settings};
use cosim_base::error::{Code, Error, Result};
use cosim_base::names;
use cosim_import::{InterfaceType, Logging, Trace};

/// Changes to a system description, from the command line or from code.
///
/// ```
/// let overrides = cosim_core::Overrides::new()
///     .start_value("gps.seed", 7)
///     .replace("estimator", "other.fmu")
///     .stop_time(300.0);
/// ```
#[derive(Debug, Clone, Default)]
pub struct Overrides {
    pub(super) start_values: Vec<(String, String)>,
    pub(super) replacements: Vec<(String, PathBuf)>,
    pub(super) without: Vec<String>,
    pub(super) steps: Vec<(String, f64)>,
    pub(super) interfaces: Vec<(String, InterfaceType)>,
    pub(super) method: Option<Method>,
    pub(super) tolerance: Option<f64>,
    pub(super) algorithm: Option<Algorithm>,
    pub(super) inputs: Vec<(String, Input)>,
    pub(super) step_control: Option<f64>,
    pub(super) retries: u32,
    pub(super) start_time: Option<f64>,
    pub(super) stop_time: Option<f64>,
    pub(super) output_interval: Option<f64>,
    pub(super) output_variables: Vec<String>,
    pub(super) logging: Logging,
    pub(super) execution_tools: bool,
}

impl Overrides {
    /// No changes.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the start value of `component.variable`; the text is parsed according to the variable's
    /// type.
    #[must_use]
    pub fn start_value(mut self, variable: impl Into<String>, value: impl Display) -> Self {
        self.start_values.push((variable.into(), value.to_string()));
        self
    }

    /// Replaces the FMU of a component, or of those that match a pattern (`*`, `?`).
    #[must_use]
    pub fn replace(mut self, component: impl Into<String>, fmu: impl Into<PathBuf>) -> Self {
        self.replacements.push((component.into(), fmu.into()));
        self
    }

    /// Omits a component that no other component needs. It is omitted when the file is read, so
    /// also in all systems that [`System::with`](super::System::with) derives from a system without
    /// it.
    #[must_use]
    pub fn without(mut self, component: impl Into<String>) -> Self {
        self.without.push(component.into());
        self
    }

    /// The communication step of a component in seconds.
    #[must_use]
    pub fn step(mut self, component: impl Into<String>, seconds: f64) -> Self {
        self.steps.push((component.into(), seconds));
        self
    }

    /// Uses co-simulation or model exchange for the FMU of a component.
    #[must_use]
    pub fn interface(mut self, component: impl Into<String>, kind: InterfaceType) -> Self {
        self.interfaces.push((component.into(), kind));
        self
    }

    /// The solver for model exchange.
    #[must_use]
    pub fn solver(mut self, method: Method) -> Self {
        self.method = Some(method);
        self
    }

    /// The relative tolerance of model exchange, which FMUs for co-simulation get, too.
    #[must_use]
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = Some(tolerance);
        self
    }

    /// The algorithm.
    #[must_use]
    pub fn algorithm(mut self, algorithm: Algorithm) -> Self {
        self.algorithm = Some(algorithm);
        self
    }

    /// What inputs do during a step: all inputs for the name `""`, otherwise those named
    /// `component.variable`, which is a pattern if it contains `*` or `?`. Later calls take
    /// precedence.
    #[must_use]
    pub fn input(mut self, name: impl Into<String>, input: Input) -> Self {
        self.inputs.push((name.into(), input));
        self
    }

    /// Adapts the length of the communication steps to this relative tolerance.
    #[must_use]
    pub fn step_control(mut self, tolerance: f64) -> Self {
        self.step_control = Some(tolerance);
        self
    }

    /// Repeats a step that an FMU discards with smaller steps, reduced up to this many times.
    #[must_use]
    pub fn retries(mut self, retries: u32) -> Self {
        self.retries = retries;
        self
    }

    /// The start time in seconds.
    #[must_use]
    pub fn start_time(mut self, seconds: f64) -> Self {
        self.start_time = Some(seconds);
        self
    }

    /// The stop time in seconds.
    #[must_use]
    pub fn stop_time(mut self, seconds: f64) -> Self {
        self.stop_time = Some(seconds);
        self
    }

    /// Time between recorded samples in seconds.
    #[must_use]
    pub fn output_interval(mut self, seconds: f64) -> Self {
        self.output_interval = Some(seconds);
        self
    }

    /// Records this variable, or those that match the pattern (`*`, `?`).
    #[must_use]
    pub fn output_variable(mut self, pattern: impl Into<String>) -> Self {
        self.output_variables.push(pattern.into());
        self
    }

    /// Records all of these.
    #[must_use]
    pub fn output_variables<T: Into<String>>(
        mut self,
        patterns: impl IntoIterator<Item = T>,
    ) -> Self {
        self.output_variables.extend(patterns.into_iter().map(Into::into));
        self
    }

    /// The tools that FMUs need (needsExecutionTool) are installed: such FMUs are not refused.
    #[must_use]
    pub fn execution_tools(mut self, installed: bool) -> Self {
        self.execution_tools = installed;
        self
    }

    /// Requests debug messages from the FMUs; they are shown in the error if one fails.
    #[must_use]
    pub fn debug_logging(mut self, on: bool) -> Self {
        self.logging.debug = on;
        self
    }

    /// Requests only the debug messages of this category, and of others named in this way.
    #[must_use]
    pub fn log_category(mut self, category: impl Into<String>) -> Self {
        self.logging.categories.push(category.into());
        self
    }

    /// Receives messages, and calls if requested, immediately.
    #[must_use]
    pub fn trace(mut self, trace: Arc<Trace>) -> Self {
        self.logging.trace = Some(trace);
        self
    }

    /// How model exchange is integrated; `suggested` is the tolerance of an FMU.
    pub(super) fn settings(&self, suggested: Option<f64>) -> Result<Settings> {
        let default = Settings::default();
        let usable = |tolerance: f64| tolerance > 0.0 && tolerance < 1.0;
        let suggested = suggested.filter(|t| usable(*t)).unwrap_or(default.tolerance);
        let tolerance = self.tolerance.unwrap_or(suggested);
        if !usable(tolerance) {
            return Err(Error::new(Code::Timing, format!("the tolerance is {tolerance}"))
                .why("it is relative and must lie between 0 and 1"));
        }
        Ok(Settings { method: self.method.unwrap_or(default.method), tolerance })
    }

    /// The interface type requested for a component, if any.
    pub(super) fn interface_of(&self, component: &str) -> Option<InterfaceType> {
        of(&self.interfaces, component).copied()
    }

    pub(super) fn step_of(&self, component: &str) -> Option<f64> {
        of(&self.steps, component).copied()
    }

    pub(super) fn replacement_of(&self, component: &str) -> Option<&PathBuf> {
        of(&self.replacements, component)
    }
}

/// The setting for a component: by its name, otherwise by a pattern, otherwise for all. Later ones
/// take precedence.
fn of<'r, T>(requests: &'r [(String, T)], component: &str) -> Option<&'r T> {
    let last = |fits: &dyn Fn(&str) -> bool| {
        requests.iter().rev().find(|(name, _)| fits(name)).map(|(_, wanted)| wanted)
    };
    last(&|name| name == component)
        .or_else(|| last(&|name| names::is_pattern(name) && names::matches(name, component)))
        .or_else(|| last(&str::is_empty))
}

/// Whether a request applies to one of these components.
pub(super) fn is_for(request: &str, component: &str) -> bool {
    request.is_empty() || request == component || names::matches(request, component)
}
