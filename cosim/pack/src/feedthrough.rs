//! Which outputs of a system depend directly on which of its free inputs.
//!
//! In a step, the inputs from the importer are known to every inner step. A free input therefore
//! reaches the outputs of its own component that it feeds through to, and from there everything
//! behind connections that carry the value of the same instant. The importer of the FMU uses this
//! to order its own components, and gets the values that it would get from the parts.

use std::collections::{BTreeMap, BTreeSet};

use cosim_core::system::{Port, System};

/// For each output, the free inputs that it depends on without delay.
pub(crate) type Dependencies = BTreeMap<Port, BTreeSet<Port>>;

/// What depends on `free`.
pub(crate) fn dependencies(system: &System, free: &BTreeSet<Port>) -> Dependencies {
    let solved: BTreeSet<usize> =
        system.solved_loops().flat_map(|found| found.held.iter().copied()).collect();
    let fresh = system
        .connections()
        .iter()
        .enumerate()
        .filter(|(position, _)| system.order().fresh[*position] || solved.contains(position));
    let sources: BTreeMap<Port, Port> = fresh.map(|(_, c)| (c.to, c.from)).collect();
    let mut all = Dependencies::new();
    // One pass in stepping order, and more where loops are solved.
    loop {
        let mut changed = false;
        for &component in &system.order().sequence {
            changed |= pass(system, component, free, &sources, &mut all);
        }
        if !changed || solved.is_empty() {
            return all;
        }
    }
}

/// Whether another variable became dependent.
fn pass(
    system: &System,
    component: usize,
    free: &BTreeSet<Port>,
    sources: &BTreeMap<Port, Port>,
    all: &mut Dependencies,
) -> bool {
    let Some(description) = system.components()[component].model.description() else {
        return false;
    };
    let reached = |input: usize, all: &Dependencies| -> BTreeSet<Port> {
        let port = Port { component, variable: input };
        match sources.get(&port) {
            Some(source) => all.get(source).cloned().unwrap_or_default(),
            None => free.get(&port).copied().into_iter().collect(),
        }
    };
    let mut changed = false;
    for output in &description.outputs {
        let own: BTreeSet<Port> = match &output.dependencies {
            Some(inputs) => inputs.iter().flat_map(|&input| reached(input, all)).collect(),
            None => {
                (0..description.variables.len()).flat_map(|input| reached(input, all)).collect()
            }
        };
        let known = all.entry(Port { component, variable: output.variable }).or_default();
        changed |= own.len() > known.len();
        known.extend(own);
    }
    changed
}
