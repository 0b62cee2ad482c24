//! The cost of the master: nanoseconds per FMU-step in chains of small FMUs, compared with a plain
//! C loop over the same library and, if COSIM_BENCH_PYTHON names an interpreter with libcosimpy and
//! fmpy, with libcosim and a loop over FMPy's instances.
//!
//! `cargo bench -p cosim --bench chain`, `cargo xtask bench --third-party`. Processor time; all are
//! measured alternately, several times, and medians are shown: a disturbance affects all of them.
#![allow(unsafe_code, reason = "time of the processor, settings of the allocator")]

#[path = "../tests/element/mod.rs"]
mod element;

use std::path::{Path, PathBuf};
use std::process::Command;

use cosim::observe::{CsvRecorder, RunInfo};
use cosim::{Algorithm, Observer, Overrides, Recording, Result, System, Time};

const LENGTHS: [usize; 4] = [2, 10, 50, 500];
/// FMU-steps of one measurement.
const WORK: usize = 1_000_000;
/// With recorded outputs, which are kept in memory or written.
const RECORDED_WORK: usize = 200_000;
/// In Python.
const PYTHON_WORK: usize = 20_000;
const REPETITIONS: usize = 5;
const STEP: f64 = 1e-3;
/// Column, and the maximum cost as a multiple of the plain loop; for the other tools the minimum,
/// as a multiple of `gauss-seidel`.
const COLUMNS: [(&str, Option<f64>); 7] = [
    ("plain C", None),
    ("gauss-seidel", Some(2.0)),
    ("jacobi", Some(2.0)),
    ("recorded", Some(3.0)),
    ("CSV", None),
    ("libcosim", Some(10.0)),
    ("FMPy loop", Some(30.0)),
];

fn main() {
    // Otherwise it depends on what happens to be last in the heap whether the memory of a recording
    // is new in each repetition, and its pages cost as much as the recording.
    // SAFETY: nothing else runs, and these only change how memory is returned to the system.
    unsafe {
        libc::mallopt(libc::M_TRIM_THRESHOLD, i32::MAX);
        libc::mallopt(libc::M_MMAP_THRESHOLD, i32::MAX);
    }
    let bench = Bench::new();
    println!("ns per FMU-step; recorded: with every y kept in memory; CSV: written to a file");
    println!(
        "{}",
        COLUMNS.iter().fold(format!("{:>6}", "FMUs"), |t, c| t + &format!("{:>14}", c.0))
    );
    let mut ours = Vec::new();
    for length in LENGTHS {
        let medians = bench.medians(length);
        let line =
            medians.iter().map(|m| m.map_or(format!("{:>14}", "-"), |m| format!("{m:>14.1}")));
        println!("{length:>6}{}", line.collect::<String>());
        let (Some(plain), Some(own)) = (medians[0], medians[1]) else { continue };
        ours.push(own);
        for ((name, goal), value) in COLUMNS.iter().zip(&medians) {
            if let (Some(goal), Some(value)) = (goal, value) {
                let (ratio, bar) = match *goal >= 10.0 {
                    true => (value / own, "at least"),
                    false => (value / plain, "at most"),
                };
                println!("{:>6}{name:>14}: {ratio:5.1} x ({bar} {goal})", "");
            }
        }
    }
    println!("from 10 to 500 FMUs: {:.2} x (at most 1.2: flat)", ours[3] / ours[1]);
    for (length, own) in LENGTHS.into_iter().zip(&ours) {
        let guard = bench.guard(length);
        let share = 100.0 * guard / own;
        println!(
            "the guard in a chain of {length}: {guard:.2} ns, {share:.0} % of a step (at most 2)"
        );
    }
}

