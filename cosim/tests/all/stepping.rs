//! Steps that are rejected, repeated, and controlled by their error; inputs that move.

use cosim::fmi::Fmu;
use cosim::observe::Stop;
use cosim::{Algorithm, Code, Input, Overrides, Recording, Run};
use tempfile::TempDir;

use crate::models::Model::{
    Affine, Ball, Clock, Cubic, Gain, Inertia, Integrator, Lag, Mass, Picky, Sawtooth, Ticker,
};
use crate::ssd::{Ssd, assert_near, run};

fn masses() -> Ssd {
    let values = |start: f64| [("k", 5.0), ("second", 3.0), ("m", start)];
    Ssd::new()
        .add_with("a", Mass, &values(1.0), None)
        .add_with("b", Mass, &values(0.0), None)
        .connect("a.y", "b.u")
        .connect("b.y", "a.u")
        .stop(4.0)
}

/// The maximum error of the first mass: its exact solution has the modes 2 and 8.
fn error(results: &Recording) -> f64 {
    let exact = |t: f64| 0.5 * ((2.0_f64.sqrt() * t).cos() + (8.0_f64.sqrt() * t).cos());
    let found = results.time().iter().zip(results.column("a.y").unwrap());
    found.map(|(t, y)| (y - exact(*t)).abs()).fold(0.0, f64::max)
}

#[test]
fn the_error_follows_the_tolerance_of_the_step_control() {
    for input in [Input::Hold, Input::Linear] {
        let outcome = |tolerance: f64| {
            let overrides = Overrides::new().step_control(tolerance).input("", input);
            let system = masses().load(&overrides).unwrap();
            let mut recording = Recording::new();
            let summary = system.run(&mut [&mut recording]).unwrap();
            assert!(summary.warnings.is_empty(), "{:?}", summary.warnings);
            assert!(summary.notes.iter().any(|n| n.contains("accepted")), "{:?}", summary.notes);
            (error(&recording), summary)
        };
        // Held forces are integrated twice before they have an effect: at least 1000^(1/3) is
        // expected.
        let ((coarse, few), (fine, many)) = (outcome(1e-3), outcome(1e-6));
        assert!(coarse < 0.1 && fine < coarse / 5.0, "{input:?}: {coarse} {fine}");
        assert!(many.steps > 2 * few.steps && many.components[0].rejected > 0, "{many:?}");
    }
}

#[test]
fn taking_steps_back_neither_loses_nor_doubles_an_event() {
    // The masses make the control reject steps; ball and ticker go back with them.
    let ssd = masses().add("ball", Ball).add_with("ticks", Ticker, &[("k", 0.07)], None).stop(1.2);
    let names = ["a.y", "ball.y", "ball.n", "ticks.n"];
    let base = Overrides::new().output_variables(names);
    let plain = run(&ssd.load(&base).unwrap());
    let controlled = ssd.load(&base.step_control(1e-4)).unwrap();
    let mut recording = Recording::new();
    let summary = controlled.run(&mut [&mut recording]).unwrap();
    assert!(summary.components[0].rejected > 0);
    for name in ["ball.n", "ticks.n"] {
        assert_eq!(recording.column(name).unwrap(), plain.column(name).unwrap(), "{name}");
    }
    assert_near(recording.column("ball.y").unwrap(), plain.column("ball.y").unwrap());
}

#[test]
fn a_component_that_cannot_go_back_is_named() {
    let folder = TempDir::new().unwrap();
    let flag = "canHandleVariableCommunicationStepSize=\"true\"";
    let fixed = Gain.varied(folder.path(), flag, "");
    let ssd = Ssd::new().add("g", Gain).add("h", Gain);
    let overrides = Overrides::new().replace("h", &fixed).step_control(1e-3);
    let error = ssd.load(&overrides).err().unwrap().to_string();
    assert!(error.contains("'h' cannot follow a step control") && error.contains("canHandleVar"));
    assert!(!error.contains("'g'"), "{error}");
    assert!(ssd.load(&Overrides::new().step_control(2.0)).is_err());
}

