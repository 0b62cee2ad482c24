//! Unpacked archives: private, shared, and removed afterwards, however a process ends.

use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use cosim::fmi::{Fmu, archive};
use cosim::observe::RunInfo;
use cosim::{Observer, Overrides, Result, System, Time};
use tempfile::TempDir;

use crate::models::Model;
use crate::rawzip::{self, Entry};

#[test]
fn cut_or_no_archive_at_all() {
    let folder = TempDir::new().unwrap();
    let whole = std::fs::read(Model::Gain.fmu()).unwrap();
    let path = folder.path().join("cut.fmu");
    for length in [0, 10, whole.len() / 2, whole.len() - 1] {
        std::fs::File::create(&path).unwrap().write_all(&whole[..length]).unwrap();
        let error = Fmu::open(&path).err().expect("cut").to_string();
        assert!(error.contains("E102"), "{error}");
    }
}

#[test]
fn the_unpacked_folder_is_private_and_vanishes() {
    let folder = archive::unpack(&Model::Gain.fmu()).unwrap();
    let path = folder.path().to_owned();
    let mode = |path: &Path| path.metadata().unwrap().permissions().mode() & 0o777;
    assert_eq!((mode(&path), mode(path.parent().unwrap())), (0o700, 0o700));
    assert!(path.join("modelDescription.xml").is_file());
    drop(folder);
    assert!(!path.parent().unwrap().exists());
}

#[test]
fn programs_stay_programs() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("x.zip");
    let mut program = Entry::new("resources/run", b"#!/bin/sh\n");
    program.mode = 0o104_755;
    std::fs::write(&path, rawzip::archive(&[program, Entry::new("data", b"1")])).unwrap();
    let unpacked = archive::unpack(&path).unwrap();
    let mode =
        |name: &str| unpacked.path().join(name).metadata().unwrap().permissions().mode() & 0o7777;
    assert_eq!((mode("resources/run"), mode("data")), (0o700, 0o600));
}

#[test]
fn files_of_one_content_are_one_fmu() {
    let folder = TempDir::new().unwrap();
    let path = Model::Gain.fmu();
    let (copy, other) = (folder.path().join("copy.fmu"), folder.path().join("other.fmu"));
    std::fs::copy(&path, &copy).unwrap();
    std::fs::copy(Model::Clock.fmu(), &other).unwrap();
    let (first, again) = (Fmu::open(&path).unwrap(), Fmu::open(&path).unwrap());
    assert!(Arc::ptr_eq(&first, &again));
    assert!(Arc::ptr_eq(&first, &Fmu::open(&copy).unwrap()));
    assert!(!Arc::ptr_eq(&first, &Fmu::open(&other).unwrap()));
    // A file that is replaced while its old content is in use becomes another FMU.
    std::fs::copy(&other, &copy).unwrap();
    assert!(!Arc::ptr_eq(&first, &Fmu::open(&copy).unwrap()));
}

struct Panics;

impl Observer for Panics {
    fn start(&mut self, _: &RunInfo<'_>) -> Result<()> {
        Ok(())
    }
    fn sample(&mut self, _: Time, _: &[f64]) -> Result<()> {
        panic!("an observer that is not ours")
    }
    fn finish(&mut self) -> Result<()> {
        Ok(())
    }
}

#[test]
fn a_panic_takes_the_folder_along() {
    let folder = TempDir::new().unwrap();
    // Content that no other test uses.
    let path = Model::Gain.variant(&folder.path().join("x.fmu"), &["ALONE"], |d| d + "<!-- -->");
    let fmu = Arc::downgrade(&Fmu::open(&path).unwrap());
    let run = std::panic::catch_unwind(|| {
        let system = System::single(&path, &Overrides::new(), None).unwrap();
        drop(system.run(&mut [&mut Panics]));
    });
    assert!(run.is_err() && fmu.upgrade().is_none());
}

/// A long run of the binary, with its own temporary folder.
struct Run {
    folder: TempDir,
    child: Child,
}

impl Run {
    fn new() -> Self {
        let folder = TempDir::new().unwrap();
        std::fs::create_dir(folder.path().join("temporary")).unwrap();
        let child = Self::command(&folder).stderr(Stdio::null()).spawn().unwrap();
        let run = Self { folder, child };
        // The first results exist once the run has started.
        let results = run.folder.path().join("CLOCK_out.csv");
        wait(|| results.metadata().is_ok_and(|m| m.len() > 0));
        run
    }

    fn command(folder: &TempDir) -> Command {
        // A shell makes background processes ignore SIGINT, and that is inherited.
        let mut command = Command::new("env");
        command.args(["--default-signal=HUP,INT,TERM", env!("CARGO_BIN_EXE_cosim")]);
        command.args(["simulate", "--stop-time=1e8", "--step-size=0.01", "-q"]);
        command.arg(Model::Clock.fmu()).current_dir(folder.path());
        command.env("TMPDIR", folder.path().join("temporary"));
        command
    }

    fn unpacked(&self) -> Vec<PathBuf> {
        let temporary = self.folder.path().join("temporary");
        std::fs::read_dir(temporary).unwrap().flatten().map(|e| e.path()).collect()
    }

    fn signal(&mut self, signal: i32) -> std::process::ExitStatus {
        let id = self.child.id().to_string();
        Command::new("kill").arg(format!("-{signal}")).arg(id).status().unwrap();
        self.child.wait().unwrap()
    }
}

fn wait(until: impl Fn() -> bool) {
    for _ in 0..2000 {
        if until() {
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("waited in vain");
}

#[test]
fn signals_end_a_run_and_its_folder() {
    // SIGHUP, SIGINT, SIGTERM
    for signal in [1, 2, 15] {
        let mut run = Run::new();
        assert_eq!(run.unpacked().len(), 1);
        assert_eq!(run.signal(signal).code(), Some(130), "{signal}");
        assert!(run.unpacked().is_empty(), "{signal}");
    }
}

#[test]
fn what_a_killed_process_leaves_is_swept_by_the_next() {
    let mut run = Run::new();
    assert_eq!(run.signal(9).signal(), Some(9));
    let left = run.unpacked();
    assert_eq!(left.len(), 1);
    let next = || {
        let arguments = ["info", Model::Gain.fmu().to_str().unwrap()].map(str::to_owned);
        let mut command = Command::new(env!("CARGO_BIN_EXE_cosim"));
        command.args(arguments).env("TMPDIR", run.folder.path().join("temporary"));
        assert!(command.stdout(Stdio::null()).status().unwrap().success());
    };
    // Another process may just be creating its folder: recent ones stay.
    next();
    assert_eq!(run.unpacked(), left);
    let lock = std::fs::File::options().write(true).open(left[0].join("lock")).unwrap();
    lock.set_modified(SystemTime::now() - Duration::from_secs(3600)).unwrap();
    drop(lock);
    next();
    assert!(run.unpacked().is_empty());
}
