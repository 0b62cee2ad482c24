//! Checks that a set-up is consistent: every position lies within its table, every length matches
//! what it counts.
//!
//! A checksum proves that a message arrived as it was sent, not that it makes sense. The engine
//! indexes its tables without checking, so an inconsistent set-up must be refused here.

use std::ops::Range;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

use super::layout::{Group, Part};
use super::setup::{FmuFile, Setup, Source};
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::Time;
use cosim_core::master::{Node, Plan};
use cosim_core::system::Component;

/// No real system has more values; larger tables would only waste memory.
const MOST: usize = 1 << 24;
/// The limit for times read from text (73 years): the sum of two does not overflow.
const LATEST: i64 = 1 << 61;

/// Fails with a description of what is wrong, and where.
fn require(holds: bool, what: impl FnOnce() -> String) -> Result<()> {
    if holds {
        return Ok(());
    }
    Err(Error::new(Code::Protocol, "the set-up of a group contradicts itself")
        .why(what())
        .help("it was not sent by a run of this version of cosim"))
}

/// All of these are below `limit`.
fn below(limit: usize, mut all: impl Iterator<Item = usize>, what: &str) -> Result<()> {
    let wrong = all.find(|&position| position >= limit);
    require(wrong.is_none(), || {
        format!("{what} is at {}, there are {limit}", wrong.unwrap_or_default())
    })
}

impl Setup {
    /// Checks that the tables fit together.
    pub(super) fn check(&self) -> Result<()> {
        let (nodes, components) = (self.plan.nodes.len(), self.components.len());
        require(nodes == components, || {
            format!("it names {components} components, its plan has {nodes}")
        })?;
        let timely = |time: Time| (-LATEST..LATEST).contains(&time.ns());
        require(timely(self.start) && timely(self.stop) && self.start <= self.stop, || {
            format!("it begins at {} and ends at {}", self.start, self.stop)
        })?;
        check_plan(&self.plan)?;
        check_group(&self.plan, &self.group)?;
        for (blueprint, node) in self.components.iter().zip(&self.plan.nodes) {
            let converted = blueprint.converted.iter().map(|(input, ..)| *input);
            below(node.inputs.len(), converted, "a converted input")?;
            match &blueprint.source {
                Source::Signals(signals) => signals.check()?,
                Source::Fmu(file) => check_file(file)?,
                Source::Sum(..) => {}
            }
        }
        let Some((time, state, _)) = &self.state else {
            return Ok(());
        };
        let times = state.ends.iter().chain([time]);
        require(times.copied().all(timely), || "the time of its state is out of range".to_owned())
    }
}

/// Hash and name become file names on this machine.
pub(super) fn check_file(FmuFile { sha256, name }: &FmuFile) -> Result<()> {
    let is_hash = sha256.len() == 64 && sha256.bytes().all(|octet| octet.is_ascii_hexdigit());
    require(is_hash, || format!("'{sha256}' is not a SHA-256"))?;
    let is_name = Path::new(name).file_name().is_some_and(|own| own.as_bytes() == name.as_bytes());
    require(is_name, || format!("'{name}' is not a file name"))
}

fn check_plan(plan: &Plan) -> Result<()> {
    let count = plan.nodes.len();
    require(plan.values <= MOST && plan.inputs <= MOST, || {
        format!("it asks for {} values and {} inputs", plan.values, plan.inputs)
    })?;
    check_order(count, &plan.sequence, "the stepping order")?;
    below(plan.values, plan.trends.iter().copied(), "a value that is followed")?;
    below(plan.values, plan.value_texts.iter().copied(), "a String")?;
    below(plan.inputs, plan.input_texts.iter().copied(), "a String that is an input")?;
    for found in &plan.loops {
        require(!found.members.is_empty(), || "a loop has no members".to_owned())?;
        below(count, found.members.iter().copied(), "a member of a loop")?;
        below(count, found.cuts.iter().flat_map(|cut| [cut.from, cut.to]), "a loop")?;
        for cut in &found.cuts {
            below(plan.values, [cut.route.from].into_iter(), "a cut")?;
            within(&plan.nodes[cut.to].input_slots, cut.route.to, "a cut")?;
        }
    }
    plan.nodes.iter().try_for_each(|node| check_node(plan, node))
}

