//! Flattens nested systems.
//!
//! A connector of a system has two sides: inside, an input of the system is a source; outside it is
//! a destination. Every connection to a component is traced back through such connectors to the
//! component that drives it, and the conversions of the connections on the way are kept in order.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::path::PathBuf;
use std::sync::Arc;

use crate::system::raw::{
    Place, RawComponent, RawConnection, RawConnector, RawEnd, RawParameter, RawPort, Stage,
};
use cosim_base::error::{Code, Error, Result};
use cosim_base::names;

use super::super::gathered::Gathered;
use super::join;
use super::mapping::Entry;

/// The contents of a description, with full names of elements.
#[derive(Default)]
pub(super) struct Nested {
    pub components: Vec<RawComponent>,
    /// Full names; the outermost is empty.
    pub systems: BTreeSet<String>,
    /// Connectors of systems, by the system and their own name.
    pub ports: BTreeMap<Port, RawConnector>,
    pub wires: Vec<Wire>,
    pub parameters: Vec<RawParameter>,
    /// Signal dictionaries by their system and name; their signals are among the ports.
    pub dictionaries: BTreeMap<(String, String), String>,
    /// Elements that represent dictionaries, by full name.
    pub references: BTreeMap<String, String>,
    /// The systems enclosing the element that is being read, outermost first.
    pub around: Vec<String>,
    /// The contents of files that were read, by path: a file may be used many times.
    pub parameter_files: HashMap<PathBuf, Arc<[RawParameter]>>,
    pub mapping_files: HashMap<PathBuf, Arc<[Entry]>>,
    pub dictionary_files: HashMap<PathBuf, Arc<[RawConnector]>>,
}

type Port = (String, String);

/// A connection as in the file.
pub(super) struct Wire {
    /// The system that contains it.
    pub system: String,
    pub start: End,
    pub end: End,
    pub stage: Stage,
    pub place: Place,
}

/// An end of a connection.
pub(super) struct End {
    /// Full name of the element; `None`: the system that contains the connection.
    pub element: Option<String>,
    pub connector: String,
}

/// The result.
pub(super) struct Flat {
    pub components: Vec<RawComponent>,
    pub connections: Vec<RawConnection>,
    pub ports: Vec<RawPort>,
    pub parameters: Vec<RawParameter>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Role {
    Source,
    Sink,
    Unknown,
}

#[derive(Debug, Clone)]
enum Node {
    Port(Port),
    Component(Port),
}

/// A connection by the source of its value.
struct Directed {
    from: Node,
    to: Node,
    stage: Stage,
    place: Place,
}

pub(super) fn flatten(mut nested: Nested, gathered: &mut Gathered) -> Flat {
    let directed = directed(&nested, gathered);
    let directed = with_one_driver(gathered.take(directed).unwrap_or_default(), gathered);
    let ways = Ways::new(&directed);
    let given = std::mem::take(&mut nested.parameters);
    let all = connections(&directed, &ways, gathered).and_then(|connections| {
        let parameters = parameters(&nested, given, &ways, gathered)?;
        Ok((connections, parameters, outermost(&nested, &ways, gathered)?))
    });
    let (connections, parameters, ports) = gathered.take(all).unwrap_or_default();
    Flat { components: nested.components, connections, ports, parameters }
}

fn directed(nested: &Nested, gathered: &mut Gathered) -> Result<Vec<Directed>> {
    let roles = Roles::new(nested);
    let mut directed = Vec::new();
    for wire in &nested.wires {
        let Some(found) = gathered.take(roles.direct(wire)) else { continue };
        // It repeats the names of dictionaries and the units of connectors.
        let size = found.stage.size() + found.from.length() + found.to.length();
        gathered.spend(size, &wire.place)?;
        directed.push(found);
    }
    Ok(directed)
}

struct Roles<'a> {
    nested: &'a Nested,
    /// The kinds of listed connectors, by component and name.
    kinds: HashMap<&'a str, HashMap<&'a str, &'a str>>,
}

impl<'a> Roles<'a> {
    fn new(nested: &'a Nested) -> Self {
        let kinds = nested.components.iter().map(|component| {
            // Of two with one name, the first is meant.
            let listed = component.connectors.iter().flatten().rev();
            (component.name.as_str(), listed.map(|c| (c.name.as_str(), c.kind.as_str())).collect())
        });
        Self { nested, kinds: kinds.collect() }
    }

    fn direct(&self, wire: &Wire) -> Result<Directed, Error> {
        let (start, start_role) = self.end(wire, &wire.start)?;
        let (end, end_role) = self.end(wire, &wire.end)?;
        let same = start_role == end_role && start_role != Role::Unknown;
        if same && (matches!(start, Node::Port(_)) || matches!(end, Node::Port(_))) {
            let what = if start_role == Role::Source { "sources" } else { "destinations" };
            return Err(Error::new(
                Code::Connection,
                format!("both ends are {what}: {} and {}", name(&start), name(&end)),
            )
            .at_line(&wire.place.file, wire.place.line)
            .help("the inputs of a system are sources inside it and destinations outside"));
        }
        // Start and end in the file do not define the direction (SSP 1.0, 5.3.3).
        let turned = start_role != Role::Source && end_role != Role::Sink && !same;
        let turned = turned && (start_role, end_role) != (Role::Unknown, Role::Unknown);
        let (from, to) = if turned { (end, start) } else { (start, end) };
        let mut stage = wire.stage.clone();
        if let Node::Port(port) = &to {
            stage.unit = self.nested.ports.get(port).and_then(|p| p.unit.clone());
        }
        Ok(Directed { from, to, stage, place: wire.place.clone() })
    }

