//! Which output and which derivative depends on what, found by trying.
//!
//! A component is probed at many reproducible random points: parameters, inputs and states around
//! their start and nominal values and at their bounds. At each point one quantity after the other
//! is moved, and whatever differs in any bit depends on it. For outputs and derivatives the
//! quantities are inputs and states; a sampled component first handles some events with inputs
//! that wander, and the moved input is there at the last one. For initial values the quantities
//! are parameters and inputs. What cannot be tried is listed as a dependency: texts, and parameters
//! whose every move is refused.
//!
//! A sampled component computes all outputs together at the sample, and some of its branches are
//! rare: the last point of a course is reached once in a long run. Random trials see that an
//! input matters, but not that it matters to each output. So what moves any output counts as a
//! known of every output; what never moves anything (an input there for the sake of a common
//! interface) is none. If nothing moved any output, all inputs are knowns: something may after
//! more events than were tried.
//!
//! Only the generator of modelDescription.xml runs this; instances never do.

use std::collections::{BTreeMap, BTreeSet};

use crate::author::{Component, Resources, Start, Time};

use super::adapter::ComponentModel;
use super::model::Model;
use super::table::{Group, Table, Variable};
use super::values::{Explicit, Values};

/// Random points tried.
const POINTS: u64 = 256;
/// Most events before the one under test.
const EVENTS: u64 = 12;

/// Knowns of each unknown, as indices into the table's variables, both in ascending order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Dependencies {
    /// Outputs: on inputs and states.
    pub(crate) outputs: BTreeMap<usize, BTreeSet<usize>>,
    /// Derivatives: on inputs and states.
    pub(crate) derivatives: BTreeMap<usize, BTreeSet<usize>>,
    /// Outputs, states and derivatives at the start: on parameters and inputs.
    pub(crate) initial: BTreeMap<usize, BTreeSet<usize>>,
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
    probe.finish()
}

struct Probe<'a, F: Fn() -> Box<dyn Model>> {
    table: &'a Table,
    model: F,
    found: Dependencies,
    /// Parameters of which some move was accepted.
    moved: BTreeSet<usize>,
    refusal: Option<String>,
    accepted: usize,
}

/// One experiment: its events and what is moved when.
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
    }

    /// Moves parameters and inputs before the start.
    fn initial(&mut self, values: &Values, seed: u64) {
        let Some(base) = self.start(values) else {
            return;
        };
        self.accepted += 1;
        for (index, variable) in self.table.variables().iter().enumerate() {
            if !matches!(variable.group, Group::Parameter | Group::Input) {
                continue;
            }
            let mut random = Random(seed ^ (index as u64) << 20);
            let mut moved = values.clone();
            if !shift(variable, &mut moved, &mut random) {
                continue;
            }
            if let Some(there) = self.start(&moved) {
                self.moved.insert(index);
                note(self.table, &mut self.found.initial, index, &base, &there);
            }
        }
    }

    /// Moves inputs and states while running.
    fn running(&mut self, values: &Values, experiment: Experiment) {
        let Some(base) = self.run(values, experiment, None) else {
            return;
        };
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

    /// The values at the start.
    fn start(&mut self, values: &Values) -> Option<Values> {
        let mut values = values.clone();
        let model = self.configured(&mut values)?;
        evaluate(&*model, 0.0, &mut values);
        Some(values)
    }

    fn configured(&mut self, values: &mut Values) -> Option<Box<dyn Model>> {
        let mut model = (self.model)();
        if let Err(refusal) = model.configure(values, &self.explicit(values), None) {
            self.refusal.get_or_insert_with(|| refusal.to_string());
            return None;
        }
        if let Err(fault) = model.initialize(Time::default(), values) {
            self.refusal.get_or_insert_with(|| fault.to_string());
            return None;
        }
        Some(model)
    }

    /// What differs from its start value counts as set by the user.
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

    /// The values after some events, with `moved` moved for the last one and from there on.
    fn run(
        &mut self,
        values: &Values,
        experiment: Experiment,
        moved: Option<&Variable>,
    ) -> Option<Values> {
        let mut random = Random(experiment.seed ^ 0xD1CE);
        let mut values = values.clone();
        let mut model = self.configured(&mut values)?;
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
        if let Some(variable) = moved {
            shift(variable, &mut values, &mut random);
        }
        if let Some(next) = model.next_event() {
            now = next;
            model.events(now.seconds(), &mut values).ok()?;
        }
        evaluate(&*model, now.seconds(), &mut values);
        Some(values)
    }

    /// What one output of a sampled component depends on, all may depend on.
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

/// Notes the unknowns that differ in any bit as dependent on `known`.
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
        let bits = |values: &Values| {
            values.reals.get(variable.reference as usize).copied().map(f64::to_bits)
        };
        if bits(before) != bits(after) {
            knowns.insert(known);
        }
    }
}

/// Moves a variable to another admissible value; false if that makes no sense for its type.
fn shift(variable: &Variable, values: &mut Values, random: &mut Random) -> bool {
    let reference = variable.reference as usize;
    match &variable.start {
        Start::Real(start) => set(&mut values.reals, reference, real(variable, *start, random)),
        Start::Integer(start) => {
            let number = real(variable, f64::from(*start), random).round();
            set(&mut values.integers, reference, number as i32)
        }
        Start::Enumeration { items, .. } => {
            let item = 1 + random.below(items.len() as u64) as i32;
            set(&mut values.integers, reference, item)
        }
        Start::Boolean(_) => {
            let now = values.booleans.get(reference).copied().unwrap_or_default();
            set(&mut values.booleans, reference, !now)
        }
        Start::String(_) => false,
    }
}

fn set<T>(values: &mut [T], reference: usize, value: T) -> bool {
    values.get_mut(reference).map(|place| *place = value).is_some()
}

/// A value near the start, at a bound, or of the nominal size times a power of ten, within the
/// bounds. Inputs go furthest, so that saturated and far-off regions are seen as well as others.
fn real(variable: &Variable, start: f64, random: &mut Random) -> f64 {
    let (min, max) = (variable.min.unwrap_or(f64::MIN), variable.max.unwrap_or(f64::MAX));
    let scale = variable.nominal.unwrap_or(if start == 0.0 { 1.0 } else { start.abs() });
    let powers = match variable.group {
        Group::Input => 4,
        Group::State => 2,
        _ => 1,
    };
    let reach = (0..random.below(powers)).fold(scale, |reach, _| 10.0 * reach);
    let value = match (random.below(8), variable.min, variable.max) {
        (0, Some(min), _) => min,
        (1, _, Some(max)) => max,
        (2, Some(min), Some(max)) => min + (max - min) * random.unit(),
        (3 | 4, ..) => start + 1e-3 * scale * (2.0 * random.unit() - 1.0),
        _ => start + reach * (2.0 * random.unit() - 1.0),
    };
    value.clamp(min, max)
}

/// SplitMix64 (Steele, Lea and Flood 2014): all that probing needs of randomness.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, n: u64) -> u64 {
        self.next() % n.max(1)
    }
}
