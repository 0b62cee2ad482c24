//! A system description as it was written: names not resolved, numbers not compared.
//!
//! One form for all formats. It is flat: components of nested systems appear under their full
//! names, and each connection through connectors of systems is joined into one.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use cosim_import::archive::Unpacked;

use super::check::unknown_component;
use super::function::Function;
use super::opened::OpenedFmus;
use cosim_base::Warnings;
use cosim_base::error::{Code, Error, Problems};
use cosim_base::units::Unit;
use cosim_import::InterfaceType;

/// A system with the parameter files it names.
pub(super) struct RawSystem {
    /// The file as the user named it, for messages.
    pub file: PathBuf,
    /// Keeps unpacked packages.
    pub _unpacked: Vec<Unpacked>,
    /// FMUs that systems of this file use or have used.
    pub fmus: OpenedFmus,
    pub name: String,
    pub components: Vec<RawComponent>,
    pub connections: Vec<RawConnection>,
    /// Connectors of the outermost system.
    pub ports: Vec<RawPort>,
    /// In order of application: later ones take precedence.
    pub parameters: Vec<RawParameter>,
    /// Place of start and stop in the file.
    pub experiment: Option<Place>,
    pub start: Option<f64>,
    pub stop: Option<f64>,
    pub master: RawMaster,
    /// Patterns of the variables that the file wants recorded; empty: all outputs.
    pub recorded: Vec<String>,
    pub warnings: Warnings,
    pub notes: Vec<String>,
    /// Problems found while reading.
    pub problems: Problems,
}

/// A line of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Place {
    pub file: Arc<Path>,
    pub line: usize,
}

/// Settings of the whole run.
#[derive(Debug, Default, Clone)]
pub(super) struct RawMaster {
    pub algorithm: Option<super::Algorithm>,
    /// Step of components without their own.
    pub step: Option<f64>,
    pub output_interval: Option<f64>,
}

pub(super) struct RawComponent {
    pub name: String,
    pub model: RawModel,
    /// The interface type requested by the file.
    pub interface: Option<InterfaceType>,
    pub step: Option<f64>,
    /// The worker that computes it when the run is distributed.
    pub worker: Option<String>,
    /// The variables that may be connected; `None`: the format does not list them.
    pub connectors: Option<Vec<RawConnector>>,
    pub place: Place,
}

pub(super) enum RawModel {
    Fmu(PathBuf),
    Function(Arc<Function>),
    /// Its source is invalid; the problem has been recorded.
    Unknown,
}

#[derive(Debug, Clone)]
pub(super) struct RawConnector {
    pub name: String,
    /// `input`, `output`, `parameter`, `calculatedParameter`, ...
    pub kind: String,
    /// Name of the type element, if there is one.
    pub kind_of_value: Option<String>,
    pub unit: Option<RawUnit>,
    pub place: Place,
}

/// A unit by the name in its file, with the definition in the file.
#[derive(Debug, Clone, PartialEq)]
pub struct RawUnit {
    /// Its name.
    pub name: String,
    /// Its definition, if it is known.
    pub unit: Option<Unit>,
}

#[derive(Clone)]
pub(super) struct RawParameter {
    /// Full name, `component.variable`.
    pub name: String,
    pub kind: String,
    pub value: String,
    pub unit: Option<RawUnit>,
    /// The conversion of the value on the way.
    pub stages: Vec<Stage>,
    /// The name must exist; a parameter file may contain more than the system uses.
    pub required: bool,
    pub place: Place,
}

pub(super) struct RawConnection {
    /// Component and connector.
    pub from: (String, String),
    pub to: (String, String),
    /// From the source on, at least one.
    pub stages: Vec<Stage>,
    pub place: Place,
}

/// A connector of the outermost system and what it leads to.
pub(super) struct RawPort {
    pub connector: RawConnector,
    /// Inputs and parameters of components that it drives, or the output that drives it.
    pub ends: Vec<RawEnd>,
    /// Whether it drives.
    pub inward: bool,
}

