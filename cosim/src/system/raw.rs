//! A system description as it was written: names not looked up, numbers not compared.

use std::path::PathBuf;

use crate::fmi::archive::Unpacked;

use super::opened::OpenedFmus;
use crate::fmi::InterfaceType;

/// One .ssd file, with the parameter files it names.
pub(super) struct RawSystem {
    /// The file as the user named it, for messages.
    pub file: PathBuf,
    /// Keeps an unpacked .ssp.
    pub _unpacked: Option<Unpacked>,
    /// FMUs that systems of this file use or have used.
    pub fmus: OpenedFmus,
    pub name: String,
    pub components: Vec<RawComponent>,
    pub connections: Vec<RawConnection>,
    /// Values bound at the system: names begin with a component's.
    pub parameters: Vec<RawParameter>,
    pub start: Option<f64>,
    pub stop: Option<f64>,
    pub master: RawMaster,
    pub warnings: Vec<String>,
}

/// This master's annotation of the whole.
#[derive(Default)]
pub(super) struct RawMaster {
    pub algorithm: Option<super::Algorithm>,
    pub step: Option<f64>,
    pub output_interval: Option<f64>,
}

pub(super) struct RawComponent {
    pub name: String,
    pub source: PathBuf,
    /// The interface type that the file asks for.
    pub interface: Option<InterfaceType>,
    /// This master's annotation.
    pub step: Option<f64>,
    pub connectors: Vec<RawConnector>,
    pub parameters: Vec<RawParameter>,
    pub line: usize,
}

pub(super) struct RawConnector {
    pub name: String,
    /// `input`, `output`, `parameter`, `calculatedParameter`, ...
    pub kind: String,
    /// Name of the type element, when there is one.
    pub kind_of_value: Option<String>,
    pub line: usize,
}

pub(super) struct RawParameter {
    pub name: String,
    pub kind: String,
    pub value: String,
    pub file: PathBuf,
    pub line: usize,
}

pub(super) struct RawConnection {
    /// Component and connector.
    pub from: (String, String),
    pub to: (String, String),
    pub suppress_unit_conversion: bool,
    pub line: usize,
}
