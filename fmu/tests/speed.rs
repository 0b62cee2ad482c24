//! The kernel's overhead over the mathematics. Run with
//! `cargo test --release -p fmu-kit --test speed -- --ignored --nocapture`.
#![allow(unsafe_code, reason = "calls of the C interface as an importer makes them")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each is a call of the C interface as an importer makes it"
)]
#![allow(unreachable_pub, reason = "shared with the other tests")]

#[path = "fmi2/driver.rs"]
#[expect(dead_code, reason = "shared with the other tests")]
mod driver;

use std::hint::black_box;
use std::time::Instant;

use components::fmi2;
use driver::{CS, Fmu};
use fmu_kit::kernel::Status;
use fmu_kit::{Component, Fault, Info, ParameterError, Resources, Time, Variables};

/// Twelve masses in a chain: 24 states, 10 inputs, 30 outputs, about the size of a vehicle.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Mass {
    /// Position
    pub x: f64,
    /// Velocity
    pub v: f64,
}

/// The states.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct States {
    /// Mass
    pub mass: [Mass; 12],
}

/// The inputs.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Forces {
    /// Force
    pub force: [f64; 10],
}

/// The outputs.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Outputs {
    /// Position
    pub position: [f64; 12],
    /// Velocity
    pub velocity: [f64; 12],
    /// Force
    pub total: [f64; 6],
}

/// The chain.
pub struct Chain;

impl Component for Chain {
    const INFO: Info = Info::new("Chain", "A chain of masses");
    type Parameters = ();
    type Inputs = Forces;
    type Outputs = Outputs;
    type States = States;
    type Memory = ();

    fn new((): &(), _: &Resources) -> Result<Self, ParameterError> {
        Ok(Self)
    }

    fn initial(&self, _: Time, _: &Forces) -> Result<(States, ()), Fault> {
        Ok((States::default(), ()))
    }

    fn derivatives(&self, _: f64, (): &(), s: &States, u: &Forces) -> States {
        let mut slope = States::default();
        for i in 0..12 {
            let left = if i > 0 { s.mass[i - 1].x } else { 0.0 };
            let right = if i < 11 { s.mass[i + 1].x } else { 0.0 };
            let m = s.mass[i];
            let force = if i < 10 { u.force[i] } else { 0.0 };
            let drag = m.v * (0.1 + 0.2 * m.v.abs()) + (m.v * m.v + 1.0).sqrt() - 1.0;
            slope.mass[i] = Mass { x: m.v, v: force + 4.0 * (left + right - 2.0 * m.x) - drag };
        }
        slope
    }

    fn outputs(&self, _: f64, (): &(), s: &States, u: &Forces) -> Outputs {
        Outputs {
            position: s.mass.map(|m| m.x),
            velocity: s.mass.map(|m| m.v),
            total: [u.force.iter().sum(); 6],
        }
    }
}

/// The same mathematics without a kernel.
fn plain(x: &mut States, u: &Forces, t: f64, h: f64) -> Outputs {
    let f = |t: f64, x: &States| Chain.derivatives(t, &(), x, u);
    let ahead = |x: &States, k: &States, h: f64| {
        let mut there = *x;
        for i in 0..12 {
            there.mass[i].x += h * k.mass[i].x;
            there.mass[i].v += h * k.mass[i].v;
        }
        there
    };
    let k1 = f(t, x);
    let k2 = f(t + 0.5 * h, &ahead(x, &k1, 0.5 * h));
    let k3 = f(t + 0.5 * h, &ahead(x, &k2, 0.5 * h));
    let k4 = f(t + h, &ahead(x, &k3, h));
    let sum = ahead(&ahead(&ahead(&k1, &k2, 2.0), &k3, 2.0), &k4, 1.0);
    *x = ahead(x, &sum, h / 6.0);
    Chain.outputs(t + h, &(), x, u)
}

mod components {
    fmu_kit::export!(super::Chain);
}

/// Nanoseconds of one call: the best of many short rounds, so that some are undisturbed.
fn nanoseconds(mut call: impl FnMut(u32)) -> f64 {
    const N: u32 = 1000;
    let round = |_| {
        let start = Instant::now();
        (0..N).for_each(&mut call);
        start.elapsed().as_secs_f64() * 1e9 / f64::from(N)
    };
    (0..1000).map(round).fold(f64::INFINITY, f64::min)
}

#[test]
#[ignore = "a measurement, for a quiet machine"]
fn overhead() {
    let mut fmu = Fmu::started("Chain", CS);
    let h = 0.01;
    let mut t = 0.0;
    let step = nanoseconds(|_| {
        assert_eq!(fmu.step(t, h), Status::Ok);
        t += h;
    });
    let vr: [u32; 10] = std::array::from_fn(|i| fmu.reference(&format!("force[{i}]")));
    let mut values = [0.1; 10];
    let c = fmu.c;
    let set = nanoseconds(|_| unsafe {
        fmi2::fmi2SetReal(c, vr.as_ptr(), 10, black_box(values.as_ptr()));
    });
    fmu.step(t, h);
    t += h;
    let outputs = vr.map(|i| i + 10);
    let get = nanoseconds(|_| unsafe {
        fmi2::fmi2GetReal(c, outputs.as_ptr(), 10, black_box(values.as_mut_ptr()));
    });
    let one = nanoseconds(|_| unsafe {
        fmi2::fmi2GetReal(c, outputs.as_ptr(), 1, black_box(values.as_mut_ptr()));
    });
    let zero = nanoseconds(|_| assert_eq!(fmu.step(t, 0.0), Status::Ok));
    println!("getReal of 1 {one:.1} ns, doStep of 0 s {zero:.1} ns");
    println!("setReal of 10 {set:.1} ns, getReal of 10 {get:.1} ns");
    let (mut x, u, mut t) = (States::default(), Forces { force: [0.1; 10] }, 0.0);
    let bare = nanoseconds(|_| {
        black_box(plain(&mut x, black_box(&u), t, h));
        t += h;
    });
    println!("doStep {step:.1} ns, plain {bare:.1} ns, ratio {:.3}", step / bare);
}