    fn end(&self, wire: &Wire, end: &End) -> Result<(Node, Role), Error> {
        let system = match &end.element {
            None => &wire.system,
            Some(element) if self.nested.systems.contains(element) => element,
            Some(element) => match self.nested.references.get(element) {
                Some(dictionary) => dictionary,
                None => return Ok(self.component(element, &end.connector)),
            },
        };
        let port = (system.clone(), end.connector.clone());
        let Some(connector) = self.nested.ports.get(&port) else {
            let own = self.nested.ports.range((system.clone(), String::new())..);
            let own =
                own.map(|(port, _)| port).take_while(|p| p.0 == *system).map(|p| p.1.as_str());
            let shown = if system.is_empty() { "the system" } else { system.as_str() };
            return Err(wire.place.mark(
                Error::new(
                    Code::UnknownName,
                    format!("{shown} has no connector '{}'", end.connector),
                )
                .maybe_help(names::did_you_mean(&end.connector, own)),
            ));
        };
        let (inbound, outbound) = match end.element {
            None => (Role::Source, Role::Sink),
            Some(_) => (Role::Sink, Role::Source),
        };
        let role = match connector.kind.as_str() {
            "input" | "parameter" | "structuralParameter" => inbound,
            "output" | "calculatedParameter" | "local" | "constant" => outbound,
            _ => Role::Unknown,
        };
        Ok((Node::Port(port), role))
    }

    /// A missing component is found by the check, like all other names.
    fn component(&self, component: &str, connector: &str) -> (Node, Role) {
        let listed = self.kinds.get(component).and_then(|kinds| kinds.get(connector));
        let role = match listed {
            Some(&("input" | "parameter" | "structuralParameter")) => Role::Sink,
            Some(&("output" | "calculatedParameter" | "local" | "constant")) => Role::Source,
            _ => Role::Unknown,
        };
        (Node::Component((component.to_owned(), connector.to_owned())), role)
    }
}

/// Without connections to a connector of a system that has a driver already.
fn with_one_driver(directed: Vec<Directed>, gathered: &mut Gathered) -> Vec<Directed> {
    let mut first: HashMap<Port, usize> = HashMap::new();
    let mut kept = Vec::with_capacity(directed.len());
    for wire in directed {
        let Node::Port(port) = &wire.to else {
            kept.push(wire);
            continue;
        };
        if let Some(line) = first.get(port) {
            gathered.problems.push(
                wire.place
                    .mark(Error::new(
                        Code::Connection,
                        format!("the connector '{}' has two drivers", join(&port.0, &port.1)),
                    ))
                    .why(format!("the connection on line {line} already drives it"))
                    .help("remove one of the two"),
            );
            continue;
        }
        first.insert(port.clone(), wire.place.line);
        kept.push(wire);
    }
    kept
}

/// The connections by their ends. Each connector has one driver, so what follows a connector is a
/// tree, unless it is part of a cycle.
struct Ways<'d> {
    drivers: HashMap<&'d Port, &'d Directed>,
    leaving: HashMap<&'d Port, Vec<&'d Directed>>,
    /// Connectors in cycles, and those that get their values from them.
    circular: HashSet<&'d Port>,
}

impl<'d> Ways<'d> {
    fn new(directed: &'d [Directed]) -> Self {
        let mut drivers = HashMap::new();
        let mut leaving: HashMap<_, Vec<_>> = HashMap::new();
        for wire in directed {
            if let Node::Port(port) = &wire.to {
                drivers.insert(port, wire);
            }
            if let Node::Port(port) = &wire.from {
                leaving.entry(port).or_default().push(wire);
            }
        }
        let circular = circular(&drivers);
        Self { drivers, leaving, circular }
    }

    /// Traces a connection to a component back to its source; `None`: nothing drives it.
    fn trace(
        &self,
        last: &Directed,
        to: &Port,
        gathered: &mut Gathered,
    ) -> Result<Option<RawConnection>> {
        let mut stages = vec![last.stage.clone()];
        let mut from = &last.from;
        loop {
            match from {
                Node::Component(component) => {
                    stages.reverse();
                    return Ok(Some(RawConnection {
                        from: component.clone(),
                        to: to.clone(),
                        stages,
                        place: last.place.clone(),
                    }));
                }
                Node::Port(port) if self.circular.contains(port) => {
                    let name = join(&to.0, &to.1);
                    let what = format!("the connections to '{name}' form a cycle");
                    gathered.problems.push(last.place.mark(Error::new(Code::Connection, what)));
                    return Ok(None);
                }
                Node::Port(port) => {
                    let Some(wire) = self.drivers.get(port) else {
                        return Ok(None);
                    };
                    // The source's name is copied, too.
                    gathered.spend(wire.stage.size() + wire.from.length(), &last.place)?;
                    stages.push(wire.stage.clone());
                    from = &wire.from;
                }
            }
        }
    }

