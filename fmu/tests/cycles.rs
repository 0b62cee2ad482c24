//! Instances leave nothing behind: no memory, no file, no thread.
#![allow(unsafe_code, reason = "calls of the C interface as an importer makes them")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each is a call of the C interface as an importer makes it"
)]
#![allow(unreachable_pub, reason = "shared with the other tests")]
#![cfg(target_os = "linux")]

#[path = "fmi2/components.rs"]
mod components;
#[expect(dead_code, reason = "shared with the other tests")]
#[path = "fmi2/driver.rs"]
mod driver;
#[path = "fmi2/hybrid.rs"]
mod hybrid;

use std::ptr::null_mut;

use components::fmi2;
use driver::{CS, Fmu};
use fmu_kit::kernel::Status;

/// Pages in memory, open files, threads.
fn footprint() -> [usize; 3] {
    let statm = std::fs::read_to_string("/proc/self/statm").unwrap();
    let resident = statm.split(' ').nth(1).unwrap().parse().unwrap();
    let count = |folder| std::fs::read_dir(folder).unwrap().count();
    [resident, count("/proc/self/fd"), count("/proc/self/task")]
}

fn life(name: &'static str) {
    let mut fmu = Fmu::started(name, CS);
    let mut state = null_mut();
    assert_eq!(unsafe { fmi2::fmi2GetFMUstate(fmu.c, &raw mut state) }, Status::Ok);
    assert_eq!(fmu.step(0.0, 0.2), Status::Ok);
}

#[test]
fn ten_thousand_lives_and_resets_leave_nothing() {
    let lives = || {
        for _ in 0..2500 {
            ["Spring", "Noise", "Ball", "Pendulum"].into_iter().for_each(life);
        }
    };
    lives();
    let before = footprint();
    lives();
    let mut fmu = Fmu::new("Spring", CS);
    for _ in 0..10_000 {
        assert_eq!((fmu.setup(0.0), fmu.initialize()), (Status::Ok, Status::Ok));
        assert_eq!(fmu.step(0.0, 0.1), Status::Ok);
        assert_eq!(unsafe { fmi2::fmi2Reset(fmu.c) }, Status::Ok);
    }
    let after = footprint();
    // A few pages may come and go with the allocator.
    assert!(after[0] <= before[0] + 16, "{before:?} {after:?}");
    assert_eq!(after[1..], before[1..]);
}
