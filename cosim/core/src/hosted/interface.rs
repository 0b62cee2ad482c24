//! The interface of an exported FMU: which exposed variable leads to which variable of its system.
//!
//! The same list produces the modelDescription.xml and, as a file in the resources of the FMU,
//! tells its library what the value references mean.

use serde::{Deserialize, Serialize};

use crate::scenario::Scenario;
use crate::solver::Method;
use crate::system::Conversion;
use cosim_base::error::{Code, Error, Result};
use cosim_import::{Basic, Value};

/// Its path in the resources.
pub const FILE: &str = "interface.bin";

/// Format version of the file. A library reads only its own.
const VERSION: u32 = 4;

/// The marker among the bytes of a library that serves exported systems of this format.
pub const MARK: &str = "cosim serves exported systems of version 4";

/// The variables of an exported FMU, and how its system is run.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Interface {
    version: u32,
    /// The GUID of the FMU.
    pub guid: String,
    /// The description of the system in the resources.
    pub system: String,
    /// Faults and changes, if there are any.
    pub scenario: Option<Scenario>,
    /// How its system is run.
    pub running: Running,
    /// In the order of the modelDescription.xml. A value reference is an index within its type.
    pub variables: Vec<Exposed>,
}

/// Settings that a description of a system does not contain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Running {
    /// The algorithm of the steps.
    pub algorithm: String,
    /// The integrator for model exchange.
    pub solver: Method,
    /// The tolerance that was asked for, instead of those that FMUs suggest.
    pub tolerance: Option<f64>,
    /// The tolerance of the step control, if it is on.
    pub step_control: Option<f64>,
    /// How often a step may be repeated.
    pub retries: u32,
    /// Full names of the inputs that are linear during a step.
    pub linear: Vec<String>,
}

/// A variable.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Exposed {
    /// Its name.
    pub name: String,
    /// Its type.
    pub basic: Basic,
    /// What it is for the importer.
    pub role: Role,
    /// The variables of components behind it: one, or all inputs that an input drives.
    pub ends: Vec<End>,
    /// Its value before it is set or calculated.
    pub start: Value,
}

/// A variable of a component by name, and how the value is converted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct End {
    /// Name of the component.
    pub component: String,
    /// Name of its variable.
    pub variable: String,
    /// From the unit of the component.
    pub conversion: Option<Conversion>,
}

/// Where the value of a variable comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Role {
    /// The importer, at any time.
    Input,
    /// The importer, before the simulation.
    Fixed,
    /// The importer, also between steps.
    Tunable,
    /// The importer before the simulation, then the system.
    Start,
    /// The system.
    Calculated,
}

impl Role {
    /// Whether it has a start value.
    pub fn starts(self) -> bool {
        self != Self::Calculated
    }
}

impl Interface {
    /// Of a system with these variables.
    pub fn new(system: &str, running: Running, variables: Vec<Exposed>) -> Self {
        let (guid, system) = (String::new(), system.to_owned());
        Self { version: VERSION, guid, system, scenario: None, running, variables }
    }

    /// The contents of the file.
    pub fn bytes(&self) -> Result<Vec<u8>> {
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
