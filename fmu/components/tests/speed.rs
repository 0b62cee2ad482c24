//! What FMI costs the vehicle: set, step and get through the C interface against the plain calls.
//! Run with `cargo test --release -p rexrov-fmu --test speed -- --ignored --nocapture`.

#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each is a call of the C interface as an importer makes it"
)]

use std::ffi::CString;
use std::hint::black_box;
use std::ptr::null;
use std::time::Instant;

use fmu_kit::abi::types::*;
use fmu_kit::kernel::Status;
use rexrov::vehicle::{Inputs, Outputs, Parameters, State, Vehicle};
use rexrov_fmu::{REGISTRY, fmi2};

/// An instance past initialization, co-simulation.
fn started(name: &str) -> fmi2Component {
    let guid = CString::new(REGISTRY.named(name).unwrap().guid()).unwrap();
    let functions = fmi2CallbackFunctions {
        logger: None,
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: std::ptr::null_mut(),
    };
    unsafe {
        let f = &raw const functions;
        let c = fmi2::fmi2Instantiate(c"speed".as_ptr(), 1, guid.as_ptr(), null(), f, 0, 0);
        assert_eq!(fmi2::fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
        assert_eq!(fmi2::fmi2EnterInitializationMode(c), Status::Ok);
        assert_eq!(fmi2::fmi2ExitInitializationMode(c), Status::Ok);
        c
    }
}

fn references(name: &str, variables: &[String]) -> Vec<u32> {
    let table = REGISTRY.named(name).unwrap().table();
    let reference = |variable: &String| table.named(variable).expect(variable).reference;
    variables.iter().map(reference).collect()
}

/// Nanoseconds of one call: the best of many short rounds, so that some are undisturbed.
fn nanoseconds(mut call: impl FnMut()) -> f64 {
    nanoseconds_of(1000, &mut call)
}

fn nanoseconds_of(n: u32, call: &mut dyn FnMut()) -> f64 {
    let round = |_| {
        let start = Instant::now();
        (0..n).for_each(|_| call());
        start.elapsed().as_secs_f64() * 1e9 / f64::from(n)
    };
    (0..1000).map(round).fold(f64::INFINITY, f64::min)
}

/// The 20 outputs an importer would read, of the plain vehicle.
fn twenty(y: &Outputs, into: &mut [f64; 20]) {
    into[..3].copy_from_slice(&y.p_ned);
    into[3..6].copy_from_slice(&y.euler);
    into[6..12].copy_from_slice(&y.nu);
    into[12..18].copy_from_slice(&y.nu_dot);
    into[18..].copy_from_slice(&y.thrust[..2]);
}

#[test]
#[ignore = "a measurement, for a quiet machine"]
fn vehicle() {
    let c = started("RexROV");
    let inputs: Vec<_> = (0..8).map(|i| format!("thruster[{i}].force")).collect();
    let mut outputs: Vec<String> = Vec::new();
    for (group, members) in [
        ("pose", "x y z roll pitch yaw"),
        ("velocity", "u v w p q r"),
        ("acceleration", "u v w p q r"),
    ] {
        outputs.extend(members.split(' ').map(|member| format!("{group}.{member}")));
    }
    outputs.extend((0..2).map(|i| format!("thruster[{i}].thrust")));
    let (set, get) = (references("RexROV", &inputs), references("RexROV", &outputs));
    let force = [100.0, 120.0, -80.0, 90.0, 10.0, -20.0, 15.0, 30.0];
    let (mut y, mut t, h) = ([0.0; 20], 0.0, 0.01);
    let all = nanoseconds(|| unsafe {
        fmi2::fmi2SetReal(c, set.as_ptr(), 8, black_box(&force).as_ptr());
        assert_eq!(fmi2::fmi2DoStep(c, t, h, 1), Status::Ok);
        fmi2::fmi2GetReal(c, get.as_ptr(), 20, y.as_mut_ptr());
        black_box(&mut y);
        t += h;
    });
    let step = nanoseconds(|| unsafe {
        assert_eq!(fmi2::fmi2DoStep(c, t, h, 1), Status::Ok);
        t += h;
    });
    let set_only = nanoseconds(|| unsafe {
        fmi2::fmi2SetReal(c, set.as_ptr(), 8, black_box(&force).as_ptr());
    });
    unsafe { fmi2::fmi2DoStep(c, t, h, 1) };
    let get_only = nanoseconds(|| unsafe {
        fmi2::fmi2GetReal(c, get.as_ptr(), 20, black_box(&mut y).as_mut_ptr());
    });

    let vehicle = Vehicle::new(&Parameters::default()).unwrap();
    let mut state = State::at_rest([0.0, 0.0, 20.0], [0.0; 3]);
    let mut u = Inputs::default();
    let plain = nanoseconds(|| {
        u.thruster_force = *black_box(&force);
        vehicle.step(&mut state, &u, h);
        twenty(&vehicle.outputs(&state, &u), &mut y);
        black_box(&mut y);
    });
    println!(
        "RexROV set 8 {set_only:.1} ns, doStep {step:.1} ns, get 20 {get_only:.1} ns; together \
         {all:.1} ns, plain {plain:.1} ns, ratio {:.3}",
        all / plain
    );
}

#[test]
#[ignore = "a measurement, for a quiet machine"]
fn states_and_lives() {
    for entry in REGISTRY.entries().filter(|entry| entry.info().name != "PurePursuit") {
        let name = entry.info().name;
        let c = started(name);
        let mut state = std::ptr::null_mut();
        unsafe { fmi2::fmi2GetFMUstate(c, &raw mut state) };
        let get_set = nanoseconds(|| unsafe {
            fmi2::fmi2GetFMUstate(c, &raw mut state);
            fmi2::fmi2SetFMUstate(c, state);
        });
        let life = nanoseconds_of(20, &mut || unsafe { fmi2::fmi2FreeInstance(started(name)) });
        println!("{name}: get + set state {get_set:.1} ns, instantiate to free {life:.0} ns");
    }
}
