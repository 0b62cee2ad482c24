//! What a worker computes has the same bits as when computed here.

use cosim::fmi::Place;
use cosim::{Overrides, System, Time};

use super::{Made, get, here, programs, reference, seconds, set, step, steps, until};
use crate::command::text;
use crate::distributed::cosim;
use crate::locked::free_port;
use crate::models::Model::{Affine, Counter, Failing, Integrator, Mass, Picky};
use crate::ssd::{Ssd, run};

#[test]
fn a_remote_instance_has_the_bits_of_a_local_one() {
    for model in [Integrator, Affine, Mass] {
        let made = Made::of(model, &[]);
        let _worker = made.worker("left");
        let values = [("k", 0.7), ("second", 0.3)];
        let (mut there, mut local) = (made.started(&values), here(model, &values));
        assert_eq!(steps(&mut there, 0..120), steps(&mut local, 0..120), "{}", model.name());
        let names = ["u", "k", "second"];
        assert_eq!(names.map(|n| get(&mut there, n)), names.map(|n| get(&mut local, n)));
    }
}

#[test]
fn every_type_passes_both_ways() {
    let made = Made::of(Counter, &[]);
    let _worker = made.worker("left");
    let mut it = made.make().unwrap();
    let text = reference(&it, "text")[0];
    it.set_string(text, "a \u{df}").unwrap();
    it.set_integer(&reference(&it, "m"), &[40]).unwrap();
    it.set_boolean(&reference(&it, "odd"), &[1]).unwrap();
    super::initialize(&mut it, &[]);
    for k in 0..2 {
        it.do_step(seconds(f64::from(k) * 0.1), seconds(0.1)).unwrap();
        let (mut n, mut even) = ([0], [9]);
        it.get_integer(&reference(&it, "n"), &mut n).unwrap();
        it.get_boolean(&reference(&it, "even"), &mut even).unwrap();
        assert_eq!((n, even), ([41 + k], [0]));
    }
    assert_eq!(it.get_string(text).unwrap(), "a \u{df}");
}

#[test]
fn an_input_that_is_read_back_is_the_one_that_was_set() {
    let made = Made::of(Affine, &[]);
    let _worker = made.worker("left");
    let (mut there, mut local) = (made.started(&[]), here(Affine, &[]));
    for it in [&mut there, &mut local] {
        step(it, 0).unwrap();
        set(it, "u", 5.0);
    }
    assert_eq!(["u", "y"].map(|n| get(&mut there, n)), ["u", "y"].map(|n| get(&mut local, n)));
}

#[test]
fn states_go_on_here_and_in_another_instance() {
    let made = Made::of(Integrator, &[]);
    let _worker = made.worker("left");
    let mut first = made.started(&[("second", 2.0)]);
    steps(&mut first, 0..7);
    first.save(Place::Snapshot).unwrap();
    let bytes = first.serialize().unwrap();
    let wanted = steps(&mut first, 7..20);
    first.restore(Place::Snapshot, seconds(0.7)).unwrap();
    assert_eq!(steps(&mut first, 7..20), wanted);
    drop(first);
    let mut second = made.started(&[]);
    second.deserialize(&bytes, seconds(0.7)).unwrap();
    assert_eq!(steps(&mut second, 7..20), wanted);
}

#[test]
fn a_discarded_step_is_made_again_and_an_error_is_the_instances_own() {
    let made = Made::of(Picky, &[]);
    let _worker = made.worker("left");
    let mut picky = made.started(&[("second", 0.05)]);
    picky.save(Place::Retry).unwrap();
    assert!(picky.try_step(Time::ZERO, seconds(0.1)).unwrap() < seconds(0.1));
    picky.restore(Place::Retry, Time::ZERO).unwrap();
    assert_eq!(picky.try_step(Time::ZERO, seconds(0.05)).unwrap(), seconds(0.05));
    drop(picky);

    let made = Made::of(Failing, &[]);
    let _worker = made.worker("left");
    let mut failing = made.started(&[("second", 0.15)]);
    step(&mut failing, 0).unwrap();
    let error = step(&mut failing, 1).unwrap_err();
    assert_eq!(error.status(), Some(3), "{error}");
    let said = made.said();
    let line = said.iter().filter(|line| line.starts_with("fmi2DoStep: ")).count();
    assert_eq!(line, 1, "{said:?}");
}

#[test]
fn two_instances_live_side_by_side_and_leave_nothing() {
    let ports = [free_port(), free_port()].map(|port| format!("tcp/127.0.0.1:{port}"));
    let folder = tempfile::TempDir::new().unwrap();
    let made = Made::at(folder, ports.join(", "), Integrator, &[]);
    let _worker = made.worker("left");
    let before = programs().len();
    let (mut one, mut other) = (made.started(&[]), made.started(&[("second", 1.0)]));
    let (found, shifted) = (steps(&mut one, 0..10), steps(&mut other, 0..10));
    let wanted = steps(&mut here(Integrator, &[]), 0..10);
    assert_eq!(found, wanted);
    assert_ne!(shifted, wanted);
    drop((one, other));
    until("programs are left", || programs().len() <= before);
}

#[test]
fn a_system_with_a_remote_component_has_the_same_results() {
    let made = Made::of(Integrator, &[]);
    let _worker = made.worker("left");
    let system = Ssd::new()
        .add("clock", crate::models::Model::Clock)
        .add("x", Integrator)
        .connect("clock.y", "x.u")
        .stop(20.0);
    let wanted = system.run();
    let overrides = Overrides::new().replace("x", &made.fmu).execution_tools(true);
    let found = run(&System::load(system.write(), &overrides).unwrap());
    for (name, values) in wanted.columns() {
        let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(found.column(name).unwrap()), bits(values), "{name}");
    }
}

#[test]
fn the_environment_goes_before_the_file() {
    let made = Made::of(Integrator, &["--wait", "0.1"]);
    let other = format!("tcp/127.0.0.1:{}", free_port());
    let fmu = made.fmu.to_str().unwrap();
    let arguments = ["simulate", fmu, "--execution-tool", "--output-file", "x.csv", "-q"];
    let mut command = cosim(made.folder.path(), &arguments);
    command.env("COSIM_REMOTE_LISTEN", &other).env("COSIM_REMOTE_WAIT", "20");
    let own = ["worker", "--name", "left", "--connect", &other, "--allow-upload"];
    let _worker = crate::locked::start(made.folder.path(), &own);
    let done = command.output().unwrap();
    assert!(done.status.success(), "{}", text(&done.stderr));
    let mut command = cosim(made.folder.path(), &arguments);
    let done = command.env("COSIM_REMOTE_WAIT", "soon").output().unwrap();
    assert!(text(&done.stderr).contains("COSIM_REMOTE_WAIT is 'soon'"), "{}", text(&done.stderr));
}
