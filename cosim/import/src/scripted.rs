//! FMUs whose component is a Python class, as written by `rexrov.component` of the Python package.
//!
//! Their library (`cosim/scripted`) starts the Python interpreter named in the manifest in their
//! resources. The importer's machine must have it: `needsExecutionTool`. This crate searches for it
//! instead of asking the user.

use std::env;
use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::Basic;
use cosim_base::error::{Code, Error, Result};

/// The manifest in the resources.
const FILE: &str = "component.json";
/// The program in the resources that serves the class.
const HOST: &str = "host.py";
/// The environment variable that selects another Python than the manifest.
const PYTHON: &str = "COSIM_PYTHON";
/// Version of the manifest, and of the protocol between library and program.
const VERSION: u32 = 1;

/// The description of the class in the resources.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Manifest {
    version: u32,
    /// The GUID of the FMU.
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
    /// Reads the resources of an FMU.
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

    /// The interpreter: that of the manifest, unless the environment selects another.
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
        Error::new(
            Code::Library,
            format!("Python, which '{}' needs, cannot be started", self.class),
        )
        .at(self.python())
        .why(why)
        .help(format!(
            "write the FMU again with a Python of this machine, or select one with {PYTHON}; \
                 an isolated run needs --execution-tool and --allow-read for its folders, a worker \
                 --no-confine"
        ))
    }
}

/// Whether a process serves a class to such an FMU. When an instance ends, it waits for the next one.
pub fn is_host(process: u32) -> bool {
    let line = fs::read(format!("/proc/{process}/cmdline")).unwrap_or_default();
    let mut words = line.split(|octet| *octet == 0).rev().filter(|word| !word.is_empty());
    let (Some(resources), Some(host)) = (words.next(), words.next()) else { return false };
    let [resources, host] = [resources, host].map(|word| Path::new(OsStr::from_bytes(word)));
    host == Manifest::host(resources) && Manifest::read(resources).is_ok()
}

/// Whether an FMU with these resources is made from a Python class; an error if its Python is
/// missing.
pub fn is_ready(resources: &Path) -> Result<bool> {
    if !resources.join(FILE).is_file() {
        return Ok(false);
    }
    let manifest = Manifest::read(resources)?;
    match manifest.python().is_file() {
        true => Ok(true),
        false => Err(manifest.unstarted("there is no such file")),
    }
}