struct Bench {
    folder: tempfile::TempDir,
    fmu: PathBuf,
    library: PathBuf,
    plain: PathBuf,
    guarded: PathBuf,
    python: Option<PathBuf>,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::TempDir::new().unwrap();
        let fmu = element::fmu(folder.path());
        let plain = compiled(folder.path(), "plain", &[]);
        let guarded = compiled(folder.path(), "guarded", &["-DGUARD"]);
        let library = folder.path().join("element.so");
        unpack(folder.path(), &library);
        let python = std::env::var_os("COSIM_BENCH_PYTHON").map(PathBuf::from);
        Self { folder, fmu, library, plain, guarded, python }
    }

    /// For each column, in order.
    fn medians(&self, length: usize) -> [Option<f64>; 7] {
        let mut samples: [Vec<f64>; 7] = Default::default();
        for _ in 0..REPETITIONS {
            let python = self.python(length);
            let measured = [
                Some(self.plain_c_loop(length)),
                Some(self.master(length, Algorithm::GaussSeidel, WORK, None)),
                Some(self.master(length, Algorithm::Jacobi, WORK, None)),
                Some(self.master(
                    length,
                    Algorithm::GaussSeidel,
                    RECORDED_WORK,
                    Some(&mut Recording::new()),
                )),
                Some(self.to_csv(length)),
                python.map(|(libcosim, _)| libcosim),
                python.map(|(_, fmpy)| fmpy),
            ];
            for (samples, value) in samples.iter_mut().zip(measured) {
                samples.extend(value);
            }
        }
        samples.map(|mut samples| {
            samples.sort_by(f64::total_cmp);
            samples.get(samples.len() / 2).copied()
        })
    }

    fn plain_c_loop(&self, length: usize) -> f64 {
        self.c_loop(&self.plain, length)
    }

    /// What the plain loop costs more (ns) if it checks that an FMU left the floating-point
    /// environment unchanged: the median of alternate runs.
    fn guard(&self, length: usize) -> f64 {
        let more = |_| self.c_loop(&self.guarded, length) - self.c_loop(&self.plain, length);
        let mut more: Vec<f64> = (0..4 * REPETITIONS + 1).map(more).collect();
        more.sort_by(f64::total_cmp);
        more[more.len() / 2]
    }

    fn c_loop(&self, program: &Path, length: usize) -> f64 {
        let mut run = Command::new(program);
        run.arg(&self.library).args([length, WORK / length].map(|n| n.to_string()));
        output(&mut run)[0]
    }

    /// Runs the chain; with an observer every y is recorded at every step, without one only the
    /// last y at the end of the run.
    fn master(
        &self,
        length: usize,
        algorithm: Algorithm,
        work: usize,
        observer: Option<&mut dyn Observer>,
    ) -> f64 {
        let stop = (work / length) as f64 * STEP;
        let ssd = element::chain(&self.fmu, length, STEP, stop);
        let overrides = Overrides::new().algorithm(algorithm);
        let overrides = match observer {
            Some(_) => overrides.output_interval(STEP).output_variable("*.y"),
            None => overrides.output_interval(stop).output_variable(format!("g{}.y", length - 1)),
        };
        let system = System::load(&ssd, &overrides).unwrap();
        let mut clock = Clock { begun: None, ended: 0.0, observer };
        let summary = system.run(&mut [&mut clock]).unwrap();
        (clock.ended - clock.begun.unwrap()) / summary.steps as f64
    }

    fn to_csv(&self, length: usize) -> f64 {
        let mut csv = CsvRecorder::create(self.folder.path().join("out.csv")).unwrap();
        self.master(length, Algorithm::GaussSeidel, RECORDED_WORK, Some(&mut csv))
    }

    fn python(&self, length: usize) -> Option<(f64, f64)> {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/chain.py");
        let mut run = Command::new(self.python.as_ref()?);
        run.arg(script).arg(&self.fmu).arg(self.folder.path());
        let found = output(run.args([length, PYTHON_WORK / length].map(|n| n.to_string())));
        Some((found[0], found[1]))
    }
}

/// Nanoseconds computed by this thread, independent of other programs.
fn processor_time() -> f64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the structure lives during the call.
    unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &mut time) };
    time.tv_sec as f64 * 1e9 + time.tv_nsec as f64
}

/// Measures the time from the first sample, when everything is initialized, until the results are
/// complete, and passes everything on.
struct Clock<'a> {
    begun: Option<f64>,
    ended: f64,
    observer: Option<&'a mut dyn Observer>,
}

impl Observer for Clock<'_> {
    fn start(&mut self, info: &RunInfo<'_>) -> Result<()> {
        self.observer.as_mut().map_or(Ok(()), |observer| observer.start(info))
    }

    fn sample(&mut self, time: Time, values: &[f64]) -> Result<()> {
        if self.begun.is_none() {
            self.begun = Some(processor_time());
        }
        self.observer.as_mut().map_or(Ok(()), |observer| observer.sample(time, values))
    }

    fn finish(&mut self) -> Result<()> {
        let finished = self.observer.as_mut().map_or(Ok(()), |observer| observer.finish());
        self.ended = processor_time();
        finished
    }
}

/// The reference, compiled with these options.
fn compiled(folder: &Path, name: &str, options: &[&str]) -> PathBuf {
    let program = folder.join(name);
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/chain.c");
    let mut compiler = Command::new("cc");
    compiler.args(["-O2", "-w", "-o"]).arg(&program).args(options).arg(source).arg("-ldl");
    assert!(compiler.status().expect("a C compiler named cc").success());
    program
}

/// Unpacks the FMU in the layout that FMPy expects.
fn unpack(folder: &Path, library: &Path) {
    let description = include_str!("../tests/element/element.xml");
    std::fs::write(folder.join("modelDescription.xml"), description).unwrap();
    std::fs::create_dir_all(folder.join("binaries/linux64")).unwrap();
    std::fs::copy(library, folder.join("binaries/linux64/element.so")).unwrap();
}

/// The numbers that a program prints.
fn output(command: &mut Command) -> Vec<f64> {
    let run = command.output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let text = String::from_utf8_lossy(&run.stdout);
    text.split_whitespace().filter_map(|word| word.parse().ok()).collect()
}
