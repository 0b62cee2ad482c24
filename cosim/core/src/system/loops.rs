//! Describes loops of direct feed-through, and how serious they are.
//!
//! A loop cut at outputs with the variability `discrete` is well-defined: such a value holds from
//! one event of its component to the next (FMI 2.0.5, 2.2.7), so holding it during a step is what a
//! sampled system does anyway. That is a note. A loop cut at a continuous value is solved only up
//! to one step of delay, and that is a warning.

use std::collections::HashMap;

use super::order::Loop;
use super::{Algorithm, Model, Port, System};
use cosim_base::error::{Code, Error, Result};
use cosim_import::{Kind, Variability};

/// Adds the loops to the system's notes or warnings; an error if they cannot be solved.
pub(super) fn report(system: &mut System) -> Result<()> {
    let mut problems = Vec::new();
    for position in 0..system.order.loops.len() {
        let found = &system.order.loops[position];
        if sampled(system, found) {
            system.sampled.push(describe(system, found));
        } else if system.algorithm == Algorithm::Iterative {
            problems.extend(unable(system, found));
            let members = system.members(found);
            system.notes.push(format!("algebraic loop through {members}: solved at each step"));
            system.order.loops[position].solved = true;
        } else {
            system.warnings.push(describe(system, found));
        }
    }
    Error::all(problems)
}

/// The members that cannot go back: a step of a loop is repeated many times.
fn unable(system: &System, found: &Loop) -> Vec<Error> {
    let members = found.members.iter().map(|&member| &system.components[member]);
    let unable = members.filter_map(|component| match &component.model {
        Model::Fmu(fmu) => {
            let able = fmu.interface(component.interface).is_ok_and(|i| i.get_and_set_state);
            (!able).then_some((component, fmu))
        }
        Model::Signals(_) | Model::Function(_) => None,
    });
    let texts = found.held.iter().map(|&c| &system.connections[c]);
    let texts = texts.filter(|c| system.kind(c.from) == Some(&Kind::String)).map(|c| {
        let what = format!("the loop through {} has a String", system.port_name(c.from));
        Error::new(Code::Connection, what)
            .why("only numbers can be solved by iteration")
            .help("use --algorithm gauss-seidel, which cuts the loop")
    });
    let problems = unable.map(|(component, fmu)| {
        let what = format!("the loop with '{}' cannot be solved by iteration", component.name);
        Error::new(Code::Connection, what)
            .at(fmu.path())
            .why("its FMU does not declare canGetAndSetFMUstate")
            .help("use --algorithm gauss-seidel, which cuts the loop")
    });
    problems.chain(texts).collect()
}

/// Whether every held value is one that holds by its nature.
fn sampled(system: &System, found: &Loop) -> bool {
    found.held.iter().all(|&c| discrete(system, system.connections[c].from))
}

fn discrete(system: &System, port: Port) -> bool {
    let description = system.components[port.component].model.description();
    description.is_some_and(|d| d.variables[port.variable].variability != Variability::Continuous)
}

/// A loop as text; connections between the same two components are listed once.
fn describe(system: &System, found: &Loop) -> String {
    let name = |component: usize| system.components[component].name.as_str();
    let mut pairs: Vec<(usize, usize, String, usize)> = Vec::new();
    let mut places = HashMap::new();
    for connection in found.held.iter().map(|&c| &system.connections[c]) {
        let (from, to) = (connection.from, connection.to);
        let place = *places.entry((from.component, to.component)).or_insert(pairs.len());
        match pairs.get_mut(place) {
            Some(pair) => pair.3 += 1,
            None => {
                let first = format!("{} -> {}", system.port_name(from), system.port_name(to));
                pairs.push((from.component, to.component, first, 1));
            }
        }
    }
    let held: Vec<String> = pairs
        .into_iter()
        .map(|(from, to, first, count)| match count {
            1 => first,
            _ => format!("{} -> {} ({count} connections)", name(from), name(to)),
        })
        .collect();
    let (members, held) = (system.members(found), held.join(", "));
    match sampled(system, found) {
        true => format!("sampled loop through {members}: held for one step on {held}"),
        false => format!("algebraic loop through {members}: one step of delay on {held}"),
    }
}
