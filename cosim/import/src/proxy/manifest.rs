//! The resources of a remote FMU: which FMU it represents, and how workers are reached.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::description::Interface;
use crate::{Basic, Causality, Description, elf};
use cosim_base::error::{Code, Error, Result};

/// The file in the resources that identifies the FMU.
pub const FILE: &str = "remote.json";
/// The file in the resources that defines how workers are reached; users may edit it.
pub const CONNECTION: &str = "connection.json5";
/// The program in the resources, below the folder of the platform.
const PROGRAM: &str = "cosim";

/// Format version of the file. A library reads only its own.
const VERSION: u32 = 1;

/// Identifies the FMU.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    version: u32,
    /// The GUID of the remote FMU itself.
    pub guid: String,
    /// File name of the FMU that it represents.
    pub fmu: String,
    /// SHA-256 of that file, by which workers know it.
    pub sha256: String,
    /// Whether it can serialize its state.
    pub can_save: bool,
    /// Whether it provides directional derivatives.
    pub derivative: bool,
    /// Value references of its Real outputs.
    pub outputs: Vec<u32>,
    /// Value references of its inputs, by type, in ascending order.
    pub inputs: [Vec<u32>; Basic::ALL.len()],
}

/// The path of the program for a platform in the resources.
pub fn place(platform: &str) -> String {
    format!("{platform}/{PROGRAM}")
}

/// The program for this machine.
pub(super) fn program(resources: &Path) -> Result<PathBuf> {
    let here = elf::here().unwrap_or("this machine");
    let file = resources.join(place(here));
    match file.is_file() {
        true => Ok(file),
        false => Err(Error::new(Code::File, format!("the FMU does not support {here}"))
            .why(format!("{} is missing", file.display()))
            .help("unpack the FMU again, or write it again on this machine: cosim proxy")),
    }
}

impl Manifest {
    /// For an FMU by its description and its file; the GUID comes later.
    pub fn new(description: &Description, interface: &Interface, fmu: &str, sha256: &str) -> Self {
        let of = |causality, basic| {
            let variables = description.variables.iter();
            let those = variables
                .filter(|v| v.causality == causality && v.kind.basic() == basic)
                .map(|v| v.value_reference);
            let mut references: Vec<u32> = those.collect();
            references.sort_unstable();
            references.dedup();
            references
        };
        Self {
            version: VERSION,
            guid: String::new(),
            fmu: fmu.to_owned(),
            sha256: sha256.to_owned(),
            can_save: interface.get_and_set_state && interface.serialize_state,
            derivative: interface.directional_derivative,
            outputs: of(Causality::Output, Basic::Real),
            inputs: Basic::ALL.map(|basic| of(Causality::Input, basic)),
        }
    }

    /// Reads it.
    pub fn read(resources: &Path) -> Result<Self> {
        let file = resources.join(FILE);
        let unread = |why: String| {
            Error::new(Code::File, "the resources of the FMU cannot be read")
                .at(&file)
                .why(why)
                .help("unpack the FMU again, or write it again: cosim proxy")
        };
        let bytes = fs::read(&file).map_err(|why| unread(why.to_string()))?;
        let read: Self = serde_json::from_slice(&bytes).map_err(|why| unread(why.to_string()))?;
        match read.version {
            VERSION => Ok(read),
            other => Err(unread(format!("it is of version {other}, not {VERSION}"))),
        }
    }

    /// The contents of the file.
    pub fn text(&self) -> Result<String> {
        serde_json::to_string_pretty(self)
            .map(|text| text + "\n")
            .map_err(|why| Error::new(Code::Output, "the FMU cannot be described").why(why))
    }

    /// The FMU itself, if it is in the resources.
    pub fn held(&self, resources: &Path) -> Option<PathBuf> {
        Some(resources.join(&self.fmu)).filter(|file| file.is_file())
    }
}
