//! The integrators, interpolated inputs, and consequences of the tangent-linear model.

use fmu_kit::kernel::Status;

use crate::components::fmi2;
use crate::driver::{CS, Fmu, ME};

const DORMAND_PRINCE: i32 = 2;

/// Largest error of the oscillator x'' = -4 x over 10 s.
fn oscillator(tolerance: Option<f64>, explicit: Option<f64>) -> f64 {
    let mut fmu = Fmu::new("Spring", CS);
    fmu.set_integer("integrator.method", DORMAND_PRINCE);
    if let Some(explicit) = explicit {
        assert_eq!(fmu.set("integrator.tolerance", explicit), Status::Ok);
    }
    let defined = i32::from(tolerance.is_some());
    let number = tolerance.unwrap_or(f64::NAN);
    unsafe { fmi2::fmi2SetupExperiment(fmu.c, defined, number, 0.0, 0, 0.0) };
    assert_eq!(fmu.initialize(), Status::Ok);
    let expected = explicit.or(tolerance).unwrap_or(1e-6);
    assert_eq!(fmu.get("integrator.tolerance"), expected);
    let mut worst = 0.0_f64;
    for k in 0..10 {
        let t = f64::from(k);
        assert_eq!(fmu.step(t, 1.0), Status::Ok);
        worst = worst.max((fmu.get("position") - (2.0 * (t + 1.0)).cos()).abs());
    }
    worst
}

#[test]
fn the_adaptive_integrator_keeps_to_the_tolerance() {
    let errors = [1e-4, 1e-6, 1e-8, 1e-10].map(|tolerance| oscillator(Some(tolerance), None));
    for (error, tolerance) in errors.iter().zip([1e-4, 1e-6, 1e-8, 1e-10]) {
        assert!(*error < 100.0 * tolerance && *error > 1e-3 * tolerance, "{errors:?}");
    }
    assert_eq!(oscillator(None, None), errors[1]);
    // Explicit values take precedence over fmi2SetupExperiment.
    assert_eq!(oscillator(Some(1e-4), Some(1e-8)), errors[2]);
}

#[test]
fn the_fixed_step_is_a_parameter() {
    let error = |step: f64| {
        let mut fmu = Fmu::new("Spring", CS);
        fmu.set("integrator.step", step);
        fmu.setup(0.0);
        fmu.initialize();
        assert_eq!(fmu.step(0.0, 8.0), Status::Ok);
        (fmu.get("position") - 16.0_f64.cos()).abs()
    };
    let ratio = error(0.04) / error(0.02);
    assert!((13.0..19.0).contains(&ratio), "{ratio}");
}

#[test]
fn components_without_states_have_no_integrator() {
    let table = |name| crate::components::REGISTRY.named(name).unwrap().table();
    assert!(table("Spring").named("integrator.step").is_some());
    assert!(table("Noise").named("integrator.step").is_none());
}

/// Largest error of x'' = -4 x + sin(t), x(0) = 1, x'(0) = 0: x = cos 2t + sin(t)/3 - sin(2t)/6.
fn driven(h: f64, orders: usize) -> f64 {
    let mut fmu = Fmu::started("Spring", CS);
    let force = fmu.reference("force");
    let (mut worst, steps) = (0.0_f64, (6.0 / h).round() as u32);
    for k in 0..steps {
        let t = f64::from(k) * h;
        fmu.set("force", t.sin());
        let values = [t.cos(), -t.sin(), -t.cos()];
        for (order, value) in (1..).zip(values).take(orders) {
            let status = unsafe {
                fmi2::fmi2SetRealInputDerivatives(
                    fmu.c,
                    &raw const force,
                    1,
                    &raw const order,
                    &raw const value,
                )
            };
            assert_eq!(status, Status::Ok);
        }
        assert_eq!(fmu.step(t, h), Status::Ok);
        let t = t + h;
        let closed = (2.0 * t).cos() + t.sin() / 3.0 - (2.0 * t).sin() / 6.0;
        worst = worst.max((fmu.get("position") - closed).abs());
    }
    worst
}

/// Each order of derivatives raises the order of the error by one.
#[test]
fn interpolated_inputs_are_more_accurate_by_their_order() {
    for orders in 0..=3 {
        let order = (driven(0.1, orders) / driven(0.05, orders)).log2();
        assert!((order - (orders as f64 + 1.0)).abs() < 0.25, "{orders}: {order}");
    }
    assert!(driven(0.1, 1) < 0.05 * driven(0.1, 0));
}

