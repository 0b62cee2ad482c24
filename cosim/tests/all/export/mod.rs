//! Systems exported as FMUs, through the binary, and driven by our own importer.

mod bits;
mod inside;
pub(crate) mod lifecycles;
mod refused;
mod scenario;
mod shown;
mod states;

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use cosim::fmi::{Fmu, Instance, Logging, Variable};
use cosim::{Overrides, Recording, System, Time};
use tempfile::TempDir;

use crate::command::{cosim, text};
use crate::ssd::run;

/// The library of exported systems, which Cargo builds with the tests.
pub(crate) fn library() -> &'static Path {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    BUILT.get_or_init(|| {
        let program = std::env::current_exe().unwrap();
        let library = program.with_file_name("libcosim_system.so");
        assert!(library.is_file(), "{}", library.display());
        library
    })
}

/// An exported system in a folder of its own.
pub(crate) struct Exported {
    pub(crate) folder: TempDir,
    pub(crate) fmu: PathBuf,
}

/// Exports a system by the command line.
#[track_caller]
pub(crate) fn export(system: &Path, arguments: &[&str]) -> Exported {
    let folder = TempDir::new().unwrap();
    let fmu = folder.path().join("Loop.fmu");
    let done = command(folder.path(), system, arguments);
    assert_eq!(done.0, 0, "{}", done.1);
    Exported { folder, fmu }
}

/// Exit code and messages of an export to Loop.fmu in a folder.
fn command(folder: &Path, system: &Path, arguments: &[&str]) -> (i32, String) {
    let library = library().to_str().unwrap();
    let own = ["export", system.to_str().unwrap(), "-o", "Loop.fmu", "-q", "--library", library];
    let output = cosim(folder, &[&own, arguments].concat());
    (output.status.code().unwrap(), text(&output.stderr))
}

impl Exported {
    /// Runs it as one FMU with communication steps of that length.
    fn run(&self, step: f64, overrides: Overrides) -> Recording {
        let system = System::single(&self.fmu, &overrides.step("", step), None);
        run(&system.unwrap_or_else(|e| panic!("{e}")))
    }

    /// An instance that has left its initialization.
    #[track_caller]
    fn started(&self) -> Instance {
        let mut instance = self.instance();
        instance.enter_initialization(Time::ZERO, seconds(10.0)).unwrap();
        instance.exit_initialization().unwrap();
        instance
    }

    #[track_caller]
    fn instance(&self) -> Instance {
        let fmu = Fmu::open(&self.fmu).unwrap();
        Instance::new(fmu, "loop", &Logging::default()).unwrap_or_else(|e| panic!("{e}"))
    }

    fn description(&self) -> String {
        let folder = cosim::fmi::archive::unpack(&self.fmu).unwrap();
        std::fs::read_to_string(folder.path().join("modelDescription.xml")).unwrap()
    }
}

fn seconds(seconds: f64) -> Time {
    Time::from_seconds(seconds)
}

fn variable<'a>(instance: &'a Instance, name: &str) -> &'a Variable {
    let description = instance.fmu().description();
    description.variable(name).unwrap_or_else(|| panic!("no {name}"))
}

fn get(instance: &mut Instance, name: &str) -> f64 {
    let reference = variable(instance, name).value_reference;
    let mut value = [f64::NAN];
    instance.get_real(&[reference], &mut value).unwrap();
    value[0]
}

fn set(instance: &mut Instance, name: &str, value: f64) {
    let reference = variable(instance, name).value_reference;
    instance.set_real(&[reference], &[value]).unwrap();
}

/// Steps from `begin` to `end`.
fn step(instance: &mut Instance, begin: f64, end: f64) {
    instance.do_step(seconds(begin), seconds(end) - seconds(begin)).unwrap();
}

/// Every column of `part` is, bit for bit, a part of `whole`, at the same instants.
#[track_caller]
fn assert_same(part: &Recording, whole: &Recording) {
    let place = |time: &f64| whole.time().iter().position(|t| t == time).unwrap();
    let places: Vec<usize> = part.time().iter().map(place).collect();
    for (name, values) in part.columns() {
        let others = whole.column(name).unwrap();
        for (value, &place) in values.iter().zip(&places) {
            let (t, other) = (whole.time()[place], others[place]);
            assert_eq!(value.to_bits(), other.to_bits(), "{name} at {t}: {value}, {other}");
        }
    }
    assert!(part.time().len() > 1 && part.names().len() > 1);
}
