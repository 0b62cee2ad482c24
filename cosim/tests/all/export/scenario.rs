//! Faults that were exported with a system.

use cosim::fmi::{Instance, Place};
use cosim::scenario::Scenario;
use cosim::{Overrides, Recording, Run};

use super::{Exported, assert_same, command, export, get, seconds, set, step};
use crate::formats::Folder;
use crate::models::Model::{Clock, Gain, Integrator};
use crate::ssd::Ssd;

/// On an output, connected inputs and a free one; random, with memory, a reset.
const FAULTS: &str = r#"
seed = 5
[[fault]]
kind = "gauss-markov"
on = "g.y"
sigma = 0.1
tau = 0.3
from = 0.2
[[fault]]
kind = "latency"
on = "x.u"
delay = 0.2
jitter = 0.1
[[fault]]
kind = "scale"
on = "g.u"
factor = 2
between = [0.5, 0.9]
for = 0.4
[[fault]]
kind = "bias"
on = "free.u"
value = 3
from = 0.4
[[fault]]
kind = "reset"
on = "x"
from = 1.0
"#;

fn chain() -> Ssd {
    Ssd::new()
        .add("clock", Clock)
        .add("g", Gain)
        .add("x", Integrator)
        .add("free", Gain)
        .connect("clock.y", "g.u")
        .connect("g.y", "x.u")
        .stop(1.5)
}

/// Exports the chain with the faults.
fn exported(folder: &Folder) -> Exported {
    let file = folder.write("faults.toml", FAULTS);
    export(&chain().write(), &["--scenario", file.to_str().unwrap()])
}

#[test]
fn faults_act_in_an_exported_system_as_in_its_run_at_every_communication_step() {
    let folder = Folder::new();
    let exported = exported(&folder);
    let mut scenario = Scenario::read(folder.write("faults.toml", FAULTS)).unwrap();
    let system = chain().load(&Overrides::new()).unwrap();
    let (mut wanted, mut sound) = (Recording::new(), Recording::new());
    Run::new(&system).observe(&mut wanted).manipulate(&mut scenario).go().unwrap();
    system.run(&mut [&mut sound]).unwrap();
    assert_ne!(wanted.column("x.y").unwrap(), sound.column("x.y").unwrap());
    for length in [0.1, 0.3, 0.5] {
        assert_same(&exported.run(length, Overrides::new().stop_time(1.5)), &wanted);
    }
}

const NAMES: [&str; 3] = ["g.y", "x.y", "free.y"];

fn on(instance: &mut Instance, from: u32, to: u32) -> [u64; 3] {
    (from..to).for_each(|k| step(instance, f64::from(k) * 0.05, f64::from(k + 1) * 0.05));
    NAMES.map(|name| get(instance, name).to_bits())
}

#[test]
fn faults_are_part_of_the_state_and_begin_anew_with_the_system() {
    let folder = Folder::new();
    let exported = exported(&folder);
    let mut first = exported.started();
    let half = on(&mut first, 0, 13);
    first.save(Place::Snapshot).unwrap();
    let bytes = first.serialize().unwrap();
    let end = on(&mut first, 13, 30);
    first.restore(Place::Snapshot, seconds(0.65)).unwrap();
    assert_eq!(NAMES.map(|name| get(&mut first, name).to_bits()), half);
    assert_eq!(on(&mut first, 13, 30), end);
    let mut second = exported.started();
    second.deserialize(&bytes, seconds(0.65)).unwrap();
    assert_eq!(on(&mut second, 13, 30), end);
    // Back to a time before any fault.
    let mut third = exported.started();
    third.save(Place::Snapshot).unwrap();
    assert_eq!(on(&mut third, 0, 30), end);
    third.restore(Place::Snapshot, seconds(0.0)).unwrap();
    assert_eq!(on(&mut third, 0, 30), end);
}

#[test]
fn a_fault_acts_on_what_the_importer_sets() {
    let folder = Folder::new();
    let exported = exported(&folder);
    let mut instance = exported.started();
    set(&mut instance, "free.u", 1.0);
    on(&mut instance, 0, 8);
    assert_eq!(get(&mut instance, "free.y"), 1.0);
    on(&mut instance, 8, 10);
    assert_eq!(get(&mut instance, "free.y"), 4.0);
    set(&mut instance, "free.u", 2.0);
    on(&mut instance, 10, 12);
    assert_eq!(get(&mut instance, "free.y"), 5.0);
}

#[test]
fn what_needs_a_run_of_ours_is_refused() {
    let folder = Folder::new();
    for (text, part) in [
        ("[[fault]]\nkind = \"zero\"\non = \"g.y\"\nwhen = \"x.y > 1\"\n", "waits for a condition"),
        ("end = 1\n[[fault]]\nkind = \"zero\"\non = \"g.y\"\n", "an end cannot be exported"),
        ("[[fault]]\nkind = \"zero\"\non = \"g.z\"\n", "'g' has no variable 'z'"),
    ] {
        let file = folder.write("wrong.toml", text);
        let into = tempfile::TempDir::new().unwrap();
        let (code, said) =
            command(into.path(), &chain().write(), &["--scenario", file.to_str().unwrap()]);
        assert!(code != 0 && said.contains(part), "{part}: {said}");
    }
}
