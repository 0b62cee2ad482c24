//! Components: their names, FMUs and listed connectors.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::Findings;
use crate::system::overrides::is_for;
use crate::system::raw::{RawComponent, RawConnector, RawModel, RawSystem};
use crate::system::{Model, Overrides};
use cosim_base::error::{Code, Error, Result};
use cosim_base::names;
use cosim_import::{Causality, Description, Fmu, InterfaceType, Kind, Variable};

/// A component whose model was searched for.
pub(super) struct Opened {
    pub name: String,
    /// `None` if it could not be opened; the problem is recorded, and whatever depends on it is
    /// skipped.
    pub model: Option<Model>,
    pub file: Option<PathBuf>,
    pub interface: InterfaceType,
    /// The FMU differs from the one in the file, so its connectors and parameters may differ.
    pub replaced: bool,
}

impl Opened {
    pub(super) fn description(&self) -> Option<&Description> {
        self.model.as_ref().and_then(Model::description)
    }

    pub(super) fn fmu(&self) -> Option<&Arc<Fmu>> {
        match &self.model {
            Some(Model::Fmu(fmu)) => Some(fmu),
            _ => None,
        }
    }
}

pub(super) fn open(raw: &RawSystem, overrides: &Overrides, findings: &mut Findings) -> Vec<Opened> {
    let known = || raw.components.iter().map(|c| c.name.as_str());
    let interfaces = overrides.interfaces.iter().map(|(name, _)| name);
    for name in overrides.replacements.iter().map(|(name, _)| name).chain(interfaces) {
        if !known().any(|n| is_for(name, n)) {
            findings.problems.push(unknown_component(name, known()).at(&raw.file));
        }
    }
    let mut opened: Vec<Opened> = Vec::new();
    let mut names = HashSet::new();
    for component in &raw.components {
        if !names.insert(&component.name) {
            let what = format!("two components are named '{}'", component.name);
            findings.problems.push(component.place.mark(Error::new(Code::Ssd, what)));
        }
        opened.push(open_one(raw, component, overrides, findings));
    }
    once_per_process(&opened, findings);
    opened
}

fn open_one(
    raw: &RawSystem,
    component: &RawComponent,
    overrides: &Overrides,
    findings: &mut Findings,
) -> Opened {
    let replacement = overrides.replacement_of(&component.name);
    let replaced = replacement.is_some();
    let name = component.name.clone();
    let path = match (replacement, &component.model) {
        (Some(path), _) | (None, RawModel::Fmu(path)) => path,
        (None, other) => {
            let model = match other {
                RawModel::Function(function) => Some(Model::Function(function.clone())),
                _ => None,
            };
            let (interface, file) = (InterfaceType::CoSimulation, None);
            return Opened { name, model, file, interface, replaced };
        }
    };
    let wanted = overrides.interface_of(&component.name).or(component.interface);
    let fmu = raw.fmus.open(path).and_then(|fmu| Ok((fmu.choose(wanted)?, fmu)));
    let (interface, fmu) = match fmu {
        Ok((interface, fmu)) => (interface, Ok(fmu)),
        Err(error) => (InterfaceType::CoSimulation, Err(error)),
    };
    let fmu = findings.note(fmu.map_err(|e| match replacement {
        Some(_) => e,
        None => named_in(e, component, path),
    }));
    if let (Some(fmu), None) = (&fmu, replacement) {
        let (hidden, there): (Vec<_>, Vec<_>) =
            component.connectors.iter().flatten().partition(|c| is_hidden(c, fmu));
        for connector in there {
            let checked = check_connector(component, connector, fmu);
            findings.note(checked);
        }
        findings.warnings.extend(left_out(component, &hidden));
    }
    if let (Some(fmu), false) = (&fmu, overrides.execution_tools) {
        findings.note(needs_no_tool(fmu, interface, &component.name));
    }
    let file = Some(path.to_owned());
    Opened { name, model: fmu.map(Model::Fmu), file, interface, replaced }
}

/// Refuses an FMU that only wraps a tool; for Python classes it is known whether the tool is
/// installed.
pub(in crate::system) fn needs_no_tool(
    fmu: &Fmu,
    interface: InterfaceType,
    name: &str,
) -> Result<()> {
    if !fmu.interface(interface)?.needs_execution_tool {
        return Ok(());
    }
    if cosim_import::scripted::is_ready(&fmu.folder().join("resources"))? {
        return Ok(());
    }
    let tool = &fmu.description().generation_tool;
    let tool = if tool.is_empty() { "that made it" } else { tool };
    Err(Error::new(Code::Library, format!("'{name}' needs a tool to be installed"))
        .at(fmu.path())
        .why(format!("its modelDescription.xml declares needsExecutionTool; the tool is {tool}"))
        .help("if it is installed here, add --execution-tool; otherwise export without the tool"))
}

fn named_in(error: Error, component: &RawComponent, path: &Path) -> Error {
    if error.code() != Code::File {
        return error;
    }
    let what = format!("the FMU of '{}' cannot be opened", component.name);
    component
        .place
        .mark(Error::new(Code::File, what))
        .why(format!("there is no readable file {}", path.display()))
        .help(format!(
            "{}build or copy it there, or correct the source; it is relative to the system's file",
            names::file_like(path).map_or(String::new(), |hint| hint + " If not, ")
        ))
}

