//! The dependencies of outputs and derivatives, found by trial.
//!
//! A component is probed at many reproducible random points: parameters, inputs and states around
//! their start and nominal values and at their bounds. At each point one quantity after another is
//! changed, and any output that differs in any bit depends on it. For outputs and derivatives the
//! quantities are inputs, states and time; a sampled component first handles some events with
//! inputs that vary, and the changed input is present at the last one. For initial values the
//! quantities are parameters, inputs and the start time. Quantities that cannot be tried are listed
//! as dependencies: strings, and parameters for which every change is rejected.
//!
//! If the component has a tangent-linear model, its slopes at the same points show how a known
//! enters (see [`super::factors`]).
//!
//! A sampled component computes all outputs together at the sample, and some of its branches are
//! rare: the last point of a course is reached once in a long run. Random trials show that an input
//! matters, but not that it matters to each output. So an input that changes any output counts as a
//! known of every output; an input that never changes anything (one that exists for the sake of a
//! common interface) counts as none. If nothing changed any output, all inputs are knowns: some may
//! matter after more events than were tried.
//!
//! Only the generator of modelDescription.xml runs this; instances never do.

use std::collections::{BTreeMap, BTreeSet};

use crate::author::{Component, Resources, Start, Time};

use super::adapter::ComponentModel;
use super::factors::{Factor, Factors};
use super::model::{Model, Outputs};
use super::perturbation::{Random, set, shift};
use super::table::{Group, Table, Variable};
use super::values::{Explicit, Values};

/// Random points tried.
const POINTS: u64 = 256;
/// Maximum number of events before the one under test.
const EVENTS: u64 = 12;
/// Points of inputs and states at which slopes are taken with the same parameters.
const SLOPES: u64 = 3;
/// By how much time is changed (s).
const LATER_S: f64 = 0.37;

/// Knowns of each unknown, as indices into the table's variables, both in ascending order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Dependencies {
    /// Outputs: on inputs, states and time.
    pub(crate) outputs: BTreeMap<usize, BTreeSet<usize>>,
    /// Derivatives: on inputs, states and time.
    pub(crate) derivatives: BTreeMap<usize, BTreeSet<usize>>,
    /// Outputs, states and derivatives at the start: on parameters, inputs and time.
    pub(crate) initial: BTreeMap<usize, BTreeSet<usize>>,
    factors: Factors,
    initial_factors: Factors,
}

impl Dependencies {
    /// How a known enters an output or a derivative.
    pub(crate) fn factor(&self, unknown: usize, known: usize) -> Factor {
        self.factors.of(unknown, known)
    }

    /// How a known enters an initial value, where FMI has no fixed factors.
    pub(crate) fn initial_factor(&self, unknown: usize, known: usize) -> Factor {
        match self.initial_factors.of(unknown, known) {
            Factor::Fixed => Factor::Dependent,
            factor => factor,
        }
    }
}

/// Probes a component.
pub(crate) fn probe<C: Component>(table: &Table) -> Result<Dependencies, String> {
    let mut probe =
        Probe::new(table, || Box::new(ComponentModel::<C>::new(table, Resources::none())));
    for point in 0..POINTS {
        probe.point(point);
    }
    if C::INFO.sampled {
        probe.share_among_outputs();
    }
    if C::ANY_INPUT {
        probe.depend_on_every_input();
    }
    probe.finish()
}

struct Probe<'a, F: Fn() -> Box<dyn Model>> {
    table: &'a Table,
    model: F,
    found: Dependencies,
    /// Parameters for which some change was accepted.
    moved: BTreeSet<usize>,
    refusal: Option<String>,
    accepted: usize,
}

/// One experiment: its events, and what is changed when.
#[derive(Clone, Copy)]
struct Experiment {
    events: u64,
    seed: u64,
}

impl<'a, F: Fn() -> Box<dyn Model>> Probe<'a, F> {
    fn new(table: &'a Table, model: F) -> Self {
        let none = |groups: &[Group]| {
            let all = table.variables().iter().enumerate();
            let chosen = all.filter(|(_, variable)| groups.contains(&variable.group));
            chosen.map(|(index, _)| (index, BTreeSet::new())).collect()
        };
        let found = Dependencies {
            outputs: none(&[Group::Output]),
            derivatives: none(&[Group::Derivative]),
            initial: none(&[Group::Output, Group::State, Group::Derivative]),
            ..Dependencies::default()
        };
        Self { table, model, found, moved: BTreeSet::new(), refusal: None, accepted: 0 }
    }

    /// Tries everything at one random point.
    fn point(&mut self, point: u64) {
        let mut random = Random(point);
        let mut values = self.table.start_values();
        if point > 0 {
            for variable in self.table.variables() {
                let keep = match variable.group {
                    Group::Parameter => point % 2 == 1 || random.below(3) > 0,
                    _ => random.below(4) == 0,
                };
                if !keep {
                    shift(variable, &mut values, &mut random);
                }
            }
        }
        self.initial(&values, point);
        self.running(&values, Experiment { events: point % (EVENTS + 1), seed: point });
        if self.table.has_tangent() {
            self.slopes(&values, point);
            self.initial_slopes(&values, point);
        }
    }

