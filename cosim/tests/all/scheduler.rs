//! When values arrive.

use cosim::{Algorithm, Overrides};

use crate::models::Model::{Clock, Counter, Failing, Gain, Integrator};
use crate::ssd::{Ssd, assert_near, run};

/// clock -> a -> b -> c, listed backwards, steps of 0.1 s.
fn chain() -> Ssd {
    Ssd::new()
        .add("c", Gain)
        .add("b", Gain)
        .add("a", Gain)
        .add("clock", Clock)
        .connect("clock.y", "a.u")
        .connect("a.y", "b.u")
        .connect("b.y", "c.u")
        .stop(0.5)
}

#[test]
fn jacobi_delays_one_step_per_hop() {
    let system = chain().load(&Overrides::new().algorithm(Algorithm::Jacobi)).unwrap();
    let results = run(&system);
    assert_near(results.column("clock.y").unwrap(), &[0.0, 0.1, 0.2, 0.3, 0.4, 0.5]);
    assert_near(results.column("a.y").unwrap(), &[0.0, 0.0, 0.1, 0.2, 0.3, 0.4]);
    assert_near(results.column("c.y").unwrap(), &[0.0, 0.0, 0.0, 0.0, 0.1, 0.2]);
}

#[test]
fn gauss_seidel_has_no_delay_along_feed_through() {
    let results = chain().run();
    assert_near(results.column("c.y").unwrap(), &[0.0, 0.1, 0.2, 0.3, 0.4, 0.5]);
}

#[test]
fn without_feed_through_the_input_is_of_the_beginning() {
    let ssd = Ssd::new().add("clock", Clock).add("x", Integrator).connect("clock.y", "x.u");
    let results = ssd.stop(0.4).run();
    assert_near(results.column("x.y").unwrap(), &[0.0, 0.0, 0.01, 0.03, 0.06]);
}

#[test]
fn a_slow_component_gets_fresh_values_and_its_output_is_held() {
    // slow steps by 0.3; its value at 0.3 is from 0.3, and stays until 0.6.
    let ssd = Ssd::new()
        .add_with("slow", Gain, &[("k", 10.0)], Some(0.3))
        .add("clock", Clock)
        .add("after", Gain)
        .connect("clock.y", "slow.u")
        .connect("slow.y", "after.u")
        .stop(0.7);
    let results = ssd.run();
    let wanted = [0.0, 0.0, 0.0, 3.0, 3.0, 3.0, 6.0, 6.0];
    assert_near(results.column("slow.y").unwrap(), &wanted);
    assert_near(results.column("after.y").unwrap(), &wanted);
}

#[test]
fn a_slow_component_holds_its_input_from_the_beginning_of_its_own_step() {
    // Jacobi: the value at 0.3 is used for the step from 0.3 to 0.6, not that at 0.5.
    let ssd = Ssd::new()
        .add_with("slow", Gain, &[], Some(0.3))
        .add("clock", Clock)
        .connect("clock.y", "slow.u")
        .master("algorithm='jacobi'")
        .stop(0.6);
    assert_near(ssd.run().column("slow.y").unwrap(), &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.3]);
}

#[test]
fn steps_that_do_not_divide_each_other() {
    let ssd = Ssd::new()
        .add_with("two", Counter, &[], Some(0.2))
        .add_with("three", Counter, &[], Some(0.3))
        .master("outputInterval='0.1'")
        .stop(0.7);
    let results = ssd.run();
    // No step ends at 0.7 s: the last ones are shorter.
    assert_near(results.column("two.y").unwrap(), &[0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 4.0]);
    assert_near(results.column("three.y").unwrap(), &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 3.0]);
}