/// A connector of a parameter that the FMU does not expose, as listed by Dymola. Connections or
/// bindings to it are reported where they are checked.
fn is_hidden(connector: &RawConnector, fmu: &Fmu) -> bool {
    connector.kind.to_lowercase().ends_with("parameter")
        && fmu.description().position(&connector.name).is_none()
}

fn left_out(component: &RawComponent, hidden: &[&RawConnector]) -> Option<String> {
    let names: Vec<&str> = hidden.iter().map(|connector| connector.name.as_str()).collect();
    let (name, shown) = (&component.name, names.iter().take(5).copied().collect::<Vec<_>>());
    let more = names.len() - shown.len();
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    (!names.is_empty()).then(|| {
        let shown = shown.join(", ");
        format!(
            "'{name}' lists parameters that its FMU does not have: {shown}{more}; they are left out"
        )
    })
}

fn check_connector(
    component: &RawComponent,
    connector: &RawConnector,
    fmu: &Arc<Fmu>,
) -> Result<()> {
    let model = Model::Fmu(fmu.clone());
    let (_, variable) =
        variable(&component.name, &model, &connector.name).map_err(|e| connector.place.mark(e))?;
    let wrong = |what: String| connector.place.mark(Error::new(Code::Connection, what));
    let causality = match variable.causality {
        Causality::Parameter => "parameter",
        Causality::CalculatedParameter => "calculatedParameter",
        Causality::Input => "input",
        Causality::Output => "output",
        // SSP 2.0 has `local`; SSP 1.0 has no kind for these.
        Causality::Local | Causality::Independent => "local",
    };
    if connector.kind != causality && connector.kind != "unspecified" {
        let (name, kind) = (&connector.name, &connector.kind);
        return Err(wrong(format!("'{}.{name}' is listed as kind=\"{kind}\"", component.name))
            .why(format!("its causality in the FMU is {}", variable.causality.name()))
            .help(format!("write kind=\"{causality}\"")));
    }
    match &connector.kind_of_value {
        // Represents types of the modelling language, which FMI 2.0 does not have.
        Some(kind) if kind == "Binary" => Ok(()),
        Some(kind) if !same_kind(kind, &variable.kind) => {
            let name = &connector.name;
            Err(wrong(format!("'{}.{name}' is listed as <ssc:{kind}/>", component.name))
                .why(format!("its type in the FMU is {}", variable.kind.name()))
                .help(format!("write <ssc:{}/>", variable.kind.name())))
        }
        _ => Ok(()),
    }
}

/// Whether a type named in SSP is compatible with a variable's type.
pub(super) fn same_kind(named: &str, kind: &Kind) -> bool {
    named == kind.name() || (named == "Integer" && matches!(kind, Kind::Enumeration(_)))
}

fn once_per_process(opened: &[Opened], findings: &mut Findings) {
    let mut first: HashMap<*const Fmu, &Opened> = HashMap::new();
    for component in opened {
        let Some(fmu) = component.fmu() else { continue };
        let once = fmu.interface(component.interface).is_ok_and(|i| i.once_per_process);
        let twin = *first.entry(Arc::as_ptr(fmu)).or_insert(component);
        if once && !std::ptr::eq(twin, component) {
            let what = format!("'{}' and '{}' share one FMU", twin.name, component.name);
            findings.problems.push(Error::new(Code::Ssd, what).at(fmu.path()).why(
                "it declares canBeInstantiatedOnlyOncePerProcess: only one component may use it",
            ));
        }
    }
}

/// A variable of a component and its position; the error names the nearest.
pub(super) fn variable<'m>(
    component: &str,
    model: &'m Model,
    name: &str,
) -> Result<(usize, &'m Variable)> {
    let unknown =
        || Error::new(Code::UnknownName, format!("'{component}' has no variable '{name}'"));
    let Some(description) = model.description() else {
        return Err(unknown());
    };
    if let Some(position) = description.position(name) {
        return Ok((position, &description.variables[position]));
    }
    let error = match model {
        Model::Fmu(fmu) => unknown().at(fmu.path()),
        _ => unknown(),
    };
    Err(error.help(
        names::did_you_mean(name, description.names())
            .unwrap_or_else(|| "list its variables with cosim info FILE.fmu".to_owned()),
    ))
}

/// The number of components that an error names: a file can have a million.
const MOST_NAMED: usize = 50;

/// The error for a component that does not exist.
pub(in crate::system) fn unknown_component<'a>(
    name: &str,
    known: impl Iterator<Item = &'a str> + Clone,
) -> Error {
    let list: Vec<&str> = known.clone().take(MOST_NAMED).collect();
    let more = if list.len() == MOST_NAMED { ", ..." } else { "" };
    Error::new(Code::UnknownName, format!("there is no component '{name}'")).help(
        names::did_you_mean(name, known)
            .unwrap_or_else(|| format!("the components are: {}{more}", list.join(", "))),
    )
}