    /// Calls `reached` for each component behind a connector, with the conversions on the way.
    fn follow(
        &self,
        port: &Port,
        place: &Place,
        gathered: &mut Gathered,
        reached: &mut impl FnMut(&Port, &[&Stage], &mut Gathered) -> Result<()>,
    ) -> Result<()> {
        // A cycle is reported where it is traced.
        if self.circular.contains(port) {
            return Ok(());
        }
        let leaving = |port| self.leaving.get(port).into_iter().flatten();
        let (mut way, mut open) = (Vec::new(), vec![leaving(port)]);
        while let Some(next) = open.last_mut() {
            let Some(wire) = next.next() else {
                open.pop();
                way.pop();
                continue;
            };
            gathered.spend(size_of::<Stage>(), place)?;
            way.push(&wire.stage);
            match &wire.to {
                Node::Port(next) => open.push(leaving(next)),
                Node::Component(target) => {
                    let stages: usize = way.iter().map(|stage| stage.size()).sum();
                    gathered.spend(stages + wire.to.length(), place)?;
                    reached(target, &way, gathered)?;
                    way.pop();
                }
            }
        }
        Ok(())
    }
}

/// Connectors whose drivers never end.
fn circular<'d>(drivers: &HashMap<&'d Port, &'d Directed>) -> HashSet<&'d Port> {
    // Whether the way from a connector back to its source ends; unknown while it is being walked.
    let mut ends: HashMap<&Port, Option<bool>> = HashMap::new();
    for &start in drivers.keys() {
        let mut walked = Vec::new();
        let mut port = start;
        let end = loop {
            match ends.get(port) {
                Some(known) => break known.unwrap_or(false),
                None => ends.insert(port, None),
            };
            walked.push(port);
            match drivers.get(port).copied().map(|wire| &wire.from) {
                Some(Node::Port(from)) => port = from,
                _ => break true,
            }
        };
        ends.extend(walked.into_iter().map(|port| (port, Some(end))));
    }
    ends.into_iter().filter(|(_, end)| *end == Some(false)).map(|(port, _)| port).collect()
}

/// The connections between components.
fn connections(
    directed: &[Directed],
    ways: &Ways<'_>,
    gathered: &mut Gathered,
) -> Result<Vec<RawConnection>> {
    let mut found = Vec::new();
    for wire in directed {
        let Node::Component(to) = &wire.to else { continue };
        found.extend(ways.trace(wire, to, gathered)?);
    }
    Ok(found)
}

/// Values set for connectors of systems reach the components behind them.
fn parameters(
    nested: &Nested,
    given: Vec<RawParameter>,
    ways: &Ways<'_>,
    gathered: &mut Gathered,
) -> Result<Vec<RawParameter>> {
    let ports: HashMap<String, &Port> =
        nested.ports.keys().map(|port| (join(&port.0, &port.1), port)).collect();
    let mut found = Vec::new();
    for parameter in given {
        let Some(port) = ports.get(&parameter.name) else {
            found.push(parameter);
            continue;
        };
        let before = found.len();
        let size = parameter.size();
        ways.follow(port, &parameter.place, gathered, &mut |target, stages, gathered| {
            gathered.spend(size, &parameter.place)?;
            let mut reached = parameter.clone();
            reached.name = join(&target.0, &target.1);
            reached.stages.extend(stages.iter().copied().cloned());
            found.push(reached);
            Ok(())
        })?;
        if found.len() == before {
            gathered.warnings.push(format!(
                "{}: the value of '{}' does not reach any component",
                parameter.place, parameter.name
            ));
        }
    }
    Ok(found)
}

/// The connectors of the outermost system with what they lead to.
fn outermost(nested: &Nested, ways: &Ways<'_>, gathered: &mut Gathered) -> Result<Vec<RawPort>> {
    let mut found = Vec::new();
    for (port, connector) in nested.ports.iter().filter(|((system, _), _)| system.is_empty()) {
        let mut ends = Vec::new();
        ways.follow(port, &connector.place, gathered, &mut |target, stages, _| {
            let stages = stages.iter().copied().cloned().collect();
            ends.push(RawEnd { name: target.clone(), stages });
            Ok(())
        })?;
        let inward = !ends.is_empty();
        if let (false, Some(last)) = (inward, ways.drivers.get(port)) {
            let source = ways.trace(last, port, gathered)?;
            ends.extend(source.map(|s| RawEnd { name: s.from, stages: s.stages }));
        }
        found.push(RawPort { connector: connector.clone(), ends, inward });
    }
    Ok(found)
}

impl Node {
    /// Of its name, in bytes.
    fn length(&self) -> usize {
        let (Node::Port((owner, name)) | Node::Component((owner, name))) = self;
        owner.len() + name.len()
    }
}

fn name(node: &Node) -> String {
    let (Node::Port(port) | Node::Component(port)) = node;
    join(&port.0, &port.1)
}
