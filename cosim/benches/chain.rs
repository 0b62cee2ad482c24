//! What the master costs: nanoseconds per FMU-step in a chain of ten, against a plain C loop.
//!
//! `cargo bench -p cosim`; prints one line. The difference of the two is the routing, the
//! scheduling and the state checks.

#[path = "../tests/all/models.rs"]
#[allow(dead_code, reason = "the tests need more of it")]
mod models;
#[path = "../tests/all/ssd.rs"]
#[allow(dead_code, reason = "the tests need more of it")]
mod ssd;

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use cosim::{Algorithm, Overrides};
use models::Model;

const LENGTH: usize = 10;
const STEPS: u32 = 300_000;
const REPETITIONS: usize = 5;

fn main() {
    let plain = best(plain_c_loop());
    let fresh = best(|| master(Algorithm::GaussSeidel));
    let held = best(|| master(Algorithm::Jacobi));
    println!(
        "chain of {LENGTH}, ns per FMU-step: plain C loop {plain:.1}, gauss-seidel {fresh:.1} \
         (+{:.1}), jacobi {held:.1} (+{:.1})",
        fresh - plain,
        held - plain
    );
}

/// The least of some repetitions: the others were disturbed.
fn best(mut measure: impl FnMut() -> f64) -> f64 {
    (0..REPETITIONS).map(|_| measure()).fold(f64::INFINITY, f64::min)
}

fn plain_c_loop() -> impl FnMut() -> f64 {
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("chain");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/chain.c");
    let library = models::compile(Model::Gain);
    let mut compiler = Command::new("cc");
    compiler.args(["-O2", "-w", "-o"]).arg(&program).arg(source).arg("-ldl");
    assert!(compiler.status().expect("a C compiler named cc").success());
    move || {
        let run = Command::new(&program).arg(&library).arg(STEPS.to_string()).output().unwrap();
        String::from_utf8_lossy(&run.stdout).trim().parse().unwrap()
    }
}

fn master(algorithm: Algorithm) -> f64 {
    let mut system = ssd::Ssd::new();
    for position in 0..LENGTH {
        system = system.add_with(&format!("g{position}"), Model::Gain, &[], Some(1e-3));
    }
    for position in 1..LENGTH {
        system = system.connect(&format!("g{}.y", position - 1), &format!("g{position}.u"));
    }
    // The chain ends in a recorded output, once per run, so that all ten are read.
    let stop = f64::from(STEPS) * 1e-3;
    let last = format!("g{}.y", LENGTH - 1);
    let overrides =
        Overrides::new().algorithm(algorithm).output_interval(stop).output_variable(last);
    let system = system.stop(stop).load(&overrides).unwrap();
    let begun = Instant::now();
    let summary = system.run(&mut []).unwrap();
    begun.elapsed().as_nanos() as f64 / summary.steps as f64
}