#[test]
fn input_derivatives_serve_one_step_and_the_input_ends_where_it_got_to() {
    let mut fmu = Fmu::started("Spring", CS);
    let (force, order, slope) = (fmu.reference("force"), 1, 2.0);
    fmu.set("force", 1.0);
    unsafe {
        let (vr, order, slope) = (&raw const force, &raw const order, &raw const slope);
        fmi2::fmi2SetRealInputDerivatives(fmu.c, vr, 1, order, slope);
    }
    fmu.step(0.0, 0.5);
    assert_eq!(fmu.get("force"), 2.0);
    assert_eq!(fmu.get("acceleration"), 2.0 - 4.0 * fmu.get("position"));
    fmu.step(0.5, 0.5);
    assert_eq!(fmu.get("force"), 2.0);
}

#[test]
fn input_derivatives_are_checked() {
    let mut fmu = Fmu::started("Spring", CS);
    let (force, position) = (fmu.reference("force"), fmu.reference("position"));
    for (vr, order, value, word) in [
        (position, 1, 0.0, "not an input"),
        (force, 0, 0.0, "order = 0"),
        (force, 4, 0.0, "order = 4"),
        (force, 1, f64::NAN, "not finite"),
    ] {
        let (vr, order, value) = (&raw const vr, &raw const order, &raw const value);
        let status = unsafe { fmi2::fmi2SetRealInputDerivatives(fmu.c, vr, 1, order, value) };
        assert_eq!(status, Status::Error);
        let line = fmu.line();
        assert!(line.contains(word), "{line}");
    }
}

fn directional(fmu: &Fmu, unknown: &str, known: &str) -> f64 {
    let (unknown, known) = (fmu.reference(unknown), fmu.reference(known));
    let (along, mut into) = (2.0, f64::NAN);
    let status = unsafe {
        fmi2::fmi2GetDirectionalDerivative(
            fmu.c,
            &raw const unknown,
            1,
            &raw const known,
            1,
            &raw const along,
            &raw mut into,
        )
    };
    assert_eq!(status, Status::Ok);
    0.5 * into
}

#[test]
fn directional_derivatives_are_those_of_the_functions() {
    let mut fmu = Fmu::started("Pendulum", ME);
    unsafe { fmi2::fmi2EnterContinuousTimeMode(fmu.c) };
    let (x, torque, h) = ([0.7, -1.3], 0.4, 1e-6);
    let at = |fmu: &mut Fmu, known: usize, by: f64, unknown: &str| {
        let (mut x, mut u) = (x, torque);
        if known < 2 {
            x[known] += by
        } else {
            u += by
        }
        unsafe { fmi2::fmi2SetContinuousStates(fmu.c, x.as_ptr(), 2) };
        fmu.set("torque", u);
        fmu.get(unknown)
    };
    for unknown in ["der(state.angle)", "der(state.rate)", "x", "power"] {
        for (index, known) in ["state.angle", "state.rate", "torque"].into_iter().enumerate() {
            let ahead = at(&mut fmu, index, h, unknown);
            let difference = (ahead - at(&mut fmu, index, -h, unknown)) / (2.0 * h);
            at(&mut fmu, index, 0.0, unknown);
            let analytic = directional(&fmu, unknown, known);
            assert!((analytic - difference).abs() < 1e-8, "{unknown} to {known}");
        }
    }
}

#[test]
fn directional_derivatives_of_what_they_are_not_of_are_refused() {
    let mut fmu = Fmu::started("Pendulum", CS);
    let vr = |name: &str| fmu.reference(name);
    let pairs = [
        (vr("torque"), vr("state.angle")),
        (vr("x"), vr("power")),
        (vr("x"), vr("integrator.step")),
        (vr("x"), 999),
    ];
    for (unknown, known) in pairs {
        let (along, mut into) = (1.0, 0.0);
        let (z, v) = (&raw const unknown, &raw const known);
        let (dv, dz) = (&raw const along, &raw mut into);
        let status = unsafe { fmi2::fmi2GetDirectionalDerivative(fmu.c, z, 1, v, 1, dv, dz) };
        assert_eq!((status, fmu.log().len()), (Status::Error, 1));
    }
}

/// States follow from parameters and inputs there, so their changes propagate to everything else.
#[test]
fn directional_derivatives_of_the_start_are_those_of_the_functions() {
    let mut fmu = Fmu::new("Pendulum", ME);
    assert_eq!(fmu.setup(0.0), Status::Ok);
    assert_eq!(unsafe { fmi2::fmi2EnterInitializationMode(fmu.c) }, Status::Ok);
    fmu.set("torque", 0.7);
    let unknowns =
        ["state.angle", "state.rate", "der(state.angle)", "der(state.rate)", "x", "power"];
    for known in ["start", "damping", "torque"] {
        let (at, h) = (fmu.get(known), 1e-6);
        for unknown in unknowns {
            fmu.set(known, at + h);
            let ahead = fmu.get(unknown);
            fmu.set(known, at - h);
            let difference = (ahead - fmu.get(unknown)) / (2.0 * h);
            fmu.set(known, at);
            let analytic = directional(&fmu, unknown, known);
            assert!((analytic - difference).abs() < 1e-8, "{unknown} to {known}");
        }
    }
    assert_eq!(directional(&fmu, "power", "torque"), 1.4);
    assert_eq!(directional(&fmu, "der(state.rate)", "time"), 0.0);
    assert_eq!(directional(&fmu, "der(state.rate)", "integrator.step"), 0.0);
}

