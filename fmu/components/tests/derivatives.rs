//! The vehicle's directional derivatives compared with central differences, through the C
//! interface, at random points: while running for each state and input, during initialization for
//! each Real parameter and input, for every unknown.
#![allow(unsafe_code, reason = "calls of the C interface as an importer makes them")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each is a call of the C interface as an importer makes it"
)]

mod host;

use fmu_kit::Start;
use fmu_kit::abi::types::*;
use fmu_kit::kernel::{Group, Status, Table};
use rexrov_fmu::{REGISTRY, fmi2};

const POINTS: u64 = 60;

fn ok(status: Status) {
    assert_eq!(status, Status::Ok);
}

fn table() -> &'static Table {
    REGISTRY.named("RexROV").unwrap().table()
}

/// Value references of the Reals of a group.
fn reals(group: Group) -> Vec<u32> {
    let variables = table().group(group).map(|(_, variable)| variable);
    variables.filter(|v| matches!(v.start, Start::Real(_))).map(|v| v.reference).collect()
}

/// Numbers between -1 and 1, the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// An instance for model exchange, with the thruster mode `mode` (1 to 3), in initialization mode.
fn starting(mode: i32) -> fmi2Component {
    let thruster_mode = table().named("thruster_mode").unwrap().reference;
    unsafe {
        let c = host::instantiate("RexROV", 0);
        ok(fmi2::fmi2SetInteger(c, &raw const thruster_mode, 1, &raw const mode));
        ok(fmi2::fmi2EnterInitializationMode(c));
        c
    }
}

fn set(c: fmi2Component, references: &[u32], values: &[f64]) {
    ok(unsafe { fmi2::fmi2SetReal(c, references.as_ptr(), values.len(), values.as_ptr()) });
}

fn get(c: fmi2Component, references: &[u32]) -> Vec<f64> {
    let mut values = vec![0.0; references.len()];
    ok(unsafe { fmi2::fmi2GetReal(c, references.as_ptr(), values.len(), values.as_mut_ptr()) });
    values
}

fn column(c: fmi2Component, unknowns: &[u32], known: u32) -> Vec<f64> {
    let (one, mut column) = (1.0, vec![0.0; unknowns.len()]);
    ok(unsafe {
        let (z, n, v) = (unknowns.as_ptr(), unknowns.len(), &raw const known);
        fmi2::fmi2GetDirectionalDerivative(c, z, n, v, 1, &raw const one, column.as_mut_ptr())
    });
    column
}

/// Commands within and beyond their limits, away from the limits and from zero, where there is no
/// derivative; wrench and current.
fn inputs(random: &mut Random) -> Vec<f64> {
    let input = |(_, variable): (usize, &fmu_kit::kernel::Variable)| {
        let r = random.next();
        let beyond = |limit: f64| limit * (0.05 + 0.9 * r.abs() + if r > 0.4 { 0.5 } else { 0.0 });
        match variable.name.as_str() {
            name if name.ends_with(".force") => beyond(2000.0).copysign(r * r - 0.1),
            name if name.ends_with(".speed") => beyond(2540.0).copysign(r * r - 0.1),
            name if name.starts_with("wrench") => 500.0 * r,
            _ => r,
        }
    };
    table().group(Group::Input).map(input).collect()
}

/// Compares the changes for a change of the known by its own size.
fn compare(analytic: &[f64], here: &[f64], ahead: &[f64], behind: &[f64], h: f64, size: f64) {
    for (k, slope) in analytic.iter().enumerate() {
        let difference = (ahead[k] - behind[k]) / (2.0 * h);
        let scale = size * slope.abs() + 1e-2 * (1.0 + here[k].abs());
        assert!(
            size * (slope - difference).abs() < 1e-6 * scale,
            "unknown {k}: {slope}, by differences {difference}, at {}",
            here[k]
        );
    }
}

