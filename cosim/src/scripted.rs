//! FMUs whose component is a Python class, as `rexrov.component` of the Python package writes them.
//!
//! Their library (`cosim/scripted`) starts the Python that the manifest in their resources names. An
//! importer must have it: `needsExecutionTool`. This crate looks for it instead of asking the user.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::error::{Code, Error, Result};
use crate::export::interface::Basic;

/// The manifest in the resources.
const FILE: &str = "component.json";
/// The program in the resources that serves the class.
const HOST: &str = "host.py";
/// The environment names another Python than the manifest by this.
const PYTHON: &str = "COSIM_PYTHON";
/// Of the form of the manifest, and of what library and program say to each other.
const VERSION: u32 = 1;

/// What the resources say of the class.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Manifest {
    version: u32,
    /// The identity of the FMU.
    pub guid: String,
    /// The name of the class.
    pub class: String,
    /// The interpreter.
    python: PathBuf,
    /// Steps per second.
    pub rate: f64,
    /// Names of the inputs, which are Reals.
    pub inputs: Vec<String>,
    /// Names of the outputs, which are Reals.
    pub outputs: Vec<String>,
    /// The parameters.
    pub parameters: Vec<Parameter>,
}

/// An argument of the class with its start value.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its type.
    #[serde(rename = "type")]
    pub basic: Basic,
    /// Its start value, of that type.
    pub start: serde_json::Value,
}

impl Manifest {
    /// Reads it from the resources of an FMU.
    pub fn read(resources: &Path) -> Result<Self> {
        let file = resources.join(FILE);
        let unread = |why: String| {
            Error::new(Code::File, "the resources of the FMU cannot be read")
                .at(&file)
                .why(why)
                .help("write the FMU again: rexrov.component")
        };
        let bytes = fs::read(&file).map_err(|why| unread(why.to_string()))?;
        let read: Self = serde_json::from_slice(&bytes).map_err(|why| unread(why.to_string()))?;
        match read.version {
            VERSION if read.rate.is_normal() && read.rate > 0.0 => Ok(read),
            VERSION => Err(unread(format!("a rate of {} Hz", read.rate))),
            other => Err(unread(format!("it is of version {other}, not {VERSION}"))),
        }
    }

    /// The interpreter: that of the manifest, unless the environment names another.
    pub fn python(&self) -> PathBuf {
        let named = env::var_os(PYTHON).filter(|named| !named.is_empty());
        named.map_or_else(|| self.python.clone(), PathBuf::from)
    }

    /// The program that serves the class.
    pub fn host(resources: &Path) -> PathBuf {
        resources.join(HOST)
    }

    /// Why there is no process: the interpreter cannot be started.
    pub fn unstarted(&self, why: impl std::fmt::Display) -> Error {
        Error::new(Code::Library, format!("Python, which '{}' needs, cannot be started", self.class))
            .at(self.python())
            .why(why)
            .help(format!(
                "write the FMU again with a Python of this machine, or name one by {PYTHON}; an isolated \
                 run needs --execution-tool and --allow-read for its folders, a worker --no-confine"
            ))
    }
}

/// Whether an FMU with these resources is one of a Python class; an error if its Python is not here.
pub(crate) fn is_ready(resources: &Path) -> Result<bool> {
    if !resources.join(FILE).is_file() {
        return Ok(false);
    }
    let manifest = Manifest::read(resources)?;
    match manifest.python().is_file() {
        true => Ok(true),
        false => Err(manifest.unstarted("there is no such file")),
    }
}
