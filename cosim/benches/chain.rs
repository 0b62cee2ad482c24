//! What the master costs: nanoseconds per FMU-step in chains of small FMUs, against a plain C
//! loop over the same FMUs, and what a whole process costs.
//!
//! `cargo bench -p cosim`. Processor time; each line is the median of repetitions that take turns
//! with those of the yardstick, so that a disturbance hits both, and the ratio is the median of
//! those of neighbours. "recorded": every output into memory at every step.

#[path = "../tests/all/models.rs"]
#[allow(dead_code, reason = "the tests need more of it")]
mod models;
#[path = "../tests/all/ssd.rs"]
#[allow(dead_code, reason = "the tests need more of it")]
mod ssd;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use cosim::{Algorithm, Overrides, Recording, System};
use models::Model;

const LENGTHS: [usize; 4] = [2, 10, 50, 500];
/// FMU-steps of one repetition.
const STEPS: usize = 1_000_000;
const REPETITIONS: usize = 9;

fn main() {
    let yardstick = compile();
    println!("ns per FMU-step        C   gauss-seidel     jacobi   recorded");
    for length in LENGTHS {
        chain(&yardstick, length);
    }
    process();
}

fn chain(yardstick: &Path, length: usize) {
    let steps = STEPS / length;
    let [fresh, held] =
        [Algorithm::GaussSeidel, Algorithm::Jacobi].map(|a| system(a, length, steps, false));
    let recorded = system(Algorithm::GaussSeidel, length, steps, true);
    let mut rows: Vec<[f64; 4]> = Vec::new();
    for _ in 0..REPETITIONS {
        rows.push([
            c_loop(yardstick, length, steps),
            run(&fresh, false),
            run(&held, false),
            run(&recorded, true),
        ]);
    }
    let column = |k: usize| median(rows.iter().map(|row| row[k]).collect());
    let ratio = |k: usize| median(rows.iter().map(|row| row[k] / row[0]).collect());
    let shown: Vec<String> =
        (1..4).map(|k| format!("{:5.1} ({:.2}x)", column(k), ratio(k))).collect();
    println!("chain of {length:4}     {:5.1}  {}", column(0), shown.join("  "));
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn compile() -> PathBuf {
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("chain");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/chain.c");
    let mut compiler = Command::new("cc");
    compiler.args(["-O2", "-w", "-o"]).arg(&program).arg(source).arg("-ldl");
    assert!(compiler.status().expect("a C compiler named cc").success());
    program
}

fn c_loop(program: &Path, length: usize, steps: usize) -> f64 {
    let mut command = Command::new(program);
    command.arg(models::compile(Model::Gain)).args([length.to_string(), steps.to_string()]);
    String::from_utf8_lossy(&command.output().unwrap().stdout).trim().parse().unwrap()
}

fn system(algorithm: Algorithm, length: usize, steps: usize, recorded: bool) -> System {
    let mut system = ssd::Ssd::new();
    for position in 0..length {
        system = system.add_with(&format!("g{position}"), Model::Gain, &[], Some(1e-3));
    }
    for position in 1..length {
        system = system.connect(&format!("g{}.y", position - 1), &format!("g{position}.u"));
    }
    let stop = steps as f64 * 1e-3;
    let overrides = Overrides::new().algorithm(algorithm);
    let overrides = match recorded {
        true => overrides.output_interval(1e-3).output_variable("*.y"),
        // The chain ends in a recorded output, once per run, so that all are read.
        false => overrides.output_interval(stop).output_variable(format!("g{}.y", length - 1)),
    };
    system.stop(stop).load(&overrides).unwrap()
}

fn run(system: &System, recorded: bool) -> f64 {
    let mut recording = Recording::new();
    let begun = processor_time();
    let summary = match recorded {
        true => system.run(&mut [&mut recording]),
        false => system.run(&mut []),
    };
    (processor_time() - begun) / summary.unwrap().steps as f64
}

/// Nanoseconds that this thread has computed: other programs take none of them.
fn processor_time() -> f64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the structure lives during the call.
    unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &mut time) };
    time.tv_sec as f64 * 1e9 + time.tv_nsec as f64
}

/// `cosim simulate` of one FMU, results recorded: wall time and the largest memory.
fn process() {
    let folder = tempfile::TempDir::new().unwrap();
    let runs: Vec<(f64, f64)> = (0..REPETITIONS).map(|_| simulate(folder.path())).collect();
    let time = median(runs.iter().map(|run| run.0).collect());
    let memory = median(runs.iter().map(|run| run.1).collect());
    println!("cosim simulate, a whole process: {time:.1} ms, {memory:.1} MB");
}

/// Milliseconds and megabytes.
#[allow(clippy::zombie_processes, reason = "wait4 waits, and tells the memory")]
fn simulate(folder: &Path) -> (f64, f64) {
    let begun = Instant::now();
    let mut command = Command::new(env!("CARGO_BIN_EXE_cosim"));
    command.arg("simulate").arg(Model::Gain.fmu()).current_dir(folder).stderr(Stdio::null());
    let child = command.spawn().unwrap();
    let mut status = 0;
    // SAFETY: the child is ours and nobody else waits for it; both places live during the call.
    let usage = unsafe {
        let mut usage = std::mem::zeroed::<libc::rusage>();
        libc::wait4(child.id() as i32, &mut status, 0, &mut usage);
        usage
    };
    assert_eq!(status, 0);
    (begun.elapsed().as_secs_f64() * 1e3, usage.ru_maxrss as f64 / 1e3)
}
