//! Stepping: closed forms, odd step sizes, sample instants, faults.

use fmu_kit::kernel::Status;

use crate::components::{command, fmi2};
use crate::driver::{CS, Fmu};

/// x(t) = cos(2 t) solves x'' = -4 x from rest at 1.
#[test]
fn the_oscillator_follows_its_closed_form() {
    let mut fmu = Fmu::started("Spring", CS);
    for k in 0..500 {
        assert_eq!(fmu.step(f64::from(k) * 0.02, 0.02), Status::Ok);
    }
    let error = fmu.get("position") - (2.0_f64 * 10.0).cos();
    assert!(error.abs() < 1e-11, "{error:e}");
}

/// The error of a fourth-order method falls by 16 when the step is halved.
#[test]
fn communication_steps_are_cut_into_integrator_steps() {
    let mut coarse = Fmu::started("Spring", CS);
    assert_eq!(coarse.step(0.0, 1.0), Status::Ok);
    let mut fine = Fmu::started("Spring", CS);
    for k in 0..1000 {
        assert_eq!(fine.step(f64::from(k) * 0.001, 0.001), Status::Ok);
    }
    let difference = coarse.get("position") - fine.get("position");
    assert!(difference.abs() < 1e-13, "{difference:e}");
}

#[test]
fn outputs_are_those_of_the_end_of_the_step_and_follow_new_inputs() {
    let mut fmu = Fmu::started("Spring", CS);
    fmu.set("force", 3.0);
    fmu.step(0.0, 0.5);
    let (x, a) = (fmu.get("position"), fmu.get("acceleration"));
    assert_eq!(a, 3.0 - 4.0 * x);
    let v = fmu.get("state.v");
    assert_eq!((fmu.get("der(state.x)"), fmu.get("der(state.v)")), (v, a));
    fmu.step(0.5, 0.0);
    fmu.step(0.5, 0.5);
    assert_eq!(fmu.get("der(state.x)"), fmu.get("state.v"));
    let x = fmu.get("position");
    fmu.set("force", 0.0);
    assert_eq!((fmu.get("position"), fmu.get("acceleration")), (x, -4.0 * x));
    assert_eq!((fmu.get("time"), fmu.get("der(state.v)")), (1.0, -4.0 * x));
}

#[test]
fn steps_of_rounding_size_are_taken_and_sample_nothing_twice() {
    let mut fmu = Fmu::new("Noise", CS);
    fmu.set("rate", 10.0);
    fmu.setup(0.0);
    fmu.initialize();
    let mut t = 0.0;
    for _ in 0..10 {
        assert_eq!(fmu.step(t, 0.1), Status::Ok);
        t += 0.1;
    }
    assert!(t < 1.0);
    assert_eq!(fmu.get("count"), 11.0);
    let value = fmu.get("value");
    assert_eq!(fmu.step(t, 1.0 - t), Status::Ok);
    assert_eq!(fmu.step(1.0, 1e-16), Status::Ok);
    assert_eq!(fmu.step(1.0 - 1e-16, 0.0), Status::Ok);
    assert_eq!((fmu.get("count"), fmu.get("value")), (11.0, value));
    assert_eq!(fmu.step(1.0 + 4.0 * f64::EPSILON, 0.1), Status::Ok);
    assert_eq!(fmu.get("count"), 12.0);
}

#[test]
fn samples_depend_on_time_and_not_on_the_steps() {
    let run = |steps: u32| {
        let mut fmu = Fmu::started("Noise", CS);
        let h = 6.0 / f64::from(steps);
        for k in 0..steps {
            assert_eq!(fmu.step(f64::from(k) * h, h), Status::Ok);
        }
        (fmu.get("count"), fmu.get("value"), fmu.get("stamp"))
    };
    let once = run(1);
    assert_eq!(once.0, 43.0);
    assert_eq!(once.2, 6.0);
    for steps in [2, 7, 600, 999, 6000] {
        assert_eq!(run(steps), once, "{steps} steps");
    }
}