#[test]
fn a_discarded_step_is_made_again_by_smaller_ones() {
    // It discards steps longer than 0.04 s, after 0.02 s or without reporting how far it got.
    for silent in [0.0, 1.0] {
        let values = [("second", 0.04), ("m", silent)];
        let ssd = Ssd::new()
            .add("clock", Clock)
            .add_with("x", Picky, &values, None)
            .connect("clock.y", "x.u")
            .stop(0.4);
        let error = ssd.load(&Overrides::new()).unwrap().run(&mut []).unwrap_err().to_string();
        assert!(error.to_lowercase().contains("discard") && error.contains("--retries"), "{error}");
        let system = ssd.load(&Overrides::new().retries(4)).unwrap();
        let mut recording = Recording::new();
        let summary = system.run(&mut [&mut recording]).unwrap();
        assert_near(recording.column("x.y").unwrap(), &[0.0, 0.0, 0.01, 0.03, 0.06]);
        assert!(summary.components[1].rejected >= 4, "{summary:?}");
        // The half of 0.1 s is still too long; 0.02 s, where it reports that, is not.
        let outcome = ssd.load(&Overrides::new().retries(1)).unwrap().run(&mut []);
        assert_eq!(outcome.err().map(|e| e.code()), (silent == 1.0).then_some(Code::Step));
        let controlled = ssd.load(&Overrides::new().step_control(0.1)).unwrap();
        let mut recording = Recording::new();
        let summary = controlled.run(&mut [&mut recording]).unwrap();
        assert!(summary.components[1].rejected > 0, "{summary:?}");
        let end = *recording.column("x.y").unwrap().last().unwrap();
        assert!((0.06..0.08).contains(&end), "{end}");
    }
}

#[test]
fn an_fmu_that_ends_the_run_does_not_fail() {
    let ending = |model, values: &[(&str, f64)]| {
        Ssd::new().add("clock", Clock).add_with("x", model, values, None).stop(5.0)
    };
    // By a discarded step, and by completedIntegratorStep.
    let picky = ending(Picky, &[("second", 0.25), ("m", 2.0)]);
    let saw = ending(Sawtooth, &[("m", 2.0)]);
    for (ssd, end, reported, why) in
        [(&picky, 0.2, "t = 0.25 s", "fmi2Terminated"), (&saw, 2.0, "t = 2", "terminateSimulation")]
    {
        for overrides in [Overrides::new(), Overrides::new().retries(3)] {
            let system = ssd.load(&overrides).unwrap();
            let mut recording = Recording::new();
            let summary = system.run(&mut [&mut recording]).unwrap();
            assert_eq!(summary.stopped, Some(Stop::Component));
            let time = recording.time();
            assert!((summary.simulated - end).abs() < 0.11, "{summary:?}");
            assert_eq!(time.last(), Some(&summary.simulated));
            assert_near(recording.column("clock.y").unwrap(), time);
            let warning = &summary.warnings[0];
            assert!(warning.contains(&format!("'x' ended the run at {reported}")), "{warning}");
            assert!(warning.contains(why), "{warning}");
        }
    }
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_cosim"))
        .args(["run", picky.write().to_str().unwrap(), "-o-"])
        .output()
        .unwrap();
    let (out, reported) = (String::from_utf8(output.stdout), String::from_utf8(output.stderr));
    assert_eq!((output.status.code(), out.unwrap().lines().count()), (Some(0), 4));
    assert!(reported.as_ref().is_ok_and(|t| t.contains("'x' ended the run")), "{reported:?}");
}

#[test]
fn linear_inputs_serve_slow_and_fast_components() {
    let error = |input: Input| {
        let overrides = Overrides::new().step("a", 0.05).step("b", 0.01).output_interval(0.1);
        error(&run(&masses().load(&overrides.input("", input)).unwrap()))
    };
    let (hold, linear) = (error(Input::Hold), error(Input::Linear));
    assert!(hold > 0.05 && linear < hold / 10.0, "{hold} {linear}");
}

#[test]
fn slopes_come_from_differences_where_a_source_provides_none() {
    let folder = TempDir::new().unwrap();
    let silent = Mass.varied(folder.path(), "maxOutputDerivativeOrder=\"1\"", "");
    let error = |overrides: Overrides| {
        let overrides = overrides.step("a", 0.01).step("b", 0.01).output_interval(0.1);
        error(&run(&masses().load(&overrides.input("", Input::Linear)).unwrap()))
    };
    let reported = error(Overrides::new());
    let guessed = error(Overrides::new().replace("a", &silent).replace("b", &silent));
    assert!(reported < guessed && guessed < 1e-2, "{reported} {guessed}");
}

