//! An exported system computes the same as its run, to the last bit.

use cosim::{Algorithm, Input, Overrides, System};

use super::{assert_same, export, get, set, step};
use crate::formats::Folder;
use crate::models::Model::{Clock, Counter, Cubic, Gain, Inertia, Integrator, Mass, Oscillator};
use crate::osp;
use crate::ssd::{Ssd, run, zoo};

#[test]
fn every_algorithm_gives_the_same_bits_at_every_communication_step() {
    for algorithm in ["jacobi", "gauss-seidel", "iterative"] {
        let system = zoo();
        let chosen: Algorithm = algorithm.parse().unwrap();
        let wanted = run(&system.load(&Overrides::new().algorithm(chosen)).unwrap());
        let exported = export(&system.write(), &["--algorithm", algorithm]);
        for length in [0.1, 0.3, 0.5] {
            let stop = Overrides::new().stop_time(1.5);
            assert_same(&exported.run(length, stop), &wanted);
        }
    }
}

#[test]
fn options_of_the_run_come_along() {
    let system = Ssd::new()
        .add("swing", Oscillator)
        .add_with("mass", Mass, &[("k", 5.0), ("second", 1.0), ("m", 1.0)], None)
        .add_with("inertia", Inertia, &[("k", 5.0)], None)
        .connect("mass.y", "inertia.u")
        .connect("swing.y", "mass.u");
    let overrides = Overrides::new().input("", Input::Linear).step_control(1e-4);
    let overrides = overrides.solver(cosim::system::Method::RungeKutta4);
    let wanted = run(&system.load(&overrides).unwrap());
    let options = ["--input", "linear", "--step-control", "1e-4", "--solver", "rk4"];
    let exported = export(&system.write(), &options);
    assert_same(&exported.run(0.1, Overrides::new()), &wanted);
    let held = run(&system.load(&Overrides::new()).unwrap());
    let (a, b) = (wanted.column("mass.y").unwrap(), held.column("mass.y").unwrap());
    assert_ne!(a, b, "the options change nothing: this test shows nothing");
}

#[test]
fn sums_of_osp_come_along() {
    let folder = Folder::new();
    let file = folder.write("OspSystemStructure.xml", &osp::summed());
    let wanted = run(&System::load(&file, &Overrides::new()).unwrap());
    let exported = export(&file, &[]);
    assert_same(&exported.run(0.1, Overrides::new()), &wanted);
}

#[test]
fn parameters_are_those_of_a_run_with_start_values() {
    let system = Ssd::new().add("clock", Clock).add("g", Cubic).connect("clock.y", "g.u");
    let wanted = system.load(&Overrides::new().start_value("g.k", 0.37)).unwrap();
    let exported = export(&system.write(), &[]);
    let given = Overrides::new().start_value("g.k", 0.37);
    assert_same(&exported.run(0.1, given), &run(&wanted));
}

#[test]
fn between_instants_outputs_hold_and_each_instant_is_made_once() {
    let exported = export(&Ssd::new().add("count", Counter).write(), &[]);
    let mut instance = exported.started();
    let instants = [0.03, 0.0999, 0.1, 0.1, 0.25, 0.3000000000000001, 0.9];
    let counts = [0.0, 0.0, 1.0, 1.0, 2.0, 3.0, 9.0];
    let mut begin = 0.0;
    for (end, count) in instants.into_iter().zip(counts) {
        step(&mut instance, begin, end);
        assert_eq!(get(&mut instance, "count.y"), count, "at {end}");
        begin = end;
    }
}

#[test]
fn inputs_hold_from_the_beginning_of_a_step() {
    let exported = export(&Ssd::new().add("i", Integrator).add("g", Gain).write(), &[]);
    let mut instance = exported.started();
    set(&mut instance, "i.u", 2.0);
    set(&mut instance, "g.u", 7.0);
    // Set, but no step has been made yet.
    assert_eq!([get(&mut instance, "g.y"), get(&mut instance, "g.u")], [0.0, 7.0]);
    step(&mut instance, 0.0, 0.5);
    set(&mut instance, "i.u", 10.0);
    step(&mut instance, 0.5, 0.55);
    let after = get(&mut instance, "i.y");
    step(&mut instance, 0.55, 0.6);
    assert!((after - 1.0).abs() < 1e-12, "{after}");
    assert!((get(&mut instance, "i.y") - 2.0).abs() < 1e-12);
    assert_eq!(get(&mut instance, "g.y"), 7.0);
}

#[test]
fn initial_values_come_to_rest_whenever_they_are_read() {
    let chain = Ssd::new().add("b", Gain).add("a", Gain).connect("a.y", "b.u");
    let exported = export(&chain.write(), &[]);
    let mut instance = exported.instance();
    instance.enter_initialization(super::seconds(0.0), super::seconds(1.0)).unwrap();
    for value in [3.0, -4.0] {
        set(&mut instance, "a.u", value);
        assert_eq!(get(&mut instance, "b.y"), value);
    }
    instance.exit_initialization().unwrap();
    assert_eq!(get(&mut instance, "b.y"), -4.0);
}
