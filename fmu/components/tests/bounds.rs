//! Every parameter of every component accepts its declared bounds, and nothing beyond; every input
//! accepts its bounds.

use fmu_kit::kernel::{Category, Entry, Group, Instance, Interface, Sink, Status, Variable};
use fmu_kit::{Resources, Start};
use rexrov_fmu::REGISTRY;

struct Silence;

impl Sink for Silence {
    fn write(&self, _: Status, _: Category, _: &str) {}
}

fn instance(entry: &Entry) -> Instance {
    let silence = Box::new(Silence);
    entry.instantiate(Interface::CoSimulation, Resources::none(), silence, false).unwrap()
}

/// Whether a parameter can be set to a value.
fn takes(instance: &mut Instance, variable: &Variable, value: f64) -> bool {
    let reference = [variable.reference];
    let status = match variable.start {
        Start::Real(_) => instance.set_real(&reference, &[value]),
        _ => instance.set_integer(&reference, &[value as i32]),
    };
    status == Status::Ok
}

/// Whether a simulation starts with a parameter at a value.
fn starts(entry: &Entry, variable: &Variable, value: f64) -> bool {
    let mut instance = instance(entry);
    takes(&mut instance, variable, value)
        && instance.setup_experiment(None, 0.0, None) == Status::Ok
        && instance.enter_initialization_mode() == Status::Ok
        && instance.exit_initialization_mode() == Status::Ok
}

#[test]
fn a_simulation_starts_with_every_parameter_and_input_at_its_bounds() {
    let mut refused = Vec::new();
    for entry in REGISTRY.entries() {
        let free = |v: &&Variable| matches!(v.group, Group::Parameter | Group::Input);
        for variable in entry.table().variables().iter().filter(free) {
            for bound in [variable.min, variable.max].into_iter().flatten() {
                if !starts(entry, variable, bound) {
                    refused.push(format!("{} {} = {bound}", entry.info().name, variable.name));
                }
            }
        }
    }
    assert!(refused.is_empty(), "{} are refused:\n{}", refused.len(), refused.join("\n"));
}

#[test]
fn what_is_beyond_its_bounds_is_refused_when_it_is_set() {
    for entry in REGISTRY.entries() {
        let parameters = entry.table().variables().iter().filter(|v| v.group == Group::Parameter);
        for variable in parameters {
            let beyond = |bound: f64| bound.abs().max(1.0);
            let below = variable.min.map(|min| min - beyond(min));
            let above = variable.max.map(|max| max + beyond(max));
            for value in below.into_iter().chain(above) {
                let taken = takes(&mut instance(entry), variable, value);
                assert!(!taken, "{} {} = {value}", entry.info().name, variable.name);
            }
        }
    }
}
