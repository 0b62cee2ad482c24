//! The modelDescription.xml of FMI 2.0 as plain data.

use serde::{Deserialize, Serialize};

use std::collections::{HashMap, HashSet};
use std::sync::{Arc, OnceLock};

use fmu_standard::Basic;
pub use fmu_standard::{Causality, InterfaceType, Variability};

use cosim_base::units::Units;

mod known;
mod read;
mod value;

pub use read::{parse, read};
pub use value::{Value, ValueError};

/// The description of an FMU.
#[derive(Debug)]
pub struct Description {
    /// Name of the model.
    pub model_name: String,
    /// Identity that links the XML to the binary.
    pub guid: String,
    /// Description of the model.
    pub description: String,
    /// Tool that wrote it.
    pub generation_tool: String,
    /// The part for co-simulation, if there is one.
    pub co_simulation: Option<Interface>,
    /// The part for model exchange, if there is one.
    pub model_exchange: Option<Interface>,
    /// Number of continuous states.
    pub states: usize,
    /// A variable that is the derivative of a state, and its line, if no state is listed at all.
    pub unlisted_derivative: Option<(String, usize)>,
    /// Number of event indicators.
    pub event_indicators: usize,
    /// Suggested experiment.
    pub experiment: Experiment,
    /// Definitions of units.
    pub units: Units,
    /// All variables, in the order of the file; FMI's indices are their positions plus one.
    pub variables: Vec<Variable>,
    /// Outputs with the inputs they depend on directly.
    pub outputs: Vec<Output>,
    /// Names of the log categories.
    pub log_categories: Vec<String>,
    /// Elements and attributes in this file that FMI 2.0 does not define, and that were ignored.
    pub warnings: Vec<String>,
    positions: HashMap<String, usize>,
    /// The inputs that any output depends on, once they are needed; `None` inside: all.
    feeding: OnceLock<Option<HashSet<usize>>>,
}

/// The part for co-simulation or for model exchange.
#[derive(Debug, Clone)]
pub struct Interface {
    /// Name of the library file without its extension.
    pub model_identifier: String,
    /// The FMU only wraps a tool that must be installed.
    pub needs_execution_tool: bool,
    /// A process may create one instance only.
    pub once_per_process: bool,
    /// Its state can be saved and restored.
    pub get_and_set_state: bool,
    /// A saved state can be serialized.
    pub serialize_state: bool,
    /// It provides directional derivatives.
    pub directional_derivative: bool,
    /// Co-simulation: its steps may differ in length.
    pub variable_step: bool,
    /// Co-simulation: its inputs may be set with derivatives.
    pub interpolates_inputs: bool,
    /// Co-simulation: the order up to which it provides derivatives of its outputs.
    pub output_derivative_order: u32,
    /// Model exchange: it need not be notified of accepted steps.
    pub no_completed_step: bool,
    /// It allocates memory itself and ignores the memory callbacks.
    pub own_memory: bool,
    /// Co-simulation: `fmi2DoStep` may return before the step is complete.
    pub asynchronous: bool,
}

/// Suggested experiment, in seconds.
#[derive(Debug, Clone, Copy, Default)]
pub struct Experiment {
    /// Start time.
    pub start: Option<f64>,
    /// Stop time.
    pub stop: Option<f64>,
    /// Communication step.
    pub step: Option<f64>,
    /// Relative tolerance, without a unit.
    pub tolerance: Option<f64>,
}

/// A variable.
#[derive(Debug, Clone)]
pub struct Variable {
    /// Full name.
    pub name: String,
    /// FMI's handle; unique per type only, and shared by aliases.
    pub value_reference: u32,
    /// Its description.
    pub description: String,
    /// Role.
    pub causality: Causality,
    /// When it may change.
    pub variability: Variability,
    /// `initial="exact"`: it may be set before initialization.
    pub exact: bool,
    /// Type.
    pub kind: Kind,
    /// Usual magnitude of a Real.
    pub nominal: f64,
    /// Unit of a Real.
    pub unit: Option<String>,
    /// Start value, if the file gives one.
    pub start: Option<Value>,
    /// Line in modelDescription.xml.
    pub line: usize,
}