fn check_node(plan: &Plan, node: &Node) -> Result<()> {
    require(node.step.is_sound() && node.step.rounded().ns() < LATEST, || {
        format!("a step is {} long", node.step)
    })?;
    for (slots, variables, limit, what) in [
        (&node.input_slots, &node.inputs, plan.inputs, "inputs"),
        (&node.output_slots, &node.outputs, plan.values, "outputs"),
        (&node.recorded_slots, &node.recorded, plan.values, "recorded variables"),
    ] {
        let fits = slots.start <= slots.end && slots.end <= limit;
        require(fits && slots.len() == variables.len(), || {
            format!("{} {what} are at {slots:?} of {limit}", variables.len())
        })?;
    }
    require(
        node.recorded.is_empty() || node.recorded_slots.start == node.output_slots.end,
        || "what is recorded does not follow the outputs".to_owned(),
    )?;
    for route in node.held.iter().chain(&node.fresh) {
        below(plan.values, [route.from].into_iter(), "the value of an input")?;
        within(&node.input_slots, route.to, "an input")?;
    }
    below(plan.loops.len(), node.member_of.into_iter(), "a loop")?;
    below(plan.trends.len(), node.trends.iter().copied(), "a trend")?;
    for &trend in &node.trends {
        within(&node.output_slots, plan.trends[trend], "a value that is followed")?;
    }
    below(plan.ramps.len(), node.ramps.iter().copied(), "a ramp")?;
    for ramp in node.ramps.iter().map(|&ramp| &plan.ramps[ramp]) {
        within(&node.input_slots, ramp.input, "an input that moves")?;
        below(plan.nodes.len(), [ramp.source].into_iter(), "the source of a ramp")?;
        below(plan.trends.len(), [ramp.trend].into_iter(), "the trend of a ramp")?;
    }
    Ok(())
}

fn check_group(plan: &Plan, group: &Group) -> Result<()> {
    check_order(plan.nodes.len(), &group.own, "the group")?;
    below(plan.values, group.held.iter().copied(), "a held value")?;
    let parts = group.parts.iter().chain(&group.stretches);
    parts.into_iter().try_for_each(|Part { members, reads }| {
        below(plan.nodes.len(), members.iter().copied(), "a member of a part")?;
        below(plan.values, reads.iter().copied(), "a value that is read")
    })
}

/// `order` has each of `count` components once.
fn check_order(count: usize, order: &[usize], what: &str) -> Result<()> {
    below(count, order.iter().copied(), what)?;
    let mut met = vec![false; count];
    order.iter().for_each(|&component| met[component] = true);
    require(order.len() == count && met.into_iter().all(|met| met), || {
        format!("{what} does not have each of {count} components once")
    })
}

fn within(slots: &Range<usize>, slot: usize, what: &str) -> Result<()> {
    require(slots.contains(&slot), || format!("{what} is at {slot}, outside {slots:?}"))
}

/// The variables named exist and can be exchanged.
pub(super) fn check_variables(component: &Component, node: &Node) -> Result<()> {
    let count = component.model.variables();
    let exchanged = [&node.inputs, &node.outputs, &node.recorded].into_iter().flatten().copied();
    let started = component.start_values.iter().map(|(variable, _)| *variable);
    let name = &component.name;
    below(count, exchanged.clone().chain(started), &format!("a variable of '{name}'"))?;
    let has_inputs = component.model.description().is_some() || node.inputs.is_empty();
    require(has_inputs, || format!("signals ('{name}') have no inputs"))
}
