//! Instances without C, random values for their variables.

use fmu_kit::kernel::{Category, Entry, Instance, Interface, Sink, Status, Variable};
use fmu_kit::{Resources, Start};
use rexrov_fmu::REGISTRY;

/// Numbers between 0 and 1, the same in every run.
#[derive(Clone)]
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

struct Silence;

impl Sink for Silence {
    fn write(&self, _: Status, _: Category, _: &str) {}
}

pub(crate) fn entry(name: &str) -> &'static Entry {
    REGISTRY.named(name).unwrap()
}

pub(crate) fn instance(name: &str, interface: Interface) -> Instance {
    entry(name).instantiate(interface, Resources::none(), Box::new(Silence), false).unwrap()
}

/// A random value around the start of a Real, sometimes far from it, or anywhere within its bounds.
pub(crate) fn near(variable: &Variable, random: &mut Random) -> f64 {
    let Start::Real(start) = variable.start else { return 0.0 };
    let scale = variable.nominal.unwrap_or(if start == 0.0 { 1.0 } else { start.abs() });
    let reach = scale * [0.4, 0.4, 5.0, 50.0][(4.0 * random.next()) as usize];
    let value = match (variable.min, variable.max) {
        (Some(min), Some(max)) => min + (max - min) * random.next(),
        _ => start + reach * (2.0 * random.next() - 1.0),
    };
    value.clamp(variable.min.unwrap_or(f64::MIN), variable.max.unwrap_or(f64::MAX))
}

/// Gives a variable a random value; false if it is a string or the value is rejected.
pub(crate) fn put(instance: &mut Instance, variable: &Variable, random: &mut Random) -> bool {
    let vr = [variable.reference];
    let status = match &variable.start {
        Start::Real(_) => instance.set_real(&vr, &[near(variable, random)]),
        Start::Integer(start) => {
            instance.set_integer(&vr, &[start + 1 + (9.0 * random.next()) as i32])
        }
        Start::Boolean(_) => instance.set_boolean(&vr, &[random.next() < 0.5]),
        Start::Enumeration { items, .. } => {
            let item = 1 + (items.len() as f64 * random.next()) as i32;
            instance.set_integer(&vr, &[item])
        }
        Start::String(_) => return false,
    };
    status == Status::Ok
}
