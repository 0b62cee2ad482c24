//! The vehicle's limits as state events: a rotor whose commanded speed ramps up into its limit
//! follows the closed form of a first-order lag on both sides of the kink.
#![allow(unsafe_code, reason = "calls of the C interface as an importer makes them")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each is a call of the C interface as an importer makes it"
)]

mod host;

use fmu_kit::abi::types::*;
use fmu_kit::kernel::Status;
use rexrov_fmu::{REGISTRY, fmi2};

/// Time constant of the rotors (s), limit of thrust (N), thrust over speed squared.
const TAU: f64 = 0.05;
const LIMIT: f64 = 2000.0;
const GAIN: f64 = 0.00031;
/// When the ramp reaches the limit (s): within an integration step, not at its end.
const CROSSING: f64 = 0.053_71;
/// thruster_mode RotorSpeed
const ROTOR_SPEED: i32 = 3;
const INDICATORS: usize = 16;

fn ok(status: Status) {
    assert_eq!(status, Status::Ok);
}

fn fastest() -> f64 {
    (LIMIT / GAIN).sqrt()
}

/// Speed of a rotor that starts at rest.
fn rotor(t: f64) -> f64 {
    let slope = fastest() / CROSSING;
    let ramp = |t: f64| slope * (t - TAU + TAU * (-t / TAU).exp());
    if t < CROSSING {
        return ramp(t);
    }
    fastest() + (ramp(CROSSING) - fastest()) * (-(t - CROSSING) / TAU).exp()
}

struct Rov(fmi2Component);

impl Rov {
    fn new(interface: fmi2Type, method: i32) -> Self {
        let integers = [Self::vr("thruster_mode"), Self::vr("integrator.method")];
        let values = [ROTOR_SPEED, method];
        unsafe {
            let c = host::instantiate("RexROV", interface);
            ok(fmi2::fmi2SetInteger(c, integers.as_ptr(), 2, values.as_ptr()));
            let rov = Self(c);
            rov.set("integrator.step", 0.001);
            rov.set("integrator.tolerance", 1e-10);
            ok(fmi2::fmi2EnterInitializationMode(c));
            ok(fmi2::fmi2ExitInitializationMode(c));
            rov
        }
    }

    fn vr(name: &str) -> u32 {
        REGISTRY.named("RexROV").unwrap().table().named(name).unwrap().reference
    }

    fn set(&self, name: &str, value: f64) {
        let vr = Self::vr(name);
        ok(unsafe { fmi2::fmi2SetReal(self.0, &raw const vr, 1, &raw const value) });
    }

    fn get(&self, name: &str) -> f64 {
        let (vr, mut value) = (Self::vr(name), f64::NAN);
        ok(unsafe { fmi2::fmi2GetReal(self.0, &raw const vr, 1, &raw mut value) });
        value
    }

    fn indicators(&self) -> [f64; INDICATORS] {
        let mut z = [0.0; INDICATORS];
        ok(unsafe { fmi2::fmi2GetEventIndicators(self.0, z.as_mut_ptr(), INDICATORS) });
        z
    }
}

impl Drop for Rov {
    fn drop(&mut self) {
        unsafe { fmi2::fmi2FreeInstance(self.0) };
    }
}

#[test]
fn co_simulation_finds_the_limit_within_a_step() {
    for method in [1, 2] {
        let rov = Rov::new(1, method);
        let (slope, order, vr) = (fastest() / CROSSING, 1, Rov::vr("thruster[4].speed"));
        let h = 0.02;
        for k in 0..10 {
            let t = f64::from(k) * h;
            rov.set("thruster[4].speed", slope * t);
            unsafe {
                let (vr, order, slope) = (&raw const vr, &raw const order, &raw const slope);
                ok(fmi2::fmi2SetRealInputDerivatives(rov.0, vr, 1, order, slope));
                ok(fmi2::fmi2DoStep(rov.0, t, h, 1));
            }
            let error = rov.get("state.rotor[4].speed") - rotor(t + h);
            assert!(error.abs() < 1e-9 * fastest(), "method {method}, {t} s: {error}");
        }
    }
}

/// An importer's root finder sees one indicator change its sign, at the limit and nowhere else,
/// with nothing to do there.
#[test]
fn model_exchange_shows_the_limit_by_one_indicator() {
    let rov = Rov::new(0, 1);
    ok(unsafe { fmi2::fmi2EnterContinuousTimeMode(rov.0) });
    let signs = |t: f64| {
        ok(unsafe { fmi2::fmi2SetTime(rov.0, t) });
        rov.set("thruster[4].speed", fastest() * t / CROSSING);
        rov.indicators().map(|z| z > 0.0)
    };
    let (first, last) = (signs(0.0), signs(0.1));
    let crossed: Vec<usize> = (0..INDICATORS).filter(|i| first[*i] != last[*i]).collect();
    assert_eq!(crossed, [4]);
    assert!(first.iter().all(|positive| *positive), "at rest nothing is at a kink");
    let (mut before, mut behind) = (0.0, 0.1);
    while behind - before > 1e-14 {
        let middle = 0.5 * (before + behind);
        if signs(middle)[4] { before = middle } else { behind = middle }
    }
    assert!((behind - CROSSING).abs() < 1e-12, "{behind}");
    signs(behind);
    let mut info = fmi2EventInfo::default();
    unsafe {
        ok(fmi2::fmi2EnterEventMode(rov.0));
        ok(fmi2::fmi2NewDiscreteStates(rov.0, &raw mut info));
    }
    let flags = [info.newDiscreteStatesNeeded, info.valuesOfContinuousStatesChanged];
    assert_eq!(flags, [FMI2_FALSE; 2]);
}

/// A force held at its limit, and a force of zero, are within; a step beyond is not.
#[test]
fn being_at_a_limit_is_no_event() {
    let rov = Rov::new(0, 1);
    ok(unsafe { fmi2::fmi2EnterContinuousTimeMode(rov.0) });
    for (speed, inside) in [(0.0, true), (fastest(), true), (-fastest(), true), (2600.0, false)] {
        rov.set("thruster[2].speed", speed);
        let z = rov.indicators();
        assert_eq!(z[2] > 0.0, inside, "{speed}");
        assert!(z.iter().all(|z| *z != 0.0));
    }
}