/// A variable of a component behind a connector.
pub(super) struct RawEnd {
    /// Component and connector.
    pub name: (String, String),
    /// The conversion on the way.
    pub stages: Vec<Stage>,
}

/// One connection of the file; several if it goes through connectors of systems.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Stage {
    pub transformation: Option<Transformation>,
    pub suppress_unit_conversion: bool,
    /// Unit of the system's connector that it leads to, if it has one.
    pub unit: Option<RawUnit>,
}

/// The conversion of a value by a connection or a mapping.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Transformation {
    Linear {
        factor: f64,
        offset: f64,
    },
    Boolean(Vec<(bool, bool)>),
    Integer(Vec<(i32, i32)>),
    /// Items by name.
    Enumeration(Vec<(String, String)>),
}

impl RawSystem {
    /// Omits components with their connections, parameters and connectors; returns problems with
    /// that.
    pub(super) fn leave_out(&mut self, without: &[String]) -> Vec<Error> {
        let out = |component: &String| without.contains(component);
        let known = || self.components.iter().map(|component| component.name.as_str());
        let mut problems: Vec<Error> = without
            .iter()
            .filter(|name| !known().any(|known| known == *name))
            .map(|name| unknown_component(name, known()).at(&self.file))
            .collect();
        for RawConnection { from, to, place, .. } in &self.connections {
            if out(&from.0) && !out(&to.0) {
                let what = format!("'{}' cannot be left out: '{}.{}' needs it", from.0, to.0, to.1);
                problems.push(place.mark(Error::new(Code::Usage, what)));
            }
        }
        self.components.retain(|component| !out(&component.name));
        self.connections.retain(|connection| !out(&connection.from.0) && !out(&connection.to.0));
        let of = |name: &str| {
            without.iter().any(|w| name.strip_prefix(w).is_some_and(|rest| rest.starts_with('.')))
        };
        self.parameters.retain(|parameter| !of(&parameter.name));
        self.recorded.retain(|pattern| !of(pattern));
        self.ports.iter_mut().for_each(|port| port.ends.retain(|end| !out(&end.name.0)));
        problems
    }
}

impl RawUnit {
    /// Its memory in bytes.
    fn size(&self) -> usize {
        size_of::<Self>() + self.name.len()
    }
}

impl Stage {
    /// Its memory in bytes.
    pub(super) fn size(&self) -> usize {
        let pairs = match &self.transformation {
            None | Some(Transformation::Linear { .. }) => 0,
            Some(Transformation::Boolean(pairs)) => pairs.len() * size_of::<(bool, bool)>(),
            Some(Transformation::Integer(pairs)) => pairs.len() * size_of::<(i32, i32)>(),
            Some(Transformation::Enumeration(pairs)) => {
                let one =
                    |(a, b): &(String, String)| size_of::<(String, String)>() + a.len() + b.len();
                pairs.iter().map(one).sum()
            }
        };
        size_of::<Self>() + pairs + self.unit.as_ref().map_or(0, RawUnit::size)
    }
}

impl RawConnector {
    /// Its memory in bytes.
    pub(super) fn size(&self) -> usize {
        let texts = self.name.len() + self.kind.len();
        let kind = self.kind_of_value.as_ref().map_or(0, String::len);
        size_of::<Self>() + texts + kind + self.unit.as_ref().map_or(0, RawUnit::size)
    }
}

impl RawParameter {
    /// Its memory in bytes.
    pub(super) fn size(&self) -> usize {
        let texts = self.name.len() + self.kind.len() + self.value.len();
        let stages: usize = self.stages.iter().map(Stage::size).sum();
        size_of::<Self>() + texts + stages + self.unit.as_ref().map_or(0, RawUnit::size)
    }
}

impl Place {
    /// The error with this place.
    pub(super) fn mark(&self, error: Error) -> Error {
        error.at_line(&self.file, self.line)
    }
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}", self.file.display(), self.line)
    }
}