#[test]
fn a_refused_directional_derivative_says_what_is_possible_in_the_mode() {
    let mut fmu = Fmu::new("Pendulum", ME);
    fmu.setup(0.0);
    unsafe { fmi2::fmi2EnterInitializationMode(fmu.c) };
    let refused = |fmu: &mut Fmu, unknown: &str, known: &str| {
        let (z, v) = (fmu.reference(unknown), fmu.reference(known));
        let (z, v, along, mut into) = (&raw const z, &raw const v, 1.0, 0.0);
        let dz = &raw mut into;
        let c = fmu.c;
        let status =
            unsafe { fmi2::fmi2GetDirectionalDerivative(c, z, 1, v, 1, &raw const along, dz) };
        assert_eq!(status, Status::Error);
        fmu.line()
    };
    let line = refused(&mut fmu, "x", "state.angle");
    let words = "state.angle cannot be the known in initialization mode: it is of the continuous \
                 states; possible are inputs, parameters, time";
    assert!(line.contains(words), "{line}");
    unsafe { fmi2::fmi2ExitInitializationMode(fmu.c) };
    let line = refused(&mut fmu, "x", "damping");
    assert!(line.contains("damping cannot be the known in event mode"), "{line}");
    let line = refused(&mut fmu, "state.angle", "torque");
    assert!(line.contains("state.angle cannot be the unknown in event mode"), "{line}");
}

#[test]
fn output_derivatives_are_those_of_the_motion() {
    let mut fmu = Fmu::started("Pendulum", CS);
    let (torque, order, slope) = (fmu.reference("torque"), 1, 0.3);
    let (h, mut t, mut earlier) = (1e-4, 0.0, 0.0);
    let (vr, mut rate) = (fmu.reference("power"), 0.0);
    for _ in 0..2000 {
        earlier = fmu.get("power");
        let (order, slope) = (&raw const order, &raw const slope);
        unsafe { fmi2::fmi2SetRealInputDerivatives(fmu.c, &raw const torque, 1, order, slope) };
        assert_eq!(fmu.step(t, h), Status::Ok);
        t += h;
    }
    let (vr, order) = (&raw const vr, &raw const order);
    let status = unsafe { fmi2::fmi2GetRealOutputDerivatives(fmu.c, vr, 1, order, &raw mut rate) };
    assert_eq!(status, Status::Ok);
    let difference = (fmu.get("power") - earlier) / h;
    assert!((rate - difference).abs() < 1e-3 * rate.abs(), "{rate} {difference}");
    let second = 2;
    let status = unsafe {
        fmi2::fmi2GetRealOutputDerivatives(fmu.c, vr, 1, &raw const second, &raw mut rate)
    };
    assert_eq!((status, fmu.log().len()), (Status::Error, 1));
}

/// A discarded step reports how far it got, and the simulation can continue from an earlier state.
#[test]
fn a_step_that_cannot_be_finished_is_discarded() {
    let mut fmu = Fmu::new("Spring", CS);
    let (sprung, no) = (fmu.reference("sprung"), 0);
    unsafe { fmi2::fmi2SetBoolean(fmu.c, &raw const sprung, 1, &raw const no) };
    assert_eq!((fmu.setup(0.0), fmu.initialize()), (Status::Ok, Status::Ok));
    assert_eq!(fmu.step(0.0, 0.1), Status::Ok);
    let (mut state, mut time) = (std::ptr::null_mut(), 0.0);
    unsafe { fmi2::fmi2GetFMUstate(fmu.c, &raw mut state) };
    fmu.set("force", 1e303);
    assert_eq!(fmu.step(0.1, 1000.0), Status::Discard);
    let line = fmu.line();
    assert!(line.contains("fmi2DoStep: step from 0.1 s") && line.contains("not finite"), "{line}");
    unsafe {
        assert_eq!(fmi2::fmi2GetRealStatus(fmu.c, 2, &raw mut time), Status::Ok);
        assert!(time > 0.1 && time < 1000.0, "{time}");
        assert_eq!(fmu.get("time"), time);
        assert!(fmu.get("position").is_finite());
        assert_eq!(fmu.step(time, 0.1), Status::Error);
        assert!(fmu.line().contains("after a discarded step"));
        assert_eq!(fmi2::fmi2SetFMUstate(fmu.c, state), Status::Ok);
    }
    assert_eq!(fmu.step(0.1, 0.1), Status::Ok);
}