#[test]
fn samples_are_in_the_half_open_interval_after_the_start() {
    let mut fmu = Fmu::new("Noise", CS);
    fmu.set("rate", 1.0);
    fmu.setup(100.0);
    fmu.enter();
    assert_eq!((fmu.get("count"), fmu.get("stamp")), (1.0, 100.0));
    fmu.set("signal", 5.0);
    assert!(fmu.get("value") >= 5.0 && fmu.get("count") == 1.0);
    fmu.exit();
    fmu.step(100.0, 0.5);
    assert_eq!(fmu.get("count"), 1.0);
    fmu.step(100.5, 0.5);
    assert_eq!((fmu.get("count"), fmu.get("stamp")), (2.0, 101.0));
}

#[test]
fn a_time_elsewhere_is_refused_and_both_times_named() {
    let mut fmu = Fmu::started("Spring", CS);
    fmu.step(0.0, 0.1);
    assert_eq!(fmu.step(0.0, 0.1), Status::Error);
    let line = fmu.line();
    assert!(line.contains("currentCommunicationPoint = 0 s") && line.contains("0.1 s"), "{line}");
    assert_eq!(fmu.step(0.1, 0.1), Status::Ok);
}

#[test]
fn impossible_step_sizes_are_refused() {
    let mut fmu = Fmu::started("Spring", CS);
    for h in [-0.1, f64::NAN, f64::INFINITY] {
        assert_eq!(fmu.step(0.0, h), Status::Error);
        assert!(fmu.line().contains("communicationStepSize"));
    }
    assert_eq!((fmu.step(f64::NAN, 0.1), fmu.log().len()), (Status::Error, 1));
}

#[test]
fn the_stop_time_holds_if_it_was_given() {
    let mut fmu = Fmu::new("Spring", CS);
    assert_eq!(unsafe { fmi2::fmi2SetupExperiment(fmu.c, 1, 1e-6, 0.0, 1, 0.3) }, Status::Ok);
    fmu.initialize();
    fmu.step(0.0, 0.1);
    fmu.step(0.1, 0.1);
    assert_eq!(fmu.step(0.2, 0.1), Status::Ok);
    assert_eq!(fmu.step(0.3, 0.1), Status::Error);
    assert!(fmu.line().contains("stop time"));
}

#[test]
fn a_fault_ends_the_run_with_one_line_and_values_stay_readable() {
    for (order, word) in [(command::FAULT, "told to fail"), (command::STUCK, "not later")] {
        let mut fmu = Fmu::started("Clumsy", CS);
        fmu.step(0.0, 0.05);
        fmu.set("command", order);
        assert_eq!(fmu.step(0.05, 0.1), Status::Error);
        let line = fmu.line();
        assert!(line.starts_with("fmi2DoStep: ") && line.contains(word), "{line}");
        assert_eq!(fmu.get("command"), order);
        assert_eq!((fmu.step(0.15, 0.1), fmu.log().len()), (Status::Error, 1));
        assert_eq!(unsafe { fmi2::fmi2Reset(fmu.c) }, Status::Ok);
        assert_eq!((fmu.setup(0.0), fmu.initialize()), (Status::Ok, Status::Ok));
    }
}

#[test]
fn status_functions_tell_what_there_is() {
    let mut fmu = Fmu::started("Spring", CS);
    fmu.step(0.0, 0.25);
    let (mut time, mut end, mut n) = (0.0, 7, 0);
    unsafe {
        assert_eq!(fmi2::fmi2GetRealStatus(fmu.c, 2, &raw mut time), Status::Ok);
        assert_eq!(fmi2::fmi2GetBooleanStatus(fmu.c, 3, &raw mut end), Status::Ok);
        assert_eq!((time, end), (0.25, 0));
        assert_eq!(fmi2::fmi2GetIntegerStatus(fmu.c, 0, &raw mut n), Status::Discard);
        assert_eq!(fmu.log().len(), 1);
        assert_eq!(fmi2::fmi2CancelStep(fmu.c), Status::Error);
        assert_eq!(fmu.log().len(), 1);
    }
}