#[test]
fn model_exchange_takes_linear_inputs_and_named_ones_only() {
    // x' = u - x / 2 with u = t: exact when u is linear.
    let ssd = Ssd::new().add("clock", Clock).add("x", Lag).connect("clock.y", "x.u").stop(1.0);
    let exact = |t: f64| 2.0 * t - 4.0 + 4.0 * (-0.5 * t).exp();
    for (name, works) in [("", true), ("x.*", true), ("x.u", true)] {
        let system = ssd.load(&Overrides::new().input(name, Input::Linear)).unwrap();
        let results = run(&system);
        let end = *results.column("x.y").unwrap().last().unwrap();
        // The slope of the clock is known after its first step only.
        assert_eq!((end - exact(1.0)).abs() < 6e-3, works, "{end} {}", exact(1.0));
    }
    let typo = ssd.load(&Overrides::new().input("x.v", Input::Linear)).err().unwrap();
    assert!(typo.to_string().contains("did you mean 'x.u'"), "{typo}");
    let hold = Overrides::new().input("", Input::Linear).input("x.u", Input::Hold);
    let end = *run(&ssd.load(&hold).unwrap()).column("x.y").unwrap().last().unwrap();
    assert!((end - exact(1.0)).abs() > 1e-2);
    let unable = Ssd::new().add("a", Gain).add("b", Gain).connect("a.y", "b.u");
    let system = unable.load(&Overrides::new().input("", Input::Linear)).unwrap();
    assert!(system.notes()[0].contains("'b' holds its inputs"), "{:?}", system.notes());
}

#[test]
fn directional_derivatives_save_passes_where_they_are_provided() {
    let folder = TempDir::new().unwrap();
    let flag = "canGetAndSetFMUstate=\"true\"";
    let able = format!("{flag} providesDirectionalDerivative=\"true\"");
    let cubic = Cubic.varied(folder.path(), flag, &able);
    let affine = Affine.varied(folder.path(), flag, &able);
    assert!(
        Fmu::open(&cubic)
            .unwrap()
            .description()
            .co_simulation
            .as_ref()
            .unwrap()
            .directional_derivative
    );
    let ssd = Ssd::new()
        .add_with("x", Cubic, &[("k", 5.0)], None)
        .add_with("z", Affine, &[("k", 0.5)], None)
        .connect("x.y", "z.u")
        .connect("z.y", "x.u")
        .stop(1.0);
    let base = Overrides::new().algorithm(Algorithm::Iterative);
    let passes = |overrides: Overrides| {
        let system = ssd.load(&overrides).unwrap();
        let mut recording = Recording::new();
        let summary = system.run(&mut [&mut recording]).unwrap();
        let (x, z) = (recording.column("x.y").unwrap(), recording.column("z.y").unwrap());
        for ((t, x), z) in recording.time().iter().zip(x).zip(z) {
            assert!((x - (t - 5.0 * z.powi(3))).abs() < 1e-8);
        }
        (summary.steps, summary.notes[0].clone())
    };
    let (by_differences, reported) = passes(base.clone());
    assert!(reported.contains("by differences") && reported.contains("residual"), "{reported}");
    let both = base.clone().replace("x", &cubic).replace("z", &affine);
    let (by_derivatives, reported) = passes(both);
    assert!(reported.contains("Jacobians by directional derivatives"), "{reported}");
    assert!(by_derivatives * 3 < by_differences * 2, "{by_derivatives} {by_differences}");
    // One member provides none: differences for the whole loop.
    let (_, reported) = passes(base.replace("x", &cubic));
    assert!(reported.contains("by differences"), "{reported}");
}

#[test]
fn costs_are_reported_for_each_component() {
    let ssd = Ssd::new()
        .add("a", Inertia)
        .add_with("slow", Integrator, &[], Some(0.5))
        .connect("a.y", "slow.u")
        .stop(100.0);
    let system = ssd.load(&Overrides::new()).unwrap();
    let summary = Run::new(&system).go().unwrap();
    let (a, slow) = (&summary.components[0], &summary.components[1]);
    assert_eq!((a.steps, slow.steps, summary.steps), (1000, 200, 1200));
    assert!(a.seconds_per_step > 0.0 && (a.share + slow.share - 1.0).abs() < 1e-9);
    assert!(a.share > slow.share && a.rejected == 0);
}
