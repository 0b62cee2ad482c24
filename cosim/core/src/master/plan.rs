//! A system laid out for stepping: which component exchanges which values through which slots.
//!
//! All values are in two flat arrays. `values` holds, component by component, the connected outputs
//! and the variables that are only recorded; `inputs` holds the connected inputs. A route copies
//! one slot of `values` to one of `inputs`. Nothing is looked up during a run.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::group::rank;
use crate::system::{Column, Connection, Port, System};
use cosim_base::time::Step;
use cosim_import::{Basic, Kind, Scalar};

/// Copies one value.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Route {
    /// Slot in `values`.
    pub from: usize,
    /// Slot in `inputs`.
    pub to: usize,
}

/// A connection at which a loop is cut: its components and its route.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Cut {
    pub from: usize,
    pub to: usize,
    pub route: Route,
    /// The type of the value.
    pub basic: Basic,
}

impl Cut {
    /// The value of its output.
    pub(super) fn number(&self, values: &[Scalar]) -> f64 {
        values[self.route.from].number(self.basic)
    }
}

/// A loop that is solved by iteration.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SolvedLoop {
    /// Positions of nodes in stepping order.
    pub members: Vec<usize>,
    /// The members' names, for messages.
    pub names: String,
    pub cuts: Vec<Cut>,
}

/// An input that moves during steps, and its source.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct RampWay {
    /// Slot in `inputs`.
    pub input: usize,
    /// Position of the component that it comes from, and of the trend.
    pub source: usize,
    pub trend: usize,
    /// Whether the value at the end of the step is known.
    pub fresh: bool,
}

/// The part of the plan for one component.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Node {
    /// Its step.
    pub step: Step,
    /// Its last step may be shorter.
    pub variable: bool,
    /// The positions of its values in the arrays.
    pub input_slots: Range<usize>,
    /// The places of its outputs among all values.
    pub output_slots: Range<usize>,
    /// Inputs that get the value at the end of the step.
    pub fresh: Box<[Route]>,
    /// Some of its inputs move during steps.
    pub ramped: bool,
    /// Inputs that hold the value at the start of the step.
    pub held: Vec<Route>,
    /// Positions of the ramps of its inputs.
    pub ramps: Vec<usize>,
    /// Position of the solved loop that contains the component.
    pub member_of: Option<usize>,
    /// Positions of the variables, Reals first (`group::rank`).
    pub inputs: Vec<usize>,
    /// The variables that others use.
    pub outputs: Vec<usize>,
    /// The variables that are recorded.
    pub recorded: Vec<usize>,
    /// The places of those among all values.
    pub recorded_slots: Range<usize>,
    /// Positions of the trends of its outputs.
    pub trends: Vec<usize>,
}

/// Recorded columns of one type whose values are side by side.
#[derive(Debug, Clone)]
pub(crate) struct Columns {
    slots: Range<usize>,
    basic: Basic,
}

/// The layout of a system.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Plan {
    /// All components.
    pub nodes: Vec<Node>,
    /// Positions of nodes in stepping order.
    pub sequence: Vec<usize>,
    /// Loops that are solved by iteration; none in the other algorithms.
    pub loops: Vec<SolvedLoop>,
    /// Slots in `values` whose slopes are followed.
    pub trends: Vec<usize>,
    /// Inputs that move during steps.
    pub ramps: Vec<RampWay>,
    /// Number of values.
    pub values: usize,
    /// Number of inputs.
    pub inputs: usize,
    /// Slots of the recorded columns in order; workers record nothing.
    #[serde(skip)]
    pub(crate) columns: Vec<Columns>,
    /// Slots in `values` and in `inputs` that hold Strings.
    pub value_texts: Vec<usize>,
    /// The inputs that are Strings.
    pub input_texts: Vec<usize>,
}

impl Plan {
    /// For a checked system.
    pub fn new(system: &System) -> Self {
        let mut plan = Plan {
            nodes: Vec::new(),
            sequence: system.order().sequence.clone(),
            loops: Vec::new(),
            trends: Vec::new(),
            ramps: Vec::new(),
            values: 0,
            inputs: 0,
            columns: Vec::new(),
            value_texts: Vec::new(),
            input_texts: Vec::new(),
        };
        for component in 0..system.components().len() {
            plan.add(system, component);
        }
        let mut all_fresh = vec![Vec::new(); plan.nodes.len()];
        for (connection, &fresh) in system.connections().iter().zip(&system.order().fresh) {
            if let Some(route) = plan.route(connection) {
                let node = &mut plan.nodes[connection.to.component];
                let routes =
                    if fresh { &mut all_fresh[connection.to.component] } else { &mut node.held };
                routes.push(route);
            }
        }
        for (node, fresh) in plan.nodes.iter_mut().zip(all_fresh) {
            node.fresh = fresh.into_boxed_slice();
        }
        plan.add_loops(system);
        for connection in 0..system.connections().len() {
            if system.is_linear(connection) {
                plan.add_ramp(system, connection);
            }
        }
        for node in &mut plan.nodes {
            node.ramped = !node.ramps.is_empty();
        }
        plan.add_columns(system.columns());
        plan
    }

