//! Systems: components, connections, start values and timing, checked once and then immutable.
//!
//! A file becomes `raw` structures, [`Overrides`] are applied to them, and a single check (`check`)
//! turns both into a [`System`] or reports every problem found. `write` writes files of a system
//! again.

mod abilities;
mod check;
mod conversion;
mod delay;
mod function;
mod input;
mod loops;
mod opened;
mod order;
mod overrides;
mod raw;
mod read;
mod single;
mod write;

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::solver;
use cosim_base::error::{Code, Error, Problems, Result};
use cosim_base::time::{Step, Time};
use cosim_import::{Causality, Description, Fmu, InterfaceType, Kind, Logging, Value};

pub use crate::signals::{Numbers, Signal, Signals, Table};
pub use crate::solver::{Method, Settings};
pub use conversion::Conversion;
pub use delay::{Cause, Delay};
pub use function::Function;
pub use input::Input;
pub use order::{Loop, Order};
pub use overrides::Overrides;
pub use raw::RawUnit;
pub use write::{Packed, base_step};

/// A checked system.
pub struct System {
    raw: Option<Arc<raw::RawSystem>>,
    name: String,
    components: Vec<Component>,
    connections: Vec<Connection>,
    ports: Vec<SystemPort>,
    order: Order,
    columns: Vec<Column>,
    start: Time,
    stop: Time,
    output_interval: Step,
    shortened: bool,
    unknown_steps: bool,
    algorithm: Algorithm,
    /// For each connection: whether its input is linear during a step.
    linear: Vec<bool>,
    step_control: Option<f64>,
    retries: u32,
    solver: solver::Settings,
    /// The tolerance that was asked for, instead of those that FMUs suggest.
    tolerance: Option<f64>,
    logging: Logging,
    warnings: Vec<String>,
    notes: Vec<String>,
    sampled: Vec<String>,
}

/// Which component gets which values when; see the module `master`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Algorithm {
    /// Every input holds the value at the start of the step: one step of delay per connection.
    Jacobi,
    /// Inputs with direct feed-through get the value at the end of the step.
    #[default]
    GaussSeidel,
    /// Like Gauss-Seidel, and algebraic loops are solved by iteration at each step.
    Iterative,
}

/// A component of a system.
#[derive(Clone)]
pub struct Component {
    /// Name in the system.
    pub name: String,
    /// What computes it.
    pub model: Model,
    /// The file of its FMU in this system; equal FMUs are shared, whatever their files are called.
    pub file: Option<PathBuf>,
    /// How its FMU is driven.
    pub interface: InterfaceType,
    /// Communication step.
    pub step: Step,
    /// Start values: positions of variables and their values.
    pub start_values: Vec<(usize, Value)>,
    /// The worker requested by its file for distributed runs.
    pub worker: Option<String>,
}

/// What computes a component.
#[derive(Clone)]
pub enum Model {
    /// An FMU.
    Fmu(Arc<Fmu>),
    /// Recorded or prepared signals.
    Signals(Arc<Signals>),
    /// A function of its inputs, without delay.
    Function(Arc<Function>),
}

impl Component {
    /// Its FMU, if it has one.
    pub fn fmu(&self) -> Option<&Fmu> {
        match &self.model {
            Model::Fmu(fmu) => Some(fmu),
            Model::Signals(_) | Model::Function(_) => None,
        }
    }

    /// Whether its steps may differ in length.
    pub(crate) fn varies(&self) -> bool {
        self.fmu().is_none_or(|fmu| fmu.varies(self.interface))
    }
}

/// A variable of a component: positions in their lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Port {
    /// Position of the component.
    pub component: usize,
    /// Position of the variable in the component's description.
    pub variable: usize,
}

/// An output that drives an input.
#[derive(Debug, Clone, PartialEq)]
pub struct Connection {
    /// The output.
    pub from: Port,
    /// The input.
    pub to: Port,
    /// The conversion of the value on the way.
    pub conversion: Option<Conversion>,
}

/// A connector of the system itself, exposed if it is part of something else.
#[derive(Debug, Clone)]
pub struct SystemPort {
    /// Name.
    pub name: String,
    /// Input or parameter, output or calculated parameter.
    pub causality: Causality,
    /// The variables of components behind it, and the conversion of values on the way.
    pub ends: Vec<(Port, Option<Conversion>)>,
    /// Its own unit.
    pub unit: Option<raw::RawUnit>,
}

/// A recorded variable.
#[derive(Debug, Clone)]
pub struct Column {
    /// Name in the results.
    pub name: String,
    /// The variable.
    pub port: Port,
    /// Its type.
    pub kind: Kind,
    /// Its unit, and the conversion to base units if it is defined.
    pub unit: Option<raw::RawUnit>,
}

impl Column {
    /// The name of its unit, if it has one.
    pub fn unit(&self) -> Option<&str> {
        self.unit.as_ref().map(|unit| unit.name.as_str()).filter(|name| !name.is_empty())
    }

    /// Its name and its unit, if it has one.
    pub fn name_and_unit(&self) -> Option<(&str, &str)> {
        Some((self.name.as_str(), self.unit()?))
    }

