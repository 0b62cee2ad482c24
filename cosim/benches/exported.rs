//! The cost of a system exported as one FMU: nanoseconds per inner FMU-step in chains of small
//! FMUs, stepped through `fmi2DoStep` of the whole; and, if COSIM_BENCH_PYTHON names an interpreter
//! with fmu-manipulation-toolbox, the same for its container of the same FMUs.
//!
//! `cargo bench -p cosim --bench exported`, `cargo xtask bench --third-party`. Processor time; both
//! are measured alternately, several times, and medians are shown: a disturbance affects both.
#![allow(unsafe_code, reason = "time of the processor")]

#[path = "../tests/element/mod.rs"]
mod element;

use std::path::{Path, PathBuf};
use std::process::Command;

use cosim::export::Export;
use cosim::fmi::{Fmu, Instance, Logging};
use cosim::{Overrides, System, Time};

const LENGTHS: [usize; 4] = [2, 10, 50, 200];
/// FMU-steps of one measurement.
const WORK: usize = 400_000;
const REPETITIONS: usize = 7;
const STEP: f64 = 1e-3;

fn main() {
    let folder = tempfile::TempDir::new().unwrap();
    let fmu = element::fmu(folder.path());
    let python = std::env::var_os("COSIM_BENCH_PYTHON").map(PathBuf::from);
    println!("ns per inner FMU-step of a chain as one FMU");
    println!("{:>6}{:>14}{:>14}{:>10}", "FMUs", "cosim export", "container", "ratio");
    let mut ours = Vec::new();
    for length in LENGTHS {
        let exported = exported(&fmu, length);
        let other = python.as_deref().map(|python| container(python, &fmu, length));
        let (mut own, mut others) = (Vec::new(), Vec::new());
        for _ in 0..REPETITIONS {
            own.push(measure(&exported, &format!("g{}.y", length - 1), length));
            others.extend(other.as_ref().map(|fmu| measure(fmu, "y", length)));
        }
        let (own, other) = (median(own), (!others.is_empty()).then(|| median(others)));
        let shown = |value: Option<f64>| value.map_or("-".to_owned(), |v| format!("{v:.1}"));
        let ratio = other.map_or("-".to_owned(), |other| format!("{:.2}", own / other));
        println!("{length:>6}{own:>14.1}{:>14}{ratio:>10}", shown(other));
        ours.push(own);
    }
    println!("ratio: at most 1");
    println!("from 10 to 200 FMUs: {:.2} x (at most 1.2: flat)", ours[3] / ours[1]);
}

/// The chain as one FMU.
fn exported(fmu: &Path, length: usize) -> PathBuf {
    let system = System::load(element::chain(fmu, length, STEP, 1.0), &Overrides::new()).unwrap();
    let library = std::env::current_exe().unwrap().with_file_name("libcosim_system.so");
    let file = fmu.with_file_name(format!("exported-{length}.fmu"));
    Export::new().library(library).write(&system, &file).unwrap();
    file
}

/// The same by the reference tool, which identifies FMUs by their files: each gets its own.
fn container(python: &Path, fmu: &Path, length: usize) -> PathBuf {
    let folder = fmu.with_file_name(format!("container-{length}"));
    std::fs::create_dir_all(&folder).unwrap();
    for position in 0..length {
        std::fs::copy(fmu, folder.join(format!("g{position}.fmu"))).unwrap();
    }
    let names: Vec<String> = (0..length).map(|k| format!("\"g{k}.fmu\"")).collect();
    let links = (1..length).map(|k| format!("[\"g{}.fmu\", \"y\", \"g{k}.fmu\", \"u\"]", k - 1));
    let links: Vec<String> = links.collect();
    let last = length - 1;
    let text = format!(
        "{{\"name\": \"chain.fmu\", \"step_size\": {STEP}, \"auto_link\": false, \
         \"auto_input\": false, \"auto_output\": false, \"fmu\": [{}], \"link\": [{}], \
         \"start\": [[\"g0.fmu\", \"b\", 1.0]], \"output\": [[\"g{last}.fmu\", \"y\", \"y\"]]}}",
        names.join(", "),
        links.join(", ")
    );
    std::fs::write(folder.join("chain.json"), text).unwrap();
    let mut tool = Command::new(python.with_file_name("fmucontainer"));
    tool.arg("-fmu-directory").arg(&folder).args(["-container", "chain.json"]);
    let done = tool.output().unwrap();
    let made = folder.join("chain.fmu");
    assert!(made.is_file(), "{}", String::from_utf8_lossy(&done.stderr));
    made
}

/// Steps one FMU and reads its last output after each step.
fn measure(fmu: &Path, output: &str, length: usize) -> f64 {
    let fmu = Fmu::open(fmu).unwrap();
    let reference = fmu.description().variable(output).unwrap().value_reference;
    let mut instance = Instance::new(fmu, "chain", &Logging::default()).unwrap();
    let steps = WORK / length;
    let stop = Time::from_seconds((steps + 1) as f64 * STEP);
    let step = Time::from_seconds(STEP);
    instance.enter_initialization(Time::ZERO, stop).unwrap();
    instance.exit_initialization().unwrap();
    let (mut now, mut value) = (Time::ZERO, [0.0]);
    let begun = processor_time();
    for _ in 0..steps {
        instance.do_step(now, step).unwrap();
        instance.get_real(&[reference], &mut value).unwrap();
        now = now + step;
    }
    let passed = processor_time() - begun;
    assert!(value[0] != 0.0, "the chain carries nothing");
    passed / (steps * length) as f64
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Nanoseconds computed by this thread, independent of other programs.
fn processor_time() -> f64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the structure lives during the call.
    unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &mut time) };
    time.tv_sec as f64 * 1e9 + time.tv_nsec as f64
}
