//! What an exported FMU shows of its system: which of its variables leads where.
//!
//! The same list makes the modelDescription.xml and, as a file in the FMU's resources, tells the
//! FMU's library what its value references mean.

use serde::{Deserialize, Serialize};

use crate::error::{Code, Error, Result};
use crate::fmi::{Kind, Value};
use crate::solver::Settings;
use crate::system::Conversion;

/// Where it lies in the resources.
pub(crate) const FILE: &str = "interface.bin";

/// Of the form of the file. A library reads only its own.
const VERSION: u32 = 2;

/// What marks a library that serves exported systems of this form, among its bytes.
pub const MARK: &str = "cosim serves exported systems of version 2";

/// The variables of an exported FMU, and how its system is run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Interface {
    version: u32,
    pub guid: String,
    /// The system's description in the resources.
    pub system: String,
    /// The file in the resources that says what happens to it, if anything does.
    pub scenario: Option<String>,
    pub running: Running,
    /// In the order of the modelDescription.xml. A value reference counts those of its type.
    pub variables: Vec<Exposed>,
}

/// What no description of a system says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Running {
    pub algorithm: String,
    pub solver: Settings,
    pub step_control: Option<f64>,
    pub retries: u32,
    /// Full names of the inputs that are linear during a step.
    pub linear: Vec<String>,
}

/// A variable.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Exposed {
    pub name: String,
    pub basic: Basic,
    pub role: Role,
    /// The variables of components behind it: one, or the inputs that an input drives.
    pub ends: Vec<End>,
    /// What it is before it is set or calculated.
    pub start: Value,
}

/// A variable of a component by names, and what happens to the value on its way.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct End {
    pub component: String,
    pub variable: String,
    pub conversion: Option<Conversion>,
}

/// FMI's types as far as value references go: an Enumeration is an Integer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the names are FMI's")]
pub enum Basic {
    Real,
    Integer,
    Boolean,
    String,
}

/// Who gives a variable its value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Role {
    /// The importer, at any time.
    Input,
    /// The importer, before the simulation.
    Fixed,
    /// The importer, between steps too.
    Tunable,
    /// The importer before the simulation, then the system.
    Start,
    /// The system.
    Calculated,
}

impl Basic {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Real, Self::Integer, Self::Boolean, Self::String];

    pub(crate) fn of(kind: &Kind) -> Self {
        match kind {
            Kind::Real => Self::Real,
            Kind::Integer | Kind::Enumeration(_) => Self::Integer,
            Kind::Boolean => Self::Boolean,
            Kind::String => Self::String,
        }
    }
}

impl Role {
    /// Whether it has a start value.
    pub(crate) fn starts(self) -> bool {
        self != Self::Calculated
    }
}

impl Interface {
    pub(crate) fn new(system: &str, running: Running, variables: Vec<Exposed>) -> Self {
        let (guid, system) = (String::new(), system.to_owned());
        Self { version: VERSION, guid, system, scenario: None, running, variables }
    }

    pub(crate) fn bytes(&self) -> Result<Vec<u8>> {
        postcard::to_stdvec(self).map_err(|e| {
            Error::new(Code::Output, "the list of exported variables cannot be written").why(e)
        })
    }

    pub(crate) fn read(bytes: &[u8]) -> Result<Self, String> {
        let read: Self = postcard::from_bytes(bytes).map_err(|e| e.to_string())?;
        match read.version {
            VERSION => Ok(read),
            other => Err(format!("it is of version {other}, not {VERSION}")),
        }
    }
}
