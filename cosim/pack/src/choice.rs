//! Which variables of a system an exported FMU shows.
//!
//! By default: all outputs, all parameters, and all unconnected inputs. Patterns select among all
//! variables instead, and other patterns exclude. A variable keeps its name from the results,
//! `component.variable`.

use std::collections::BTreeSet;

use cosim_base::error::{Code, Error, Result};
use cosim_base::names;
use cosim_base::units::Unit;
use cosim_core::hosted::{End, Exposed, Role};
use cosim_core::system::{Conversion, Port, System, SystemPort};
use cosim_import::{Causality, Kind, Value, Variability, Variable};

/// A variable that is shown, with the ports behind it.
pub(crate) struct Chosen {
    pub exposed: Exposed,
    /// One port, or those that a connector of the system drives.
    pub ports: Vec<Port>,
    pub causality: Causality,
    /// Its own unit, if it differs from that of the first port.
    pub unit: Option<(String, Option<Unit>)>,
}

impl Chosen {
    /// The variable that describes it.
    pub(crate) fn port(&self) -> Port {
        self.ports[0]
    }
}

/// Which variables of a system are shown.
pub(crate) fn choose(system: &System, expose: &[String], hide: &[String]) -> Result<Vec<Chosen>> {
    let inward = |port: &&SystemPort| is_inward(port.causality);
    let behind = system.ports().iter().filter(inward).flat_map(|port| &port.ends);
    let driven: BTreeSet<Port> =
        system.connections().iter().map(|c| c.to).chain(behind.map(|(port, _)| *port)).collect();
    let mut all = Vec::new();
    for port in system.ports() {
        all.extend(of_system(system, port));
    }
    for (component, own) in system.components().iter().enumerate() {
        let variables = own.model.description().map_or(&[][..], |d| &d.variables);
        for (variable, described) in variables.iter().enumerate() {
            let port = Port { component, variable };
            all.push(of_component(system, port, described, driven.contains(&port)));
        }
    }
    known(&all, expose, hide)?;
    let fits = |patterns: &[String], name: &str| {
        patterns.iter().any(|pattern| names::matches(pattern, name))
    };
    let wanted = |(chosen, by_default): &(Chosen, bool)| {
        let name = &chosen.exposed.name;
        let shown = match expose {
            [] => *by_default,
            patterns => fits(patterns, name),
        };
        shown && !fits(hide, name)
    };
    let chosen: Vec<Chosen> = all.into_iter().filter(wanted).map(|(chosen, _)| chosen).collect();
    distinct(&chosen)?;
    Ok(chosen)
}

/// A variable of a component, and whether it is shown by default.
fn of_component(system: &System, port: Port, described: &Variable, driven: bool) -> (Chosen, bool) {
    let (role, causality) = role(described, driven);
    let by_default =
        matches!(causality, Causality::Output | Causality::Parameter | Causality::Input);
    let exposed = Exposed {
        name: system.port_name(port),
        basic: described.kind.basic(),
        role,
        ends: vec![end(system, port, None)],
        start: start_of(system, port, described),
    };
    (Chosen { exposed, ports: vec![port], causality, unit: None }, by_default)
}

/// A connector of the system; `None` if it leads nowhere.
fn of_system(system: &System, port: &SystemPort) -> Option<(Chosen, bool)> {
    let (first, conversion) = port.ends.first()?;
    let description = system.components()[first.component].model.description()?;
    let described = &description.variables[first.variable];
    let (own, _) = role(described, false);
    let role = match port.causality {
        Causality::Input => Role::Input,
        Causality::Parameter if own == Role::Tunable => Role::Tunable,
        Causality::Parameter => Role::Fixed,
        _ => Role::Calculated,
    };
    let start = start_of(system, *first, described);
    let start = match (conversion, start) {
        (Some(Conversion::Linear(way)), Value::Real(inner)) if is_inward(port.causality) => {
            Value::Real(way.undo(inner))
        }
        (_, start) => start,
    };
    let ends = port.ends.iter();
    let exposed = Exposed {
        name: port.name.clone(),
        basic: described.kind.basic(),
        role,
        ends: ends.clone().map(|(port, way)| end(system, *port, way.clone())).collect(),
        start,
    };
    let unit = port.unit.as_ref().filter(|_| conversion.is_some());
    let unit = unit.map(|unit| (unit.name.clone(), unit.unit));
    let ports = ends.map(|(port, _)| *port).collect();
    Some((Chosen { exposed, ports, causality: port.causality, unit }, true))
}

fn is_inward(causality: Causality) -> bool {
    matches!(causality, Causality::Input | Causality::Parameter)
}

fn end(system: &System, port: Port, conversion: Option<Conversion>) -> End {
    let component = &system.components()[port.component];
    let variable = component.model.variable_name(port.variable).to_owned();
    End { component: component.name.clone(), variable, conversion }
}

/// The start values of the run of the system.
fn start_of(system: &System, port: Port, described: &Variable) -> Value {
    let given = &system.components()[port.component].start_values;
    let given = given.iter().rev().find(|(variable, _)| *variable == port.variable);
    let start = given.map(|(_, value)| value).or(described.start.as_ref());
    start.cloned().unwrap_or_else(|| nothing(&described.kind))
}

/// Where its value comes from, and what it is in the FMU.
fn role(described: &Variable, driven: bool) -> (Role, Causality) {
    let tunable = described.variability == Variability::Tunable;
    let start = if described.settable() { Role::Start } else { Role::Calculated };
    match described.causality {
        Causality::Input if driven => (Role::Calculated, Causality::Local),
        Causality::Input => (Role::Input, Causality::Input),
        Causality::Parameter if driven => (Role::Calculated, Causality::Local),
        Causality::Parameter if tunable => (Role::Tunable, Causality::Parameter),
        Causality::Parameter => (Role::Fixed, Causality::Parameter),
        Causality::CalculatedParameter => (Role::Calculated, Causality::CalculatedParameter),
        Causality::Output => (start, Causality::Output),
        Causality::Local => (start, Causality::Local),
        // There is only one time, that of the FMU.
        Causality::Independent => (Role::Calculated, Causality::Local),
    }
}

/// The value of a variable without a start value.
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
fn known(all: &[(Chosen, bool)], expose: &[String], hide: &[String]) -> Result<()> {
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
                    .unwrap_or_else(|| "list the variables with cosim info FILE".to_owned()),
            ),
        )
    });
    Error::all(problems.collect())
}

/// Names of components may contain dots, so two variables may get the same name.
fn distinct(chosen: &[Chosen]) -> Result<()> {
    let mut seen = BTreeSet::new();
    let twice = chosen.iter().filter(|chosen| !seen.insert(&chosen.exposed.name));
    let problems = twice.map(|chosen| {
        let (name, end) = (&chosen.exposed.name, chosen.exposed.ends.first());
        let owner = end.map_or("", |end| &end.component);
        Error::new(Code::Format, format!("two variables of the FMU would be named '{name}'"))
            .why(format!("the name of the component '{owner}' begins like that of another one"))
            .help("rename a component, or omit the variable with --hide")
    });
    Error::all(problems.collect())
}