    /// Refuses Strings: conditions and figures are about numbers.
    pub fn is_number(&self) -> Result<()> {
        if self.kind != Kind::String {
            return Ok(());
        }
        let what = format!("'{}' is a String", self.name);
        Err(Error::new(Code::Parameter, what).why("conditions and figures need a number"))
    }
}

impl System {
    /// Reads and checks a system: .ssd, .ssp, `OspSystemStructure.xml` or the folder of the latter.
    pub fn load(path: impl AsRef<Path>, overrides: &Overrides) -> Result<Self> {
        Self::read(path.as_ref(), overrides, false)
    }

    /// The same for a file whose FMUs are unpacked folders.
    pub(crate) fn load_unpacked(path: &Path, overrides: &Overrides) -> Result<Self> {
        Self::read(path, overrides, true)
    }

    fn read(path: &Path, overrides: &Overrides, unpacked: bool) -> Result<Self> {
        let mut raw = read::read(path, unpacked)?;
        let mut problems = std::mem::take(&mut raw.problems);
        problems.extend(raw.leave_out(&overrides.without));
        check::check(Arc::new(raw), overrides, problems)
    }

    /// Reads the text of a system description, SSP or OSP, as far as possible without other files;
    /// returns the number of its components.
    pub fn read_text(text: &str) -> Result<usize> {
        let raw = read::read_text(text)?;
        raw.problems.all()?;
        Ok(raw.components.len())
    }

    /// Whether a path is a system description rather than an FMU.
    pub fn is_system(path: &Path) -> bool {
        read::is_system(path)
    }

    /// The same system with different variables recorded.
    pub(crate) fn recording(mut self, columns: Vec<Column>) -> Self {
        self.columns = columns;
        self
    }

    /// The same system with a different receiver for the messages of its FMUs.
    pub(crate) fn logging_to(mut self, logging: Logging) -> Self {
        self.logging = logging;
        self
    }

    /// Switches debug messages on or off for the FMUs of future engines.
    pub(crate) fn debug(&mut self, on: bool) {
        self.logging.debug = on;
    }

    /// The same file with different overrides. No file is read again: neither the description nor
    /// an FMU that a system of this file has used before, even if it has changed meanwhile.
    pub fn with(&self, overrides: &Overrides) -> Result<Self> {
        match &self.raw {
            Some(raw) => check::check(raw.clone(), overrides, Problems::default()),
            None => Err(crate::Error::new(
                crate::Code::Usage,
                format!("'{}' does not come from a system description", self.name),
            )),
        }
    }

