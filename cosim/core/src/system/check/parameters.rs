//! Start values: from the file, then from the command line.

use std::collections::HashMap;

use super::components::{Opened, same_kind, unknown_component};
use super::conversion::{self, Measured};
use super::{Findings, Names};
use crate::system::overrides::is_for;
use crate::system::raw::{RawParameter, RawSystem};
use crate::system::{Conversion, Overrides, Port};
use cosim_base::Warnings;
use cosim_base::error::{Code, Error, Result};
use cosim_import::{Causality, Value, Variability, Variable};

/// Start values for each component.
pub(super) fn check(
    raw: &RawSystem,
    overrides: &Overrides,
    opened: &[Opened],
    names: &Names,
    findings: &mut Findings,
) -> Vec<Vec<(usize, Value)>> {
    let mut values = StartValues { of: vec![Vec::new(); opened.len()], places: HashMap::new() };
    let replaced: Vec<&str> =
        opened.iter().filter(|o| o.replaced).map(|o| o.name.as_str()).collect();
    let replaced = |name: &str| {
        replaced.iter().any(|o| name.strip_prefix(o).is_some_and(|rest| rest.starts_with('.')))
    };
    for parameter in &raw.parameters {
        let name = &parameter.name;
        match of_file(parameter, opened, names, &mut findings.warnings) {
            Ok(found) => values.keep(found),
            Err(problem) if replaced(name) || not_meant(parameter, &problem) => {
                let why = match replaced(name) {
                    true => "the component's FMU was replaced",
                    false => "a parameter file may contain more than is used",
                };
                let hint = problem.remedy().map_or(String::new(), |hint| format!("; {hint}"));
                findings.warnings.push(format!(
                    "{}: '{name}' is left out: {}; {why}{hint}",
                    parameter.place,
                    problem.what()
                ));
            }
            Err(problem) => findings.problems.push(problem),
        }
    }
    for (name, text) in &overrides.start_values {
        let found = findings.note(start_value(names, name, text)).flatten();
        values.keep(found);
    }
    for (name, _) in &overrides.steps {
        if !opened.iter().any(|o| is_for(name, &o.name)) {
            let known = opened.iter().map(|o| o.name.as_str());
            findings.problems.push(unknown_component(name, known));
        }
    }
    values.of
}

/// Start values for each component, and where that of a variable is.
struct StartValues {
    of: Vec<Vec<(usize, Value)>>,
    places: HashMap<Port, usize>,
}

impl StartValues {
    /// A later value of the same variable replaces an earlier one.
    fn keep(&mut self, found: Option<(Port, Value)>) {
        let Some((port, value)) = found else { return };
        let list = &mut self.of[port.component];
        let place = *self.places.entry(port).or_insert(list.len());
        match list.get_mut(place) {
            Some(earlier) => earlier.1 = value,
            None => list.push((port.variable, value)),
        }
    }
}

/// Names in a parameter file that the system does not have.
fn not_meant(parameter: &RawParameter, problem: &Error) -> bool {
    !parameter.required && problem.code() == Code::UnknownName
}

fn of_file(
    parameter: &RawParameter,
    opened: &[Opened],
    names: &Names,
    warnings: &mut Warnings,
) -> Result<Option<(Port, Value)>> {
    let name = &parameter.name;
    let place = |e: Error| parameter.place.mark(e);
    let Some((port, variable)) = names.find(name).map_err(place)? else {
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
    let found = start_value(names, name, &parameter.value).map_err(place)?;
    let Some(description) = opened[port.component].description() else {
        return Ok(found);
    };
    let to = Measured { variable, units: &description.units, connector: None };
    let Some((port, value)) = found else {
        return Ok(None);
    };
    let value = converted(parameter, value, &to, warnings).map_err(|e| {
        let what = format!("the value of '{name}': {}", e.what());
        let error = Error::new(e.code(), what);
        place(match e.reason() {
            Some(why) => error.why(why),
            None => error,
        })
    })?;
    Ok(Some((port, value)))
}

/// The value in the unit of its variable, transformed according to its mapping.
fn converted(
    parameter: &RawParameter,
    value: Value,
    to: &Measured,
    warnings: &mut Warnings,
) -> Result<Value> {
    let kind = &to.variable.kind;
    let map = conversion::map(kind, kind, &parameter.stages)?.map(Conversion::Map);
    let no_entry = |value: &Value| {
        Error::new(Code::Parameter, format!("the mapping has no entry for {value}"))
    };
    match (&value, map) {
        (Value::Real(number), _) => {
            let way = conversion::of_value(parameter.unit.as_ref(), to, &parameter.stages)?;
            if let Some(units) = way.undefined {
                warnings.push(format!(
                    "{}: '{}' combines the units {units}, of which one is not defined; the value \
                     is used unconverted",
                    parameter.place, parameter.name
                ));
            }
            let conversion = way.conversion;
            Ok(Value::Real(conversion.and_then(|c| c.apply(*number)).unwrap_or(*number)))
        }
        (Value::Integer(number), Some(map)) => match map.apply(f64::from(*number)) {
            Some(found) => Ok(Value::Integer(found as i32)),
            None => Err(no_entry(&value)),
        },
        (Value::Boolean(flag), Some(map)) => match map.apply(f64::from(u8::from(*flag))) {
            Some(found) => Ok(Value::Boolean(found != 0.0)),
            None => Err(no_entry(&value)),
        },
        _ => Ok(value),
    }
}

/// A start value from its full name and text; `None` if the component could not be opened.
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
    let error = Error::new(Code::Parameter, format!("'{name}' cannot have a start value"));
    if variable.variability == Variability::Constant {
        return error.why("it is constant");
    }
    match variable.causality {
        Causality::Independent => error.why("it is the time"),
        causality => error
            .why(format!("its causality is {}: the FMU computes it", causality.name()))
            .help("set a parameter or an input; cosim info FILE.fmu lists them"),
    }
}
