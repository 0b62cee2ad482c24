//! FMUs that a worker computes, through the binary, and driven by our own importer.

mod bits;
mod lives;
mod locked;
mod losses;
mod offered;
mod refused;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use cosim::fmi::{Fmu, Instance, Logging, Mailbox};
use cosim::{Error, Time};
use tempfile::TempDir;

use crate::distributed::{children, outcome};
use crate::locked::{Running, free_port, start};
use crate::models::Model;

/// The library of remote FMUs, which Cargo builds with the tests.
fn library() -> PathBuf {
    let program = std::env::current_exe().unwrap();
    let library = program.with_file_name("libcosim_proxy.so");
    assert!(library.is_file(), "{}", library.display());
    library
}

/// A remote FMU in a folder of its own, and the endpoint where workers connect.
struct Made {
    folder: TempDir,
    fmu: PathBuf,
    endpoint: String,
    mailbox: Arc<Mailbox>,
}

/// Exit code and messages of `cosim proxy FMU -o x.remote.fmu` in a folder.
fn proxy(folder: &Path, fmu: &Path, arguments: &[&str]) -> (i32, String) {
    let library = library();
    let own = ["proxy", fmu.to_str().unwrap(), "-o", "x.remote.fmu", "-q", "--library"];
    outcome(folder, &[&own[..], &[library.to_str().unwrap()], arguments].concat())
}

impl Made {
    /// For a model, which waits for workers at a free port.
    fn of(model: Model, arguments: &[&str]) -> Self {
        let endpoint = format!("tcp/127.0.0.1:{}", free_port());
        Self::at(TempDir::new().unwrap(), endpoint, model, arguments)
    }

    #[track_caller]
    fn at(folder: TempDir, endpoint: String, model: Model, arguments: &[&str]) -> Self {
        let arguments = [&["--listen", &endpoint], arguments].concat();
        let (code, stderr) = proxy(folder.path(), &model.fmu(), &arguments);
        assert_eq!(code, 0, "{stderr}");
        let fmu = folder.path().join("x.remote.fmu");
        Self { folder, fmu, endpoint, mailbox: Arc::default() }
    }

    /// A worker that computes the original FMU.
    fn worker(&self, name: &str) -> Running {
        let own = ["worker", "--name", name, "--connect", &self.endpoint, "--allow-upload"];
        start(self.folder.path(), &own)
    }

    fn make(&self) -> Result<Instance, Error> {
        let fmu = Fmu::open(&self.fmu).unwrap();
        let mailbox = Some(self.mailbox.clone());
        Instance::new(fmu, "it", &Logging { mailbox, ..Logging::default() })
    }

    /// An instance that has left initialization, in which some variables were set.
    #[track_caller]
    fn started(&self, values: &[(&str, f64)]) -> Instance {
        let mut instance = self.make().unwrap_or_else(|error| panic!("{error}"));
        initialize(&mut instance, values);
        instance
    }

    /// What the FMU logged.
    fn said(&self) -> Vec<String> {
        self.mailbox.take().into_iter().map(|message| message.text).collect()
    }
}

fn initialize(instance: &mut Instance, values: &[(&str, f64)]) {
    values.iter().for_each(|(name, value)| set(instance, name, *value));
    instance.enter_initialization(Time::ZERO, seconds(1e3)).unwrap();
    instance.exit_initialization().unwrap();
}

/// The instance that a remote one represents.
fn here(model: Model, values: &[(&str, f64)]) -> Instance {
    let mut instance =
        Instance::new(Fmu::open(&model.fmu()).unwrap(), "it", &Logging::default()).unwrap();
    initialize(&mut instance, values);
    instance
}

fn seconds(seconds: f64) -> Time {
    Time::from_seconds(seconds)
}

fn reference(instance: &Instance, name: &str) -> [u32; 1] {
    let description = instance.fmu().description();
    [description.variable(name).unwrap_or_else(|| panic!("no {name}")).value_reference]
}

fn set(instance: &mut Instance, name: &str, value: f64) {
    let reference = reference(instance, name);
    instance.set_real(&reference, &[value]).unwrap();
}

fn get(instance: &mut Instance, name: &str) -> f64 {
    let reference = reference(instance, name);
    let mut value = [f64::NAN];
    instance.get_real(&reference, &mut value).unwrap();
    value[0]
}

/// The step number `k` of 0.1 s, with an input that is not a round number.
fn step(instance: &mut Instance, k: u32) -> Result<f64, Error> {
    set(instance, "u", 1.0 / f64::from(k + 3));
    instance.do_step(seconds(f64::from(k) * 0.1), seconds(0.1))?;
    Ok(get(instance, "y"))
}

/// The bits of an output after each of some steps.
fn steps(instance: &mut Instance, range: std::ops::Range<u32>) -> Vec<u64> {
    range.map(|k| step(instance, k).unwrap_or_else(|error| panic!("{error}")).to_bits()).collect()
}

/// The processes that compute for a worker.
fn groups(worker: &Running) -> Vec<u32> {
    children(worker.0.id())
}

/// Waits until a condition holds.
#[track_caller]
fn until(what: &str, is_so: impl Fn() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < Duration::from_secs(60), "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Programs in remote FMUs that run below this process.
fn programs() -> Vec<u32> {
    let is_one = |process: &u32| {
        std::fs::read(format!("/proc/{process}/cmdline")).is_ok_and(|c| c == b"cosim\0remote\0")
    };
    children(std::process::id()).into_iter().filter(is_one).collect()
}
