//! An exported system that is loaded, run and unloaded repeatedly leaves nothing behind, and
//! returns from steps that no simulation makes.
#![allow(unsafe_code, reason = "calls of the C interface as an importer makes them")]

use std::path::PathBuf;
use std::process::Command;

use cosim::fmi::{Fmu, Instance, Logging};

use super::{export, seconds, step};
use crate::command::text;
use crate::models::Model::{Gain, Integrator};
use crate::ssd::Ssd;

/// Number of lifecycles, and what each may leave (bytes): the dynamic linker keeps the paths of the
/// libraries, here of three in folders that are new each time, and some of its lists grow.
const CYCLES: usize = 60;
const LEFT: usize = 2048;
/// Names the FMU to the child process.
const VARIABLE: &str = "COSIM_TEST_LIFECYCLES_OF";

/// `struct mallinfo2` of glibc: ten numbers, of which the eighth is what is allocated.
#[repr(C)]
struct Allocated {
    before: [usize; 7],
    bytes: usize,
    after: [usize; 2],
}

unsafe extern "C" {
    fn mallinfo2() -> Allocated;
}

/// What this process has allocated (bytes).
pub(crate) fn allocated() -> usize {
    // SAFETY: it only counts.
    unsafe { mallinfo2() }.bytes
}

fn system() -> Ssd {
    let loop_ = Ssd::new().add("i", Integrator).add("g", Gain);
    loop_.connect("i.y", "g.u").connect("g.y", "i.u")
}

#[test]
fn lifecycles_of_an_exported_system_leave_nothing() {
    let exported = export(&system().write(), &[]);
    let this = std::env::current_exe().unwrap();
    let output = Command::new(this)
        .args(["--exact", "export::lifecycles::lifecycles", "--ignored", "--nocapture"])
        .env(VARIABLE, &exported.fmu)
        .output()
        .unwrap();
    let (reported, why) = (text(&output.stdout), text(&output.stderr));
    assert!(output.status.success() && reported.contains("1 passed"), "{reported}{why}");
}

#[test]
#[ignore = "counts the memory of its process: the test above starts it in one of its own"]
fn lifecycles() {
    let Some(fmu) = std::env::var_os(VARIABLE).map(PathBuf::from) else { return };
    let lifecycle = || {
        let fmu = Fmu::open(&fmu).unwrap();
        let mut instance = Instance::new(fmu, "loop", &Logging::default()).unwrap();
        instance.enter_initialization(seconds(0.0), seconds(10.0)).unwrap();
        instance.exit_initialization().unwrap();
        step(&mut instance, 0.0, 1.0);
    };
    // The first ones also fill the lists of the dynamic linker.
    (0..CYCLES).for_each(|_| lifecycle());
    let before = allocated();
    (0..CYCLES).for_each(|_| lifecycle());
    let left = allocated().saturating_sub(before);
    assert!(left <= LEFT * CYCLES, "{left} bytes are left of {CYCLES} lifecycles");
}

#[test]
fn a_step_of_too_many_steps_is_refused() {
    let exported = export(&system().write(), &[]);
    let mut instance = exported.instance();
    instance.enter_initialization(seconds(0.0), seconds(9e8)).unwrap();
    instance.exit_initialization().unwrap();
    let error = instance.do_step(seconds(0.0), seconds(8e8)).unwrap_err().to_string();
    assert!(error.contains("1000000") && error.contains("shorter communication steps"), "{error}");
}
