//! Which component runs where, and which group waits for which.
//!
//! The components in one place form a *group*. A group computes with the engine of an ordinary run
//! on the same plan, so the same numbers are combined in the same order. The only difference is
//! when values of other groups arrive:
//!
//! * Fresh values (of the current instant) must arrive before the step of the component that reads
//!   them. Each component therefore has a *level*: one more than the highest level of a component
//!   in another group whose output it reads fresh, and no less than the level of such components in
//!   its own group. Components of the same group and level form a *part*. All parts of a level are
//!   computed at the same time; between two levels there is a barrier. Jacobi has one level.
//! * Held values (of the instant before) are sent with the first part of the next instant.
//!
//! Initialization is not worth running in parallel: the *stretches* of the sequence that lie in one
//! group are computed one after another, in exactly the order of an ordinary run.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use cosim_core::master::{Node, Plan, Route};

/// Components that are computed one after another in one place.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Part {
    /// Their positions, in stepping order.
    pub members: Vec<usize>,
    /// Slots of values of other groups that must have arrived before.
    pub reads: Vec<usize>,
}

/// The components in one place.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Group {
    /// Positions of the components, in stepping order.
    pub own: Vec<usize>,
    /// Slots of values of other groups that are held during steps.
    pub held: Vec<usize>,
    /// Runs of components that follow one another in the sequence.
    pub stretches: Vec<Part>,
    /// The components of each level; some may be empty.
    pub parts: Vec<Part>,
}

/// The groups of a system.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Layout {
    /// By position of the place.
    pub groups: Vec<Group>,
    /// Group and number of each stretch, in the order of the sequence.
    pub order: Vec<(usize, usize)>,
    /// Number of levels.
    pub levels: usize,
}

impl Layout {
    /// `places` gives the group of each component. All members of a solved loop must be in one
    /// group; if they are not, the position of the loop is returned as the error.
    pub(crate) fn new(plan: &Plan, places: &[usize]) -> Result<Self, usize> {
        for (position, solved) in plan.loops.iter().enumerate() {
            let mut groups = solved.members.iter().map(|&member| places[member]);
            let first = groups.next();
            if groups.any(|place| Some(place) != first) {
                return Err(position);
            }
        }
        let levels = levels(plan, places);
        let count = levels.iter().max().map_or(0, |highest| highest + 1);
        let groups = places.iter().max().map_or(0, |highest| highest + 1);
        let empty = Group { parts: vec![Part::default(); count], ..Group::default() };
        let mut layout = Layout { groups: vec![empty; groups], order: Vec::new(), levels: count };
        let mut before = None;
        for &component in &plan.sequence {
            let place = places[component];
            let group = &mut layout.groups[place];
            if before != Some(place) {
                layout.order.push((place, group.stretches.len()));
                group.stretches.push(Part::default());
            }
            before = Some(place);
            group.own.push(component);
            group.parts[levels[component]].members.push(component);
            if let Some(stretch) = group.stretches.last_mut() {
                stretch.members.push(component);
            }
        }
        layout.groups.iter_mut().for_each(|group| group.find_reads(plan));
        Ok(layout)
    }
}

impl Group {
    fn find_reads(&mut self, plan: &Plan) {
        let own: Vec<Range<usize>> = self.own.iter().flat_map(|&c| slots(plan, c)).collect();
        let foreign = |members: &[usize], routes: &dyn Fn(&Node) -> Vec<Route>| {
            let read = members.iter().flat_map(|&member| routes(&plan.nodes[member]));
            let mut read: Vec<usize> = read.map(|route| route.from).collect();
            read.retain(|slot| !own.iter().any(|range| range.contains(slot)));
            read.sort_unstable();
            read.dedup();
            read
        };
        self.held = foreign(&self.own, &|node| node.held.clone());
        for part in &mut self.parts {
            part.reads = foreign(&part.members, &|node| node.fresh.to_vec());
        }
        for part in &mut self.stretches {
            part.reads = foreign(&part.members, &|node| [&node.held[..], &node.fresh[..]].concat());
        }
    }

    /// The same, with positions among its own components.
    pub(crate) fn local(&self) -> Self {
        let mut local = self.clone();
        let position = |component: usize| self.own.iter().position(|&own| own == component);
        for part in local.parts.iter_mut().chain(&mut local.stretches) {
            part.members = part.members.iter().filter_map(|&member| position(member)).collect();
        }
        local.own = (0..self.own.len()).collect();
        local
    }
}

/// The slots that a component computes.
fn slots(plan: &Plan, component: usize) -> [Range<usize>; 2] {
    let node = &plan.nodes[component];
    [node.output_slots.clone(), node.recorded_slots.clone()]
}

/// The level of each component. The members of a solved loop share one level.
fn levels(plan: &Plan, places: &[usize]) -> Vec<usize> {
    let mut owner = vec![0; plan.values];
    for component in 0..plan.nodes.len() {
        slots(plan, component).into_iter().for_each(|slots| owner[slots].fill(component));
    }
    let mut levels = vec![0; plan.nodes.len()];
    let needed = |component: usize, levels: &[usize]| {
        let sources = plan.nodes[component].fresh.iter().map(|route| owner[route.from]);
        let after =
            sources.map(|source| levels[source] + usize::from(places[source] != places[component]));
        after.max().unwrap_or(0)
    };
    for &component in &plan.sequence {
        // The members of a loop are adjacent: the first one decides for all.
        let together = match plan.nodes[component].member_of {
            Some(found) if plan.loops[found].members.first() != Some(&component) => continue,
            Some(found) => &plan.loops[found].members[..],
            None => std::slice::from_ref(&component),
        };
        let level = together.iter().map(|&member| needed(member, &levels)).max().unwrap_or(0);
        together.iter().for_each(|&member| levels[member] = level);
    }
    levels
}