    /// Changes parameters and inputs before the start.
    fn initial(&mut self, values: &Values, seed: u64) {
        let Some(base) = self.start(values, 0.0) else {
            return;
        };
        self.accepted += 1;
        if let Some(later) = self.start(values, LATER_S) {
            let time = self.time();
            note(self.table, &mut self.found.initial, time, &base, &later);
        }
        for (index, variable) in self.table.variables().iter().enumerate() {
            if !matches!(variable.group, Group::Parameter | Group::Input) {
                continue;
            }
            let mut random = Random(seed ^ (index as u64) << 20);
            let mut moved = values.clone();
            if !shift(variable, &mut moved, &mut random) {
                continue;
            }
            if let Some(there) = self.start(&moved, 0.0) {
                self.moved.insert(index);
                note(self.table, &mut self.found.initial, index, &base, &there);
            }
        }
    }

    /// Index of time, the last variable.
    fn time(&self) -> usize {
        self.table.variables().len().saturating_sub(1)
    }

    /// Changes inputs, states and time while running.
    fn running(&mut self, values: &Values, experiment: Experiment) {
        let Some(base) = self.run(values, experiment, None) else {
            return;
        };
        let time = self.time();
        let later = self.table.variables().get(time);
        if let Some(there) = self.run(values, experiment, later) {
            note(self.table, &mut self.found.outputs, time, &base, &there);
            note(self.table, &mut self.found.derivatives, time, &base, &there);
        }
        for (index, variable) in self.table.variables().iter().enumerate() {
            if !matches!(variable.group, Group::Input | Group::State) {
                continue;
            }
            if let Some(there) = self.run(values, experiment, Some(variable)) {
                note(self.table, &mut self.found.outputs, index, &base, &there);
                note(self.table, &mut self.found.derivatives, index, &base, &there);
            }
        }
    }

    /// Evaluates the slopes along inputs and states at some points.
    fn slopes(&mut self, values: &Values, parameters: u64) {
        let mut values = values.clone();
        let Some(model) = self.configured(&mut values, 0.0) else {
            return;
        };
        let mut random = Random(parameters ^ 0x510E);
        let table = self.table;
        for _ in 0..SLOPES {
            let moving = [Group::Input, Group::State];
            for (_, variable) in moving.into_iter().flat_map(|group| table.group(group)) {
                shift(variable, &mut values, &mut random);
            }
            let knowns = moving.into_iter().flat_map(|group| table.group(group));
            for (known, variable) in knowns.filter(|(_, variable)| variable.is_real()) {
                let mut changes = unit(&values, variable);
                model.tangent(0.0, &values, Outputs::Wanted, &mut changes);
                for unknown in [Group::Output, Group::Derivative] {
                    for (unknown, variable) in table.group(unknown).filter(|(_, v)| v.is_real()) {
                        let slope = changes.get(variable.reference as usize).copied();
                        let slope = slope.unwrap_or(f64::NAN);
                        self.found.factors.see(unknown, known, slope, parameters);
                    }
                }
            }
        }
    }

    /// Evaluates the slopes along Real parameters and inputs at the start.
    fn initial_slopes(&mut self, values: &Values, parameters: u64) {
        let mut values = values.clone();
        let Some(model) = self.configured(&mut values, 0.0) else {
            return;
        };
        for (known, variable) in self.table.variables().iter().enumerate() {
            let moves = matches!(variable.group, Group::Parameter | Group::Input);
            if !(moves && matches!(variable.start, Start::Real(_))) {
                continue;
            }
            let mut changes = unit(&values, variable);
            model.initial_tangent(0.0, &values, &mut changes);
            for unknown in self.found.initial.keys() {
                let unknown_real = self.table.variables().get(*unknown).filter(|v| v.is_real());
                let reference = unknown_real.map(|v| v.reference as usize);
                let slope = reference.and_then(|reference| changes.get(reference).copied());
                let slope = slope.unwrap_or(f64::NAN);
                self.found.initial_factors.see(*unknown, known, slope, parameters);
            }
        }
    }

    /// The values at the start.
    fn start(&mut self, values: &Values, start_s: f64) -> Option<Values> {
        let mut values = values.clone();
        let model = self.configured(&mut values, start_s)?;
        evaluate(&*model, start_s, &mut values);
        Some(values)
    }

    fn configured(&mut self, values: &mut Values, start_s: f64) -> Option<Box<dyn Model>> {
        let mut model = (self.model)();
        if let Err(refusal) = model.configure(values, &self.explicit(values), None) {
            self.refusal.get_or_insert_with(|| refusal.to_string());
            return None;
        }
        if let Err(fault) = model.initialize(Time::from_seconds(start_s), values) {
            self.refusal.get_or_insert_with(|| fault.to_string());
            return None;
        }
        Some(model)
    }