#[test]
fn states_and_inputs_move_derivatives_and_outputs_as_in_the_functions() {
    let (states, us) = (reals(Group::State), reals(Group::Input));
    let unknowns = [reals(Group::Derivative), reals(Group::Output)].concat();
    let knowns = [&states[..], &us].concat();
    for point in 0..POINTS {
        let (mut random, mode) = (Random(point), 1 + (point % 3) as i32);
        let c = starting(mode);
        unsafe {
            ok(fmi2::fmi2ExitInitializationMode(c));
            ok(fmi2::fmi2EnterContinuousTimeMode(c));
        }
        let state = |i: usize| match i {
            0..3 => 30.0 * random.next(),
            3 => 0.8 + 0.2 * random.next(),
            4..7 => 0.35 * random.next(),
            7..13 => 1.5 * random.next(),
            _ => 900.0 * random.next(),
        };
        let x: Vec<f64> = (0..states.len()).map(state).collect();
        let at = [x, inputs(&mut random)].concat();
        let put = |at: &[f64]| {
            let (x, u) = at.split_at(states.len());
            ok(unsafe { fmi2::fmi2SetContinuousStates(c, x.as_ptr(), x.len()) });
            set(c, &us, u);
        };
        for (index, known) in knowns.iter().enumerate() {
            let h = 1e-6 * at[index].abs().max(1.0);
            let moved = |by: f64| {
                let mut there = at.clone();
                there[index] += by;
                put(&there);
                get(c, &unknowns)
            };
            let (ahead, behind, here) = (moved(h), moved(-h), moved(0.0));
            compare(&column(c, &unknowns, *known), &here, &ahead, &behind, h, 1.0);
        }
        unsafe { fmi2::fmi2FreeInstance(c) };
    }
}

#[test]
fn parameters_and_inputs_move_the_start_as_in_the_functions() {
    let parameters = table().group(Group::Parameter).map(|(_, variable)| variable);
    let parameters: Vec<_> =
        parameters.filter(|v| matches!(v.start, Start::Real(_))).cloned().collect();
    let unknowns = [Group::State, Group::Derivative, Group::Output].map(reals).concat();
    let knowns = [reals(Group::Parameter), reals(Group::Input)].concat();
    for point in 0..POINTS / 3 {
        let (mut random, mode) = (Random(1000 + point), 1 + (point % 3) as i32);
        let c = starting(mode);
        let value = |variable: &fmu_kit::kernel::Variable| {
            let Start::Real(start) = variable.start else { unreachable!() };
            match variable.name.as_str() {
                name if name.starts_with("initial.position") => 10.0 * random.next(),
                name if name.starts_with("initial.") => random.next(),
                "buoyancy" if point % 2 == 0 => 18_000.0 + 1000.0 * random.next(),
                _ => start * (1.0 + 0.1 * random.next()),
            }
        };
        let values: Vec<f64> = parameters.iter().map(value).collect();
        let at = [values, inputs(&mut random)].concat();
        set(c, &knowns, &at);
        for (index, known) in knowns.iter().enumerate() {
            let name = parameters.get(index).map_or("", |variable| &variable.name);
            let analytic = column(c, &unknowns, *known);
            if name == "buoyancy" && at[index] == 0.0 {
                // Zero means that it is computed; any other value jumps.
                assert!(analytic.iter().all(|slope| *slope == 0.0));
                continue;
            }
            let size = if at[index] == 0.0 { 1.0 } else { at[index].abs() };
            let h = 1e-6 * size;
            let moved = |by: f64| {
                set(c, &[*known], &[at[index] + by]);
                get(c, &unknowns)
            };
            let (ahead, behind, here) = (moved(h), moved(-h), moved(0.0));
            compare(&analytic, &here, &ahead, &behind, h, size);
        }
        unsafe { fmi2::fmi2FreeInstance(c) };
    }
}

/// States are unknowns at the start and knowns after it, parameters are knowns until they are
/// fixed, and time is a known that changes nothing.
#[test]
fn knowns_and_unknowns_are_those_of_the_mode() {
    let c = starting(1);
    let vr = |name: &str| table().named(name).unwrap().reference;
    let derivative = |unknown: &str, known: &str| {
        let (z, v, one, mut slope) = (vr(unknown), vr(known), 1.0, f64::NAN);
        let status = unsafe {
            let (z, v, one) = (&raw const z, &raw const v, &raw const one);
            fmi2::fmi2GetDirectionalDerivative(c, z, 1, v, 1, one, &raw mut slope)
        };
        (status == Status::Ok).then_some(slope)
    };
    assert_eq!(derivative("state.position.z", "initial.position.z"), Some(1.0));
    assert_eq!(derivative("pose.z", "initial.position.z"), Some(1.0));
    assert!(derivative("der(state.velocity.w)", "mass").unwrap() > 0.0);
    assert_eq!(derivative("der(state.velocity.w)", "time"), Some(0.0));
    assert_eq!(derivative("der(state.velocity.w)", "state.velocity.w"), None);
    ok(unsafe { fmi2::fmi2ExitInitializationMode(c) });
    assert_eq!(derivative("der(state.velocity.w)", "mass"), None);
    assert_eq!(derivative("state.position.z", "wrench.X"), None);
    assert_eq!(derivative("pose.z", "time"), Some(0.0));
    assert_eq!(derivative("pose.z", "state.position.z"), Some(1.0));
    unsafe { fmi2::fmi2FreeInstance(c) };
}