#[test]
fn a_loop_is_broken_by_the_order_of_the_file_and_reported() {
    // a.y = b.y alone: a = k b, b = k a; the edge back to a is held.
    let ssd = Ssd::new()
        .add_with("a", Gain, &[("k", 2.0)], None)
        .add_with("b", Gain, &[("k", 3.0)], None)
        .connect("b.y", "a.u")
        .connect("a.y", "b.u")
        .stop(0.2);
    let system = ssd.load(&Overrides::new()).unwrap();
    let warning = &system.warnings()[0];
    assert!(warning.contains("algebraic loop through a, b"), "{warning}");
    assert!(warning.contains("b.y -> a.u") && !warning.contains("a.y -> b.u"), "{warning}");
    // Zero everywhere is consistent, so the initialization settles and nothing grows.
    assert_near(run(&system).column("b.y").unwrap(), &[0.0, 0.0, 0.0]);
    // Jacobi has no loops to break.
    let jacobi = system.with(&Overrides::new().algorithm(Algorithm::Jacobi)).unwrap();
    assert!(jacobi.warnings().is_empty());
}

#[test]
fn a_loop_that_does_not_settle_is_reported() {
    let ssd = Ssd::new()
        .add_with("a", Gain, &[("k", 2.0)], None)
        .add_with("b", Integrator, &[("second", 1.0)], None)
        .connect("b.y", "a.u")
        .connect("a.y", "a.m")
        .stop(0.2);
    // Real to Integer is refused; the message names both types.
    let error = ssd.load(&Overrides::new()).err().unwrap().to_string();
    assert!(error.contains("Real and Integer"), "{error}");
    let ssd = Ssd::new().add_with("a", Gain, &[("k", -1.0)], None).connect("a.y", "a.u").stop(0.2);
    let system = ssd.load(&Overrides::new().start_value("a.u", 1.0)).unwrap();
    let summary = system.run(&mut []).unwrap();
    assert!(summary.warnings[0].contains("does not settle"), "{:?}", summary.warnings);
}

#[test]
fn initial_values_travel_the_whole_chain() {
    let ssd = Ssd::new()
        .add_with("c", Gain, &[("k", 5.0)], None)
        .add_with("b", Gain, &[("k", 3.0)], None)
        .add_with("x", Integrator, &[("second", 2.0)], None)
        .connect("x.y", "b.u")
        .connect("b.y", "c.u")
        .connect("c.y", "x.u")
        .stop(0.1);
    let system = ssd.load(&Overrides::new().algorithm(Algorithm::Jacobi)).unwrap();
    let results = run(&system);
    assert_near(results.column("c.y").unwrap(), &[30.0, 30.0]);
    assert_near(results.column("x.y").unwrap(), &[2.0, 5.0]);
}

#[test]
fn integers_and_booleans_travel() {
    let ssd = Ssd::new()
        .add("a", Counter)
        .add("b", Counter)
        .connect("a.n", "b.m")
        .connect("a.even", "b.odd")
        .connect("a.y", "b.u")
        .stop(0.2);
    let results = ssd.run();
    assert_near(results.column("b.n").unwrap(), &[0.0, 2.0, 4.0]);
    assert_near(results.column("b.even").unwrap(), &[0.0, 0.0, 0.0]);
}

#[test]
fn the_same_run_gives_the_same_bytes_also_in_threads() {
    let ssd = chain().add_with("x", Integrator, &[], Some(0.05)).connect("c.y", "x.u").stop(5.0);
    let system = ssd.load(&Overrides::new()).unwrap();
    let bytes = || {
        let file = tempfile::NamedTempFile::new().unwrap();
        let mut csv = cosim::observe::CsvRecorder::create(file.path()).unwrap();
        system.run(&mut [&mut csv]).unwrap();
        std::fs::read(file.path()).unwrap()
    };
    let first = bytes();
    assert!(first.starts_with(b"time,c.y,c.n,c.even,"));
    std::thread::scope(|scope| {
        let runs: Vec<_> = (0..4).map(|_| scope.spawn(bytes)).collect();
        for run in runs {
            assert_eq!(run.join().unwrap(), first);
        }
    });
}

#[test]
fn a_failing_component_keeps_results_and_says_when_and_why() {
    let ssd = Ssd::new().add("clock", Clock).add_with("pump", Failing, &[("second", 0.35)], None);
    let ssd = ssd.connect("clock.y", "pump.u");
    let system = ssd.load(&Overrides::new()).unwrap();
    let mut recording = cosim::Recording::new();
    let error = system.run(&mut [&mut recording]).unwrap_err().to_string();
    for part in ["fmi2DoStep of 'pump'", "t = 0.3", "returned Error", "the tank is empty"] {
        assert!(error.contains(part), "{part} in {error}");
    }
    assert_near(recording.column("pump.y").unwrap(), &[0.0, 0.1, 0.2, 0.3]);
}

