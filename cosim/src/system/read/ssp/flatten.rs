//! Flattens nested systems.
//!
//! A connector of a system has two sides: inside, an input of the system is a source; outside it is
//! a destination. Every connection to a component is traced back through such connectors to the
//! component that drives it, and the conversions of the connections on the way are kept in order.

use std::collections::{BTreeMap, BTreeSet};

use crate::error::{Code, Error};
use crate::names;
use crate::system::raw::{
    Place, RawComponent, RawConnection, RawConnector, RawEnd, RawParameter, RawPort, Stage,
};

use super::super::gathered::Gathered;
use super::join;

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

#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
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

pub(super) fn flatten(nested: Nested, gathered: &mut Gathered) -> Flat {
    let mut directed = Vec::new();
    {
        let roles = Roles::new(&nested);
        for wire in &nested.wires {
            directed.extend(gathered.take(roles.direct(wire)));
        }
    }
    let drivers = drivers(&directed, gathered);
    let mut connections = Vec::new();
    for wire in &directed {
        let Node::Component(to) = &wire.to else { continue };
        connections.extend(gathered.take(trace(wire, to, &directed, &drivers)).flatten());
    }
    let parameters = parameters(&nested, &directed, gathered);
    let ports = outermost(&nested, &directed, &drivers, gathered);
    Flat { components: nested.components, connections, ports, parameters }
}

struct Roles<'a> {
    nested: &'a Nested,
    components: BTreeMap<&'a str, &'a RawComponent>,
}

impl<'a> Roles<'a> {
    fn new(nested: &'a Nested) -> Self {
        let components = nested.components.iter().map(|c| (c.name.as_str(), c)).collect();
        Self { nested, components }
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
            let own = self.nested.ports.keys().filter(|p| p.0 == *system).map(|p| p.1.as_str());
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
        let connectors = self.components.get(component).and_then(|c| c.connectors.as_ref());
        let listed = connectors.and_then(|list| list.iter().find(|c| c.name == connector));
        let role = match listed.map(|c| c.kind.as_str()) {
            Some("input" | "parameter" | "structuralParameter") => Role::Sink,
            Some("output" | "calculatedParameter" | "local" | "constant") => Role::Source,
            _ => Role::Unknown,
        };
        (Node::Component((component.to_owned(), connector.to_owned())), role)
    }
}

/// The connection that drives each connector of a system.
fn drivers<'d>(
    directed: &'d [Directed],
    gathered: &mut Gathered,
) -> BTreeMap<&'d Port, &'d Directed> {
    let mut drivers: BTreeMap<&Port, &Directed> = BTreeMap::new();
    for wire in directed {
        let Node::Port(port) = &wire.to else { continue };
        if let Some(first) = drivers.get(port) {
            gathered.problems.push(
                wire.place
                    .mark(Error::new(
                        Code::Connection,
                        format!("the connector '{}' has two drivers", join(&port.0, &port.1)),
                    ))
                    .why(format!("the connection on line {} already drives it", first.place.line))
                    .help("remove one of the two"),
            );
            continue;
        }
        drivers.insert(port, wire);
    }
    drivers
}

/// Traces a connection to a component back to its source; `None`: nothing drives it.
fn trace(
    last: &Directed,
    to: &Port,
    directed: &[Directed],
    drivers: &BTreeMap<&Port, &Directed>,
) -> Result<Option<RawConnection>, Error> {
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
            Node::Port(port) => {
                let Some(wire) = drivers.get(port) else {
                    return Ok(None);
                };
                stages.push(wire.stage.clone());
                from = &wire.from;
            }
        }
        if stages.len() > directed.len() {
            let what = format!("the connections to '{}' form a cycle", join(&to.0, &to.1));
            return Err(last.place.mark(Error::new(Code::Connection, what)));
        }
    }
}

/// Values set for connectors of systems reach the components behind them.
fn parameters(
    nested: &Nested,
    directed: &[Directed],
    gathered: &mut Gathered,
) -> Vec<RawParameter> {
    let ports: BTreeMap<String, &Port> =
        nested.ports.keys().map(|port| (join(&port.0, &port.1), port)).collect();
    let mut found = Vec::new();
    for parameter in &nested.parameters {
        let Some(port) = ports.get(&parameter.name) else {
            found.push(copy(parameter, parameter.name.clone(), &[]));
            continue;
        };
        let before = found.len();
        let mut way = Vec::new();
        follow(port, directed, &mut way, &mut |target, stages| {
            found.push(copy(parameter, join(&target.0, &target.1), stages));
        });
        if found.len() == before {
            gathered.warnings.push(format!(
                "{}: the value of '{}' does not reach any component",
                parameter.place, parameter.name
            ));
        }
    }
    found
}

/// The connectors of the outermost system with what they lead to.
fn outermost(
    nested: &Nested,
    directed: &[Directed],
    drivers: &BTreeMap<&Port, &Directed>,
    gathered: &mut Gathered,
) -> Vec<RawPort> {
    let mut found = Vec::new();
    for (port, connector) in nested.ports.iter().filter(|((system, _), _)| system.is_empty()) {
        let mut ends = Vec::new();
        follow(port, directed, &mut Vec::new(), &mut |target, stages| {
            ends.push(RawEnd { name: target.clone(), stages: stages.to_vec() });
        });
        let inward = !ends.is_empty();
        if let (false, Some(last)) = (inward, drivers.get(port)) {
            let source = gathered.take(trace(last, port, directed, drivers)).flatten();
            ends.extend(source.map(|s| RawEnd { name: s.from, stages: s.stages }));
        }
        found.push(RawPort { connector: connector.clone(), ends, inward });
    }
    found
}

fn copy(parameter: &RawParameter, name: String, stages: &[Stage]) -> RawParameter {
    RawParameter {
        name,
        kind: parameter.kind.clone(),
        value: parameter.value.clone(),
        unit: parameter.unit.clone(),
        stages: [&parameter.stages[..], stages].concat(),
        required: parameter.required,
        place: parameter.place.clone(),
    }
}

fn follow(
    port: &Port,
    directed: &[Directed],
    way: &mut Vec<Stage>,
    reached: &mut impl FnMut(&Port, &[Stage]),
) {
    // A cycle is longer than all connections together; it is reported where it is traced.
    if way.len() > directed.len() {
        return;
    }
    let leaving = directed.iter().filter(|w| matches!(&w.from, Node::Port(p) if p == port));
    for wire in leaving {
        way.push(wire.stage.clone());
        match &wire.to {
            Node::Component(target) => reached(target, way),
            Node::Port(next) => follow(next, directed, way, reached),
        }
        way.pop();
    }
}

fn name(node: &Node) -> String {
    let (Node::Port(port) | Node::Component(port)) = node;
    join(&port.0, &port.1)
}