    /// Files that it names: its description, its FMUs, and what its start values may name for them
    /// to read.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let description = self.raw.iter().map(|raw| raw.file.as_path());
        let fmus = self.components.iter().filter_map(|c| c.file.as_deref());
        let values = self.components.iter().flat_map(|c| &c.start_values);
        let named = values.filter_map(|(_, value)| match value {
            Value::String(text) => Some(Path::new(text)),
            _ => None,
        });
        description.chain(fmus).chain(named)
    }

    /// Name of the system.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Components in the order of the file.
    pub fn components(&self) -> &[Component] {
        &self.components
    }

    /// Connections in the order of the file.
    pub fn connections(&self) -> &[Connection] {
        &self.connections
    }

    /// Connectors of the system itself.
    pub fn ports(&self) -> &[SystemPort] {
        &self.ports
    }

    /// The stepping order.
    pub fn order(&self) -> &Order {
        &self.order
    }

    /// Recorded variables.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Start time.
    pub fn start_time(&self) -> Time {
        self.start
    }

    /// Stop time; [`Time::NEVER`] if it is unknown.
    pub fn stop_time(&self) -> Time {
        self.stop
    }

    /// Time between recorded samples.
    pub fn output_interval(&self) -> Step {
        self.output_interval
    }

    /// Whether the duration is not an integer number of steps, so that the last ones are shorter.
    pub fn ends_by_shorter_steps(&self) -> bool {
        self.shortened
    }

    /// What is missing to run it: a file may be valid without stop time and steps.
    pub fn ready(&self) -> Result<()> {
        let mut problems = Vec::new();
        if self.components.is_empty() {
            problems.push(
                Error::new(Code::Ssd, "the system has no components")
                    .help("an SSP has them in <ssd:Elements>, an OSP structure in <Simulators>"),
            );
        } else if self.unknown_steps {
            problems.push(Error::new(Code::Timing, "no component has a step size").help(
                "set one with --step-size SECONDS or --step COMPONENT=SECONDS, or in the file with \
                 <cosim:Master stepSize=\"0.01\"/> (SSP) or <BaseStepSize> (OSP)",
            ));
        }
        if self.stop == Time::NEVER {
            problems.push(Error::new(Code::Timing, "there is no stop time").help(
                "set --stop-time SECONDS, or in the file <ssd:DefaultExperiment stopTime=\"...\"/> \
                 (SSP) or <EndTime> (OSP)",
            ));
        }
        let file = self.raw.as_ref().map(|raw| raw.file.clone());
        let place = |error: Error| match &file {
            Some(file) => error.at(file),
            None => error,
        };
        Error::all(problems.into_iter().map(place).collect())
    }

    /// Whether an FMU runs without an installed tool, or with one that is known to be there.
    pub fn needs_no_tool(fmu: &Fmu, interface: InterfaceType, name: &str) -> Result<()> {
        check::needs_no_tool(fmu, interface, name)
    }

    /// The relative tolerance that was asked for, instead of those that FMUs suggest.
    pub fn tolerance(&self) -> Option<f64> {
        self.tolerance
    }

    /// The algorithm.
    pub fn algorithm(&self) -> Algorithm {
        self.algorithm
    }

    /// Whether the input of a connection is linear during a step, not constant.
    pub fn is_linear(&self, connection: usize) -> bool {
        self.linear[connection]
    }

    /// The relative tolerance that the communication steps follow, if any.
    pub fn step_control(&self) -> Option<f64> {
        self.step_control
    }

    /// How often a step that an FMU discards is made smaller.
    pub fn retries(&self) -> u32 {
        self.retries
    }

    /// The type of a variable of an FMU or a function.
    pub(crate) fn kind(&self, port: Port) -> Option<&Kind> {
        let description = self.components[port.component].model.description()?;
        Some(&description.variables[port.variable].kind)
    }

    /// The port of a variable by its name in the results.
    pub fn port(&self, name: &str) -> Result<Port> {
        let names = check::Names::of_components(&self.components, self.raw.is_some());
        names.port(name)
    }

    /// How model exchange is integrated.
    pub fn solver(&self) -> solver::Settings {
        self.solver
    }

    /// What the FMUs are asked to log, and who receives it.
    pub fn logging(&self) -> &Logging {
        &self.logging
    }

    /// Warnings.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Notes.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// The loops that are cut at sampled values, as text: they are well-defined.
    pub fn sampled_loops(&self) -> &[String] {
        &self.sampled
    }

    /// The unconnected inputs, component by component.
    pub fn unconnected_inputs(&self) -> impl Iterator<Item = Port> {
        let inputs = self.components.iter().enumerate().flat_map(|(component, c)| {
            let variables = c.model.description().map_or(&[][..], |d| &d.variables);
            let inputs = variables.iter().enumerate();
            let inputs = inputs.filter(|(_, v)| v.causality == Causality::Input);
            inputs.map(move |(variable, _)| Port { component, variable })
        });
        let driven: HashSet<Port> = self.connections.iter().map(|c| c.to).collect();
        inputs.filter(move |port| !driven.contains(port))
    }

    /// The loops that are solved by iteration.
    pub fn solved_loops(&self) -> impl Iterator<Item = &Loop> {
        self.order.loops.iter().filter(|found| found.solved)
    }

    /// The names of a loop's members, in stepping order.
    pub fn members(&self, found: &Loop) -> String {
        let names: Vec<&str> =
            found.members.iter().map(|&m| self.components[m].name.as_str()).collect();
        names.join(", ")
    }

    /// `component.variable` of a port.
    pub fn port_name(&self, port: Port) -> String {
        let component = &self.components[port.component];
        format!("{}.{}", component.name, component.model.variable_name(port.variable))
    }
}

impl Model {
    /// Its variables; signals have only names.
    pub fn description(&self) -> Option<&Description> {
        match self {
            Model::Fmu(fmu) => Some(fmu.description()),
            Model::Function(function) => Some(function.description()),
            Model::Signals(_) => None,
        }
    }

    /// The unit of a variable, as named and defined in the description.
    pub(crate) fn unit(&self, variable: usize) -> Option<raw::RawUnit> {
        let description = self.description()?;
        let name = description.variables.get(variable)?.unit.clone()?;
        Some(raw::RawUnit { unit: description.units.get(&name).copied(), name })
    }

    /// The number of its variables.
    pub fn variables(&self) -> usize {
        match self {
            Model::Signals(signals) => signals.names().len(),
            Model::Fmu(fmu) => fmu.description().variables.len(),
            Model::Function(function) => function.description().variables.len(),
        }
    }

    /// Name of a variable.
    pub fn variable_name(&self, variable: usize) -> &str {
        match self {
            Model::Signals(signals) => &signals.names()[variable],
            Model::Fmu(fmu) => &fmu.description().variables[variable].name,
            Model::Function(function) => &function.description().variables[variable].name,
        }
    }

    /// Whether any output depends on that input without delay.
    pub fn feeds_through(&self, variable: usize) -> bool {
        self.description().is_some_and(|d| d.feeds_through(variable))
    }
}

impl std::fmt::Display for Algorithm {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Algorithm::Jacobi => "jacobi",
            Algorithm::GaussSeidel => "gauss-seidel",
            Algorithm::Iterative => "iterative",
        })
    }
}

impl std::str::FromStr for Algorithm {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "jacobi" => Ok(Algorithm::Jacobi),
            "gauss-seidel" => Ok(Algorithm::GaussSeidel),
            "iterative" => Ok(Algorithm::Iterative),
            _ => Err(format!("'{text}' is not one of jacobi, gauss-seidel, iterative")),
        }
    }
}