    fn add_columns(&mut self, columns: &[Column]) {
        for column in columns {
            let Some(slot) = self.value_slot(column.port) else { continue };
            let basic = column.kind.basic();
            match self.columns.last_mut() {
                Some(last) if last.basic == basic && last.slots.end == slot => last.slots.end += 1,
                _ => self.columns.push(Columns { slots: slot..slot + 1, basic }),
            }
        }
    }

    /// The part for the components `own`, in this order, with the same slots. A loop must be
    /// entirely inside or outside, and the source of a moving input must be inside.
    pub fn restrict(&self, own: &[usize]) -> Self {
        let position = |component: usize| own.iter().position(|&own| own == component);
        let mut part =
            Self { nodes: Vec::new(), sequence: Vec::new(), loops: vec![], ..self.clone() };
        for found in &self.loops {
            let members: Vec<usize> = found.members.iter().filter_map(|&c| position(c)).collect();
            if members.len() != found.members.len() {
                continue;
            }
            let cuts = found.cuts.iter().filter_map(|cut| {
                Some(Cut { from: position(cut.from)?, to: position(cut.to)?, ..*cut })
            });
            let cuts = cuts.collect();
            part.loops.push(SolvedLoop { members, names: found.names.clone(), cuts });
        }
        for (place, &component) in own.iter().enumerate() {
            let member_of = part.loops.iter().position(|found| found.members.contains(&place));
            part.nodes.push(Node { member_of, ..self.nodes[component].clone() });
            part.sequence.push(place);
        }
        for ramp in &mut part.ramps {
            // Those of other components are not used.
            ramp.source = position(ramp.source).unwrap_or(0);
        }
        part
    }

    /// The Strings of a state, first those among the values, then those among the inputs. Their
    /// scalars are valid in this process only.
    pub fn texts(&self, values: &[Scalar], inputs: &[Scalar]) -> Vec<String> {
        let of_values = self.value_texts.iter().map(|&slot| values[slot]);
        let of_inputs = self.input_texts.iter().map(|&slot| inputs[slot]);
        of_values.chain(of_inputs).map(|text| text.as_text().to_string()).collect()
    }

    /// Puts the Strings of a state back, as far as `values` and `inputs` reach.
    pub fn take_texts(&self, texts: &[String], values: &mut [Scalar], inputs: &mut [Scalar]) {
        let (of_values, of_inputs) = texts.split_at(self.value_texts.len().min(texts.len()));
        for (all, slots, texts) in
            [(values, &self.value_texts, of_values), (inputs, &self.input_texts, of_inputs)]
        {
            for (&slot, text) in slots.iter().zip(texts) {
                if let Some(value) = all.get_mut(slot) {
                    *value = Scalar::text(text);
                }
            }
        }
    }

    /// The recorded values as numbers ([`Scalar::number`]).
    #[inline]
    pub fn row(&self, values: &[Scalar], mut row: &mut [f64]) {
        for Columns { slots, basic } in &self.columns {
            let (numbers, rest) = row.split_at_mut(slots.len());
            let values = &values[slots.clone()];
            match basic {
                Basic::Real => numbers.copy_from_slice(Scalar::reals(values)),
                basic => numbers
                    .iter_mut()
                    .zip(values)
                    .for_each(|(number, value)| *number = value.number(*basic)),
            }
            row = rest;
        }
    }

    /// The positions in [`Self::texts`] of what a component computes and reads.
    pub fn texts_of(&self, component: usize) -> impl Iterator<Item = usize> {
        let node = &self.nodes[component];
        let values = self
            .value_texts
            .iter()
            .map(|slot| node.output_slots.contains(slot) || node.recorded_slots.contains(slot));
        let inputs = self.input_texts.iter().map(|slot| node.input_slots.contains(slot));
        values.chain(inputs).enumerate().filter_map(|(place, own)| own.then_some(place))
    }

    /// Slots of the outputs of `members`.
    pub fn outputs(&self, members: &[usize]) -> impl Iterator<Item = usize> {
        members.iter().flat_map(|&member| self.nodes[member].output_slots.clone())
    }

