//! Which variables of a system an exported FMU shows.
//!
//! Without a wish: all outputs, all parameters, and as inputs those that nothing drives. Patterns
//! choose among all variables instead, and others take away again. A variable keeps its name as it
//! stands in results, `component.variable`.

use std::collections::BTreeSet;

use super::interface::{Basic, End, Exposed, Role};
use crate::error::{Code, Error, Result};
use crate::fmi::{Causality, Kind, Value, Variability, Variable};
use crate::names;
use crate::system::{Port, System};

/// A variable that is shown, with the one behind it.
pub(crate) struct Chosen {
    pub exposed: Exposed,
    pub port: Port,
    pub causality: Causality,
}

/// What of a system is shown.
pub(crate) fn choose(system: &System, expose: &[String], hide: &[String]) -> Result<Vec<Chosen>> {
    let driven: BTreeSet<Port> = system.connections().iter().map(|c| c.to).collect();
    let mut all = Vec::new();
    for (component, own) in system.components().iter().enumerate() {
        let variables = own.model.description().map_or(&[][..], |d| &d.variables);
        for (variable, described) in variables.iter().enumerate() {
            let port = Port { component, variable };
            all.push((chosen(system, port, described, driven.contains(&port)), described));
        }
    }
    known(&all, expose, hide)?;
    let fits = |patterns: &[String], name: &str| {
        patterns.iter().any(|pattern| names::matches(pattern, name))
    };
    let wanted = |(chosen, described): &(Chosen, &Variable)| {
        let name = &chosen.exposed.name;
        let shown = match expose {
            [] => by_default(chosen, described),
            patterns => fits(patterns, name),
        };
        shown && !fits(hide, name)
    };
    let chosen: Vec<Chosen> = all.into_iter().filter(wanted).map(|(chosen, _)| chosen).collect();
    distinct(&chosen)?;
    Ok(chosen)
}

fn by_default(chosen: &Chosen, described: &Variable) -> bool {
    matches!(described.causality, Causality::Output | Causality::Parameter)
        || chosen.exposed.role == Role::Input
}

fn chosen(system: &System, port: Port, described: &Variable, driven: bool) -> Chosen {
    let (role, causality) = role(described, driven);
    let component = &system.components()[port.component];
    let given = component.start_values.iter().rev().find(|(v, _)| *v == port.variable);
    let start = given.map(|(_, value)| value).or(described.start.as_ref()).cloned();
    let end = End {
        component: component.name.clone(),
        variable: described.name.clone(),
        conversion: None,
    };
    let exposed = Exposed {
        name: system.port_name(port),
        basic: Basic::of(&described.kind),
        role,
        ends: vec![end],
        start: start.unwrap_or_else(|| nothing(&described.kind)),
    };
    Chosen { exposed, port, causality }
}

/// Who gives it its value, and what it is in the FMU.
fn role(described: &Variable, driven: bool) -> (Role, Causality) {
    let tunable = described.variability == Variability::Tunable;
    let start = if described.settable() { Role::Start } else { Role::Calculated };
    match described.causality {
        Causality::Input if driven => (Role::Calculated, Causality::Local),
        Causality::Input => (Role::Input, Causality::Input),
        Causality::Parameter if tunable => (Role::Tunable, Causality::Parameter),
        Causality::Parameter => (Role::Fixed, Causality::Parameter),
        Causality::CalculatedParameter => (Role::Calculated, Causality::CalculatedParameter),
        Causality::Output => (start, Causality::Output),
        Causality::Local => (start, Causality::Local),
        // There is one time only, the FMU's own.
        Causality::Independent => (Role::Calculated, Causality::Local),
    }
}

/// The value of a variable that is given none.
fn nothing(kind: &Kind) -> Value {
    match kind {
        Kind::Real => Value::Real(0.0),
        Kind::Integer => Value::Integer(0),
        Kind::Enumeration(items) => Value::Integer(items.first().map_or(1, |(_, value)| *value)),
        Kind::Boolean => Value::Boolean(false),
        Kind::String => Value::String(String::new()),
    }
}

/// Every pattern must match something.
fn known(all: &[(Chosen, &Variable)], expose: &[String], hide: &[String]) -> Result<()> {
    let names = || all.iter().map(|(chosen, _)| chosen.exposed.name.as_str());
    let problems = expose.iter().chain(hide).filter_map(|pattern| {
        if names().any(|name| names::matches(pattern, name)) {
            return None;
        }
        let what = match names::is_pattern(pattern) {
            true => format!("the pattern '{pattern}' matches no variable"),
            false => format!("there is no variable '{pattern}'"),
        };
        Some(
            Error::new(Code::UnknownName, what).help(
                names::did_you_mean(pattern, names())
                    .unwrap_or_else(|| "list the variables by: cosim info FILE".to_owned()),
            ),
        )
    });
    Error::all(problems.collect())
}

/// Names of components may contain dots, so two variables may come by one name.
fn distinct(chosen: &[Chosen]) -> Result<()> {
    let mut seen = BTreeSet::new();
    let twice = chosen.iter().filter(|chosen| !seen.insert(&chosen.exposed.name));
    let problems = twice.map(|chosen| {
        let (name, end) = (&chosen.exposed.name, chosen.exposed.ends.first());
        let owner = end.map_or("", |end| &end.component);
        Error::new(Code::Format, format!("two variables of the FMU would be named '{name}'"))
            .why(format!("one is of the component '{owner}', whose name begins like another's"))
            .help("rename a component, or leave the variable out by --hide")
    });
    Error::all(problems.collect())
}
