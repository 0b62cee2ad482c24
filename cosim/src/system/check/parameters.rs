//! Start values: of the file, then of the command line.

use super::components::{Opened, same_kind, unknown_component};
use super::{Findings, Names};
use crate::error::{Code, Error, Result};
use crate::fmi::{Causality, Value, Variability, Variable};
use crate::system::raw::{RawParameter, RawSystem};
use crate::system::{Overrides, Port};

/// Start values per component.
pub(super) fn check(
    raw: &RawSystem,
    overrides: &Overrides,
    opened: &[Opened],
    names: &Names,
    findings: &mut Findings,
) -> Vec<Vec<(usize, Value)>> {
    let mut values: Vec<Vec<(usize, Value)>> = vec![Vec::new(); opened.len()];
    let system = raw.parameters.iter().map(|p| (p.name.clone(), p));
    let own = raw.components.iter().flat_map(|component| {
        component.parameters.iter().map(|p| (format!("{}.{}", component.name, p.name), p))
    });
    for (name, parameter) in system.chain(own) {
        match of_file(&name, parameter, names) {
            Ok(found) => keep(&mut values, found),
            Err(problem) if replaced(opened, &name) => {
                findings.warnings.push(format!(
                    "{}:{}: '{name}' is left out: {}; the component's FMU was replaced",
                    parameter.file.display(),
                    parameter.line,
                    problem.what()
                ));
            }
            Err(problem) => findings.problems.push(problem),
        }
    }
    for (name, text) in &overrides.start_values {
        let found = findings.note(start_value(names, name, text)).flatten();
        keep(&mut values, found);
    }
    for (name, _) in &overrides.steps {
        if !opened.iter().any(|o| o.name == *name) {
            let known = opened.iter().map(|o| o.name.as_str());
            findings.problems.push(unknown_component(name, known));
        }
    }
    values
}

/// A later value of the same variable takes the earlier one's place.
fn keep(values: &mut [Vec<(usize, Value)>], found: Option<(Port, Value)>) {
    let Some((port, value)) = found else { return };
    let list = &mut values[port.component];
    match list.iter_mut().find(|(variable, _)| *variable == port.variable) {
        Some(earlier) => earlier.1 = value,
        None => list.push((port.variable, value)),
    }
}

fn replaced(opened: &[Opened], name: &str) -> bool {
    opened
        .iter()
        .any(|o| o.replaced && name.strip_prefix(&o.name).is_some_and(|rest| rest.starts_with('.')))
}

fn of_file(name: &str, parameter: &RawParameter, names: &Names) -> Result<Option<(Port, Value)>> {
    let place = |e: Error| e.at_line(&parameter.file, parameter.line);
    let Some((_, variable)) = names.find(name).map_err(place)? else {
        return Ok(None);
    };
    let fits = same_kind(&parameter.kind, &variable.kind)
        || matches!((parameter.kind.as_str(), variable.kind.name()), ("Integer", "Real"));
    if !fits {
        let what = format!("the value of '{name}' is given as <ssv:{}>", parameter.kind);
        return Err(place(
            Error::new(Code::Parameter, what)
                .why(format!("the variable is of the type {}", variable.kind.name()))
                .help(format!("write <ssv:{} value=\"...\"/>", variable.kind.name())),
        ));
    }
    start_value(names, name, &parameter.value).map_err(place)
}

/// A start value from its full name and text; `None` when the component could not be opened.
pub(in crate::system) fn start_value(
    names: &Names,
    name: &str,
    text: &str,
) -> Result<Option<(Port, Value)>> {
    let Some((port, variable)) = names.find(name)? else {
        return Ok(None);
    };
    if !variable.settable() {
        return Err(not_settable(name, variable));
    }
    let value = Value::parse(text, &variable.kind).map_err(|e| {
        Error::new(Code::Parameter, format!("the start value of '{name}'")).why(e.0)
    })?;
    Ok(Some((port, value)))
}

fn not_settable(name: &str, variable: &Variable) -> Error {
    let error = Error::new(Code::Parameter, format!("'{name}' cannot be given a start value"));
    if variable.variability == Variability::Constant {
        return error.why("it is constant");
    }
    match variable.causality {
        Causality::Independent => error.why("it is the time"),
        causality => error
            .why(format!("it is of the causality {}: the FMU computes it", causality.name()))
            .help("set a parameter or an input; cosim info FILE.fmu lists them"),
    }
}