    /// Values that differ from the start value count as set by the user.
    fn explicit(&self, values: &Values) -> Explicit {
        fn differing<T: PartialEq>(a: &[T], b: &[T], n: usize) -> Box<[bool]> {
            a.iter().zip(b).take(n).map(|(a, b)| a != b).collect()
        }
        let (start, count) = (self.table.start_values(), self.table.layout().parameters);
        Explicit {
            reals: differing(&values.reals, &start.reals, count.reals),
            integers: differing(&values.integers, &start.integers, count.integers),
            booleans: differing(&values.booleans, &start.booleans, count.booleans),
            strings: differing(&values.strings, &start.strings, count.strings),
        }
    }

    /// The values after some events, with `moved` changed for the last one and from there on.
    fn run(
        &mut self,
        values: &Values,
        experiment: Experiment,
        moved: Option<&Variable>,
    ) -> Option<Values> {
        let mut random = Random(experiment.seed ^ 0xD1CE);
        let mut values = values.clone();
        let mut model = self.configured(&mut values, 0.0)?;
        let mut now = Time::default();
        for _ in 0..experiment.events {
            for (_, input) in self.table.group(Group::Input) {
                if random.below(4) == 0 {
                    shift(input, &mut values, &mut random);
                }
            }
            let Some(next) = model.next_event() else {
                break;
            };
            now = next;
            model.events(now.seconds(), &mut values).ok()?;
        }
        for (_, state) in self.table.group(Group::State) {
            shift(state, &mut values, &mut random);
        }
        let later_s = match moved {
            Some(variable) if variable.group == Group::Time => LATER_S,
            Some(variable) => {
                shift(variable, &mut values, &mut random);
                0.0
            }
            None => 0.0,
        };
        if let Some(next) = model.next_event() {
            now = next;
            model.events(now.seconds(), &mut values).ok()?;
        }
        evaluate(&*model, now.seconds() + later_s, &mut values);
        Some(values)
    }

    /// All outputs of a sampled component may depend on whatever one of them depends on.
    fn share_among_outputs(&mut self) {
        let inputs = || self.table.group(Group::Input).map(|(index, _)| index);
        let outputs: Vec<usize> = self.found.outputs.keys().copied().collect();
        for unknowns in [&mut self.found.outputs, &mut self.found.initial] {
            let knowns = outputs.iter().filter_map(|output| unknowns.get(output));
            let mut all: BTreeSet<usize> = knowns.flatten().copied().collect();
            if all.is_empty() {
                all.extend(inputs());
            }
            for output in &outputs {
                unknowns.insert(*output, all.clone());
            }
        }
    }

    /// What a component does with invalid inputs may need many of them at once, which no random
    /// point has: all outputs count as depending on all inputs.
    fn depend_on_every_input(&mut self) {
        let inputs = || self.table.group(Group::Input).map(|(index, _)| index);
        self.found.outputs.values_mut().for_each(|knowns| knowns.extend(inputs()));
    }

    /// Adds the parameters that could not be tried.
    fn finish(mut self) -> Result<Dependencies, String> {
        if self.accepted == 0 {
            let refusal = self.refusal.unwrap_or_default();
            return Err(format!("cannot be probed for its dependencies: {refusal}"));
        }
        for (index, variable) in self.table.variables().iter().enumerate() {
            if variable.group == Group::Parameter && !self.moved.contains(&index) {
                for knowns in self.found.initial.values_mut() {
                    knowns.insert(index);
                }
            }
        }
        Ok(self.found)
    }
}

fn evaluate(model: &dyn Model, t: f64, values: &mut Values) {
    model.outputs(t, values);
    model.derivatives(t, values);
}

/// A change of a single variable.
fn unit(values: &Values, variable: &Variable) -> Box<[f64]> {
    let mut changes: Box<[f64]> = vec![0.0; values.reals.len()].into();
    set(&mut changes, variable.reference as usize, 1.0);
    changes
}

/// Marks the unknowns that differ in any bit as dependent on `known`.
fn note(
    table: &Table,
    unknowns: &mut BTreeMap<usize, BTreeSet<usize>>,
    known: usize,
    before: &Values,
    after: &Values,
) {
    for (unknown, knowns) in unknowns {
        let Some(variable) = table.variables().get(*unknown) else {
            continue;
        };
        let place = variable.reference as usize;
        let bits = |values: &Values| match variable.start {
            Start::Real(_) => values.reals.get(place).map(|value| value.to_bits()),
            Start::Boolean(_) => values.booleans.get(place).map(|value| u64::from(*value)),
            _ => values.integers.get(place).map(|value| u64::from(value.cast_unsigned())),
        };
        if bits(before) != bits(after) {
            knowns.insert(known);
        }
    }
}