#[test]
fn recorded_parameters_and_inputs_show_what_the_fmu_has() {
    let overrides = Overrides::new()
        .start_value("c.k", 7)
        .start_value("c.text", "four")
        .output_variables(["c.k", "*.u"]);
    // The C model puts the length of the text into k.
    let results = run(&chain().load(&overrides).unwrap());
    assert_eq!(results.names(), ["c.k", "c.u", "b.u", "a.u", "clock.u"]);
    assert_eq!(results.column("c.k").unwrap()[0], 4.0);
    assert_near(results.column("c.u").unwrap(), &[0.0, 0.1, 0.2, 0.3, 0.4, 0.5]);
}

#[test]
fn what_a_component_says_is_passed_on() {
    let system = Ssd::new().add("c", Counter).load(&Overrides::new()).unwrap();
    assert!(system.run(&mut []).unwrap().messages.is_empty());
    let system = system.with(&Overrides::new().start_value("c.text", "half empty")).unwrap();
    assert_eq!(system.run(&mut []).unwrap().messages, ["c: Warning (logAll): half empty"]);
}

#[test]
fn a_loop_that_settles_begins_with_values_that_agree() {
    // b begins with 3, a outputs 0 whatever it gets: the second pass undoes the 3.
    let ssd = Ssd::new()
        .add_with("a", Gain, &[("k", 0.0)], None)
        .add_with("b", Gain, &[("k", 3.0), ("u", 1.0)], None)
        .connect("b.y", "a.u")
        .connect("a.y", "b.u")
        .stop(0.1);
    let system = ssd.load(&Overrides::new().output_variables(["a.u", "b.u"])).unwrap();
    let mut recording = cosim::Recording::new();
    assert!(system.run(&mut [&mut recording]).unwrap().warnings.is_empty());
    assert_near(recording.column("a.u").unwrap(), &[0.0, 0.0]);
}

#[test]
fn a_loop_that_is_cut_at_a_sampled_output_is_only_noted() {
    let folder = tempfile::TempDir::new().unwrap();
    let sampled = folder.path().join("sampled.fmu");
    let y = "name=\"y\" valueReference=\"2\" causality=\"output\"";
    let description = Gain.description().replace(y, &format!("{y} variability=\"discrete\""));
    let library = std::fs::read(crate::models::compile(Gain)).unwrap();
    let entries =
        [("modelDescription.xml", description.into_bytes()), ("binaries/linux64/GAIN.so", library)];
    crate::models::pack(&sampled, &entries);
    let ssd = Ssd::new().add("a", Gain).add("b", Gain).connect("b.y", "a.u").connect("a.y", "b.u");
    let held = ssd.load(&Overrides::new().replace("b", &sampled)).unwrap();
    assert!(held.warnings().is_empty(), "{:?}", held.warnings());
    assert!(held.sampled_loops()[0].starts_with("sampled loop through a, b"));
    // Nor is it solved: a sample would affect the step that it ends.
    let iterative = Overrides::new().replace("b", &sampled).algorithm(Algorithm::Iterative);
    assert_eq!(held.with(&iterative).unwrap().solved_loops().count(), 0);
    // The cut is not at the sampled one.
    let other = held.with(&Overrides::new().replace("a", &sampled)).unwrap();
    assert!(other.notes().is_empty() && other.warnings().len() == 1);
}

#[test]
fn a_derived_system_opens_no_file_again() {
    let folder = tempfile::TempDir::new().unwrap();
    let copy = folder.path().join("copy.fmu");
    std::fs::copy(Gain.fmu(), &copy).unwrap();
    let system = chain().load(&Overrides::new()).unwrap();
    let replaced = Overrides::new().replace("c", &copy);
    drop(system.with(&replaced).unwrap());
    std::fs::remove_file(&copy).unwrap();
    assert_near(&run(&system.with(&replaced).unwrap()).column("c.y").unwrap()[4..], &[0.4, 0.5]);
}