/// An output and what it depends on without delay.
#[derive(Debug, Clone)]
pub struct Output {
    /// Position in [`Description::variables`].
    pub variable: usize,
    /// Positions of the variables it depends on; `None`: on all inputs.
    pub dependencies: Option<Vec<usize>>,
}

/// Type of a variable.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the names are FMI's")]
pub enum Kind {
    Real,
    Integer,
    Boolean,
    String,
    /// An Integer whose values have names; shared by the variables of one type.
    Enumeration(#[serde(with = "items")] Arc<[(String, i32)]>),
}

impl Kind {
    /// FMI's name.
    pub fn name(&self) -> &'static str {
        match self {
            Kind::Real => "Real",
            Kind::Integer => "Integer",
            Kind::Boolean => "Boolean",
            Kind::String => "String",
            Kind::Enumeration(_) => "Enumeration",
        }
    }

    /// The base type; an Enumeration is an Integer.
    pub fn basic(&self) -> Basic {
        match self {
            Kind::Real => Basic::Real,
            Kind::Integer | Kind::Enumeration(_) => Basic::Integer,
            Kind::Boolean => Basic::Boolean,
            Kind::String => Basic::String,
        }
    }
}

impl Variable {
    /// Whether a start value may be set before initialization.
    pub fn settable(&self) -> bool {
        self.variability != Variability::Constant
            && (self.causality == Causality::Input || self.exact)
    }
}

impl Description {
    /// The description of a model that is not an FMU: a function of a system.
    pub fn of_model(name: &str, variables: Vec<Variable>, outputs: Vec<Output>) -> Self {
        let positions = variables.iter().enumerate().map(|(p, v)| (v.name.clone(), p)).collect();
        Self {
            model_name: name.to_owned(),
            guid: String::new(),
            description: String::new(),
            generation_tool: String::new(),
            co_simulation: None,
            model_exchange: None,
            states: 0,
            unlisted_derivative: None,
            event_indicators: 0,
            experiment: Experiment::default(),
            units: Units::new(),
            log_categories: Vec::new(),
            warnings: Vec::new(),
            variables,
            outputs,
            positions,
            feeding: OnceLock::new(),
        }
    }

    /// The part for an interface type, if there is one.
    pub fn interface(&self, kind: InterfaceType) -> Option<&Interface> {
        match kind {
            InterfaceType::CoSimulation => self.co_simulation.as_ref(),
            InterfaceType::ModelExchange => self.model_exchange.as_ref(),
        }
    }

    /// Position of a variable in [`Description::variables`].
    pub fn position(&self, name: &str) -> Option<usize> {
        self.positions.get(name).copied()
    }

    /// A variable by name.
    pub fn variable(&self, name: &str) -> Option<&Variable> {
        self.position(name).map(|position| &self.variables[position])
    }

    /// Names of all variables, in the order of the file.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.variables.iter().map(|v| v.name.as_str())
    }

    /// Whether any output depends on that input without delay. An output without a list of
    /// dependencies depends on every input (FMI 2.0.5, 2.2.8).
    pub fn feeds_through(&self, input: usize) -> bool {
        let feeding = self.feeding.get_or_init(|| {
            let all: Option<Vec<_>> =
                self.outputs.iter().map(|o| o.dependencies.as_ref()).collect();
            all.map(|lists| lists.into_iter().flatten().copied().collect())
        });
        feeding.as_ref().is_none_or(|feeding| feeding.contains(&input))
    }
}

/// The items of an enumeration as bytes.
mod items {
    use std::sync::Arc;

    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer>(
        items: &Arc<[(String, i32)]>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        items.as_ref().serialize(to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Arc<[(String, i32)]>, D::Error> {
        Vec::deserialize(from).map(Arc::from)
    }
}
