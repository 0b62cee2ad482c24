//! Sampled components, by pairs of runs.

use std::collections::BTreeSet;

use fmu_kit::Start;
use fmu_kit::kernel::{Group, Instance, Interface, Status, Variable};
use rexrov_fmu::REGISTRY;

use crate::declared::{self, Declared};
use crate::subject::{Random, entry, instance, put};

const RUNS: u64 = 400;
/// Maximum number of communication steps in a run.
const STEPS: f64 = 12.0;

/// Names of the components without continuous states.
fn names() -> impl Iterator<Item = &'static str> {
    REGISTRY.entries().filter(|entry| entry.info().sampled).map(|entry| entry.info().name)
}

fn outputs(name: &str) -> Vec<(usize, &'static Variable)> {
    entry(name).table().group(Group::Output).collect()
}

/// An instance with some of its variables in these groups changed.
fn moved(name: &str, groups: &[Group], random: &mut Random) -> Instance {
    let mut subject = instance(name, Interface::CoSimulation);
    // A filter rejects most sets in which a fifth is random, and many inputs matter in few.
    let share = if random.next() < 0.5 { 0.2 } else { 0.01 };
    for variable in entry(name).table().variables() {
        if !groups.contains(&variable.group) {
            continue;
        }
        if variable.name.ends_with("valid") {
            // Nothing of a sensor matters while it is absent.
            let present = f64::from(u8::from(random.next() < 0.8));
            subject.set_real(&[variable.reference], &[present]);
            continue;
        }
        if random.next() > share {
            continue;
        }
        if variable.name.ends_with("rate_hz") {
            // Thousands of samples a second would find no more than tens.
            subject.set_real(&[variable.reference], &[2.0 + 60.0 * random.next()]);
        } else {
            put(&mut subject, variable, random);
        }
    }
    subject
}

/// The outputs at the start, with one variable or the start time changed; none if that is rejected.
fn start(name: &str, seed: u64, other: Option<&Variable>) -> Option<Vec<u64>> {
    let mut random = Random(seed);
    let mut subject = moved(name, &[Group::Parameter, Group::Input], &mut random);
    let mut start_s = 0.0;
    match other {
        Some(variable) if variable.group == Group::Time => start_s = 3.7,
        Some(variable) if !put(&mut subject, variable, &mut random) => return None,
        _ => {}
    }
    subject.setup_experiment(None, start_s, None);
    subject.enter_initialization_mode();
    (subject.exit_initialization_mode() == Status::Ok).then(|| bits(name, &mut subject))
}

/// The outputs after a run with varying inputs, one of which may be changed for the last step; none
/// if the parameters are rejected.
fn run(name: &str, seed: u64, other: Option<&Variable>) -> Option<Vec<u64>> {
    let mut random = Random(seed);
    let mut subject = moved(name, &[Group::Parameter], &mut random);
    subject.enter_initialization_mode();
    if subject.exit_initialization_mode() != Status::Ok {
        return None;
    }
    let (mut t, steps) = (0.0, (STEPS * random.next()) as u64);
    for step in 0..=steps {
        for (_, input) in entry(name).table().group(Group::Input) {
            if random.next() < 0.3 {
                put(&mut subject, input, &mut random);
            }
        }
        let h = 0.02 + 0.3 * random.next();
        if let Some(variable) = other.filter(|_| step == steps) {
            put(&mut subject, variable, &mut random);
        }
        if subject.do_step(t, h) != Status::Ok {
            return None;
        }
        t += h;
    }
    Some(bits(name, &mut subject))
}

fn bits(name: &str, subject: &mut Instance) -> Vec<u64> {
    let references: Vec<u32> = outputs(name).iter().map(|(_, v)| v.reference).collect();
    let mut values = vec![0.0; references.len()];
    assert_eq!(subject.get_real(&references, &mut values), Status::Ok);
    values.into_iter().map(f64::to_bits).collect()
}

/// Checks that every difference is declared; records which known caused it.
fn note(
    name: &str,
    declared: &Declared,
    known: usize,
    (base, there): (&[u64], &[u64]),
    movers: &mut BTreeSet<usize>,
) {
    for ((unknown, variable), (a, b)) in outputs(name).into_iter().zip(base.iter().zip(there)) {
        if a != b {
            movers.insert(known);
            let known_name = &entry(name).table().variables()[known].name;
            let told = declared.contains_key(&(unknown, known));
            assert!(told, "{name}: {} moves with {known_name}", variable.name);
        }
    }
}

/// Every declared known changes some output, because all are computed at the same sample.
fn check_movers(name: &str, declared: &Declared, movers: &BTreeSet<usize>) {
    for ((_, known), kind) in declared {
        let variable = &entry(name).table().variables()[*known];
        let text = matches!(variable.start, Start::String(_));
        // Components that accept any input are declared to depend on all of them.
        let any = entry(name).table().takes_any_input() && variable.group == Group::Input;
        assert!(
            text || any || movers.contains(known),
            "{name}: nothing moves with {}",
            variable.name
        );
        assert_eq!(kind, "dependent");
    }
}

/// Compares each run with those that have one variable in these groups changed.
fn check(
    list: &str,
    moving: &[Group],
    outcome: impl Fn(&str, u64, Option<&Variable>) -> Option<Vec<u64>>,
) {
    for name in names() {
        let (declared, mut movers) = (declared::list(name, list), BTreeSet::new());
        for seed in 0..RUNS {
            let Some(base) = outcome(name, seed, None) else { continue };
            for (known, variable) in entry(name).table().variables().iter().enumerate() {
                if !moving.contains(&variable.group) {
                    continue;
                }
                if let Some(there) = outcome(name, seed, Some(variable)) {
                    note(name, &declared, known, (&base, &there), &mut movers);
                }
            }
        }
        check_movers(name, &declared, &movers);
    }
}

#[test]
fn outputs_depend_on_the_inputs_they_are_said_to() {
    check("Outputs", &[Group::Input], run);
}

#[test]
fn initial_outputs_depend_on_what_they_are_said_to() {
    check("InitialUnknowns", &[Group::Parameter, Group::Input, Group::Time], start);
}
