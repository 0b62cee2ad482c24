//! Many runs leave nothing behind. In a process of its own, because the other tests open files and
//! use memory meanwhile.

use std::process::Command;

use cosim::{Overrides, Recording, System};

use crate::models::Model;
use crate::ssd::Ssd;

fn open_files() -> usize {
    std::fs::read_dir("/proc/self/fd").unwrap().count()
}

/// Memory in use, in bytes.
fn resident() -> usize {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap();
    4096 * pages.split(' ').nth(1).unwrap().parse::<usize>().unwrap()
}

fn is_flat(rounds: usize, mut run: impl FnMut()) {
    (0..rounds / 10).for_each(|_| run());
    let before = (open_files(), resident());
    (0..rounds).for_each(|_| run());
    let after = (open_files(), resident());
    assert_eq!(after.0, before.0);
    let grown = after.1.saturating_sub(before.1);
    assert!(grown < 1 << 20, "{grown} bytes in {rounds} runs");
}

#[test]
#[ignore = "the next test runs it in a process of its own"]
fn alone() {
    let ssd = Ssd::new().add("a", Model::Gain).add("b", Model::Integrator).connect("a.y", "b.u");
    let system = ssd.load(&Overrides::new()).unwrap();
    is_flat(10_000, || {
        system.run(&mut [&mut Recording::new()]).unwrap();
    });
    // Unpacked, mapped and unmapped each time; and one that fails.
    let (fine, failing) = (Model::Clock.fmu(), Model::Failing.fmu());
    is_flat(300, || {
        let load = |fmu| System::single(fmu, &Overrides::new().start_value("second", 0.5), None);
        load(&fine).unwrap().run(&mut []).unwrap();
        load(&failing).unwrap().run(&mut []).unwrap_err();
    });
}

#[test]
fn ten_thousand_runs_take_no_memory_and_no_file() {
    let mut command = Command::new(std::env::current_exe().unwrap());
    let output = command.args(["--exact", "failures::alone", "--ignored"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
}