    /// Slots of the recorded variables of `members` that are not outputs.
    pub fn recorded(&self, members: &[usize]) -> impl Iterator<Item = usize> {
        members.iter().flat_map(|&member| self.nodes[member].recorded_slots.clone())
    }

    fn route(&self, connection: &Connection) -> Option<Route> {
        let node = &self.nodes[connection.to.component];
        Some(Route {
            from: self.value_slot(connection.from)?,
            to: slot(&node.inputs, &node.input_slots, connection.to.variable)?,
        })
    }

    fn add_ramp(&mut self, system: &System, position: usize) {
        let connection = &system.connections()[position];
        let Some(route) = self.route(connection) else {
            return;
        };
        let (source, receiver) = (connection.from.component, connection.to.component);
        let known = self.trends.iter().position(|&slot| slot == route.from);
        let trend = known.unwrap_or_else(|| {
            self.trends.push(route.from);
            self.nodes[source].trends.push(self.trends.len() - 1);
            self.trends.len() - 1
        });
        let solved = system.solved_loops().any(|found| found.held.contains(&position));
        let fresh = system.order().fresh[position] || solved;
        self.nodes[receiver].ramps.push(self.ramps.len());
        self.ramps.push(RampWay { input: route.to, source, trend, fresh });
    }

    fn add_loops(&mut self, system: &System) {
        for (position, found) in system.solved_loops().enumerate() {
            let held = found.held.iter().map(|&c| &system.connections()[c]);
            let cuts = held.filter_map(|c| {
                let (from, to) = (c.from.component, c.to.component);
                let (route, basic) = (self.route(c)?, system.basic(c.from));
                Some(Cut { from, to, route, basic })
            });
            let cuts = cuts.collect();
            for &member in &found.members {
                self.nodes[member].member_of = Some(position);
            }
            let (members, names) = (found.members.clone(), system.members(found));
            self.loops.push(SolvedLoop { members, names, cuts });
        }
    }

    fn add(&mut self, system: &System, component: usize) {
        let connections = system.connections().iter();
        let outputs = connections.clone().map(|c| c.from);
        let outputs = self.own(system, component, outputs);
        let inputs = self.own(system, component, connections.map(|c| c.to));
        let recorded = system.columns().iter().map(|c| c.port);
        let mut recorded = self.own(system, component, recorded);
        recorded.retain(|variable| !outputs.contains(variable));
        let take = |next: &mut usize, count: usize| {
            *next += count;
            *next - count..*next
        };
        let input_slots = take(&mut self.inputs, inputs.len());
        let output_slots = take(&mut self.values, outputs.len());
        let recorded_slots = take(&mut self.values, recorded.len());
        let first = (input_slots.start, output_slots.start);
        let description = system.components()[component].model.description();
        let texts = |variables: &[usize], first: usize| -> Vec<usize> {
            let is = |v: usize| description.is_some_and(|d| d.variables[v].kind == Kind::String);
            let all = variables.iter().enumerate();
            all.filter(|(_, v)| is(**v)).map(|(place, _)| first + place).collect()
        };
        self.input_texts.extend(texts(&inputs, first.0));
        self.value_texts.extend(texts(&[&outputs[..], &recorded].concat(), first.1));
        self.nodes.push(Node {
            step: system.components()[component].step,
            variable: system.components()[component].varies(),
            input_slots,
            output_slots,
            recorded_slots,
            inputs,
            outputs,
            recorded,
            held: Vec::new(),
            fresh: Box::default(),
            ramped: false,
            trends: Vec::new(),
            ramps: Vec::new(),
            member_of: None,
        });
    }

    /// The variables of one component among `ports`, each once, sorted by type and position.
    fn own(
        &self,
        system: &System,
        component: usize,
        ports: impl Iterator<Item = Port>,
    ) -> Vec<usize> {
        let description = system.components()[component].model.description();
        let rank_of =
            |variable: usize| description.map_or(0, |d| rank(&d.variables[variable].kind));
        let mut own: Vec<usize> =
            ports.filter(|p| p.component == component).map(|p| p.variable).collect();
        own.sort_by_key(|&variable| (rank_of(variable), variable));
        own.dedup();
        own
    }

    /// Slot in `values` of an output or of a recorded variable.
    pub(crate) fn value_slot(&self, port: Port) -> Option<usize> {
        let node = &self.nodes[port.component];
        slot(&node.outputs, &node.output_slots, port.variable)
            .or_else(|| slot(&node.recorded, &node.recorded_slots, port.variable))
    }
}

fn slot(variables: &[usize], slots: &Range<usize>, variable: usize) -> Option<usize> {
    variables.iter().position(|&v| v == variable).map(|offset| slots.start + offset)
}
