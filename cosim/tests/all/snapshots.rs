//! A run that continues from a snapshot equals the uninterrupted run, to the last bit.

use std::path::Path;

use cosim::observe::{Continued, CsvRecorder};
use cosim::{Algorithm, Code, Input, Observer, Overrides, Recording, Run, Snapshot, System, Time};
use sha2::{Digest, Sha256};
use tempfile::TempDir;

use crate::formats::Folder;
use crate::models::Model::{Affine, Gain, Integrator, Lag};
use crate::ssd::{Ssd, zoo};
use crate::{converted, osp};

fn seconds(seconds: f64) -> Time {
    Time::from_seconds(seconds)
}

fn csv(run: impl FnOnce(&mut dyn Observer, &Path)) -> Vec<u8> {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("out.csv");
    let mut recorder = CsvRecorder::create(&file).unwrap();
    run(&mut recorder, &file);
    std::fs::read(&file).unwrap()
}

/// The bytes of an undisturbed run, and its snapshots, through files.
fn whole(system: &System, every: f64) -> (Vec<u8>, Vec<Snapshot>) {
    let (folder, mut files) = (TempDir::new().unwrap(), Vec::new());
    let mut keep = |snapshot: Snapshot| {
        let file = folder.path().join(format!("{}.snapshot", snapshot.time()));
        snapshot.write(&file)?;
        files.push(file);
        Ok(())
    };
    let bytes = csv(|recorder, _| {
        let run = Run::new(system).observe(recorder);
        run.snapshots(Some(seconds(every)), &[], &mut keep).go().unwrap();
    });
    (bytes, files.iter().map(|file| Snapshot::read(file).unwrap()).collect())
}

/// Ways to run a system.
fn ways() -> [Overrides; 5] {
    [
        Overrides::new().algorithm(Algorithm::Jacobi),
        Overrides::new().algorithm(Algorithm::GaussSeidel),
        Overrides::new().algorithm(Algorithm::Iterative),
        Overrides::new().input("", Input::Linear),
        Overrides::new().step_control(1e-3).input("", Input::Linear),
    ]
}

#[test]
fn every_snapshot_goes_on_to_the_same_bytes() {
    resumes_as_if_nothing_happened(&|overrides| zoo().load(overrides).unwrap(), &[0.4, 0.8, 1.2]);
}

#[test]
fn converted_inputs_and_sums_go_on_to_the_same_bytes() {
    let folder = Folder::new();
    let converted = |overrides: &Overrides| converted::converted(Lag, &folder, overrides);
    resumes_as_if_nothing_happened(&converted, &[0.4, 0.8]);
    let file = folder.write("OspSystemStructure.xml", &osp::summed());
    let summed = |overrides: &Overrides| System::load(&file, overrides).unwrap();
    resumes_as_if_nothing_happened(&summed, &[0.4, 0.8]);
}

/// In every way, from every snapshot.
fn resumes_as_if_nothing_happened(load: &dyn Fn(&Overrides) -> System, taken: &[f64]) {
    for overrides in ways() {
        let system = load(&overrides);
        let (bytes, snapshots) = whole(&system, 0.4);
        let times: Vec<f64> = snapshots.iter().map(|s| s.time().seconds()).collect();
        assert_eq!(times, taken);
        let undisturbed = csv(|recorder, _| drop(system.run(&mut [recorder]).unwrap()));
        assert!(bytes == undisturbed, "taking snapshots changes nothing");
        for snapshot in &snapshots {
            let old = Recording::read_csv(write(&bytes)).unwrap();
            let folder = TempDir::new().unwrap();
            let file = folder.path().join("out.csv");
            let recorder = Box::new(CsvRecorder::create(&file).unwrap());
            let mut continued = Continued::new(recorder, old);
            Run::new(&system).observe(&mut continued).resume(snapshot).go().unwrap();
            let resumed = std::fs::read(&file).unwrap();
            assert!(resumed == bytes, "{overrides:?} from {}", snapshot.time());
        }
    }
}

fn write(bytes: &[u8]) -> std::path::PathBuf {
    let (_, path) = tempfile::NamedTempFile::new().unwrap().keep().unwrap();
    std::fs::write(&path, bytes).unwrap();
    path
}

#[test]
fn the_command_line_continues_a_file_in_another_process() {
    let (folder, ssd) = (TempDir::new().unwrap(), zoo());
    let file = ssd.write();
    let cosim = |arguments: &[&str]| {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_cosim"))
            .args(["run", file.to_str().unwrap(), "-q"])
            .args(arguments)
            .current_dir(folder.path())
            .output()
            .unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    for suffix in ["csv", "mcap"] {
        let (whole, part) = (format!("whole.{suffix}"), format!("part.{suffix}"));
        assert_eq!(cosim(&["-o", &whole]).0, Some(0));
        let arguments = ["-o", &part, "--snapshot-at=0.75", "--snapshot-file", "at_{t}.snapshot"];
        // The end is different: the state at 0.75 s continues to any end.
        let (code, stderr) = cosim(&[&arguments[..], &["--stop-time=1.1"]].concat());
        assert_eq!(code, Some(0), "{stderr}");
        let (code, stderr) = cosim(&["-o", &part, "--resume", "at_0.8.snapshot"]);
        assert_eq!(code, Some(0), "{stderr}");
        if suffix == "csv" {
            assert!(read(&whole) == read(&part));
        }
        let [whole, part] =
            [whole, part].map(|f| cosim::observe::read(folder.path().join(f)).unwrap());
        assert!(whole == part);
    }
    // Into a new file: only what comes after.
    assert_eq!(cosim(&["-o", "tail.csv", "--resume", "at_0.8.snapshot"]).0, Some(0));
    let tail = cosim::observe::read(folder.path().join("tail.csv")).unwrap();
    assert_eq!((tail.time()[0], tail.time().len()), (0.9, 7));
    let (code, stderr) =
        cosim(&["-o", "part.csv", "--resume", "at_0.8.snapshot", "--output-variable=p.y"]);
    assert_eq!(code, Some(3), "{stderr}");
    let before = read("part.csv");
    let (code, stderr) =
        cosim(&["-o", "part.csv", "--resume", "at_0.8.snapshot", "--start-value=p.k=0.2"]);
    assert!(code == Some(3) && stderr.contains("E307") && stderr.contains("p.k = 0.3"), "{stderr}");
    assert!(before == read("part.csv"), "a refusal harms no results");
}

#[test]
fn what_is_damaged_or_of_another_system_is_refused() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("x.snapshot");
    let ssd = Ssd::new().add("g", Gain).add("x", Integrator).connect("g.y", "x.u");
    let system = ssd.load(&Overrides::new()).unwrap();
    let (_, snapshots) = whole(&system, 0.5);
    snapshots[0].write(&file).unwrap();
    let good = std::fs::read(&file).unwrap();
    let refused = |bytes: &[u8], part: &str| {
        std::fs::write(&file, bytes).unwrap();
        let error = Snapshot::read(&file).unwrap_err();
        assert_eq!(error.code(), Code::Snapshot);
        assert!(error.to_string().contains(part), "{error}");
    };
    for place in [60, good.len() / 2, good.len() - 1] {
        let mut bytes = good.clone();
        bytes[place] ^= 1;
        refused(&bytes, "checksum");
    }
    refused(&good[..good.len() - 1], "checksum");
    refused(b"time,x\n0,1\n", "not a snapshot");
    let mut other = good.clone();
    other[8] = 9;
    refused(&other, "version 9");
    for (overrides, part) in [
        (Overrides::new().algorithm(Algorithm::Jacobi), "jacobi"),
        (Overrides::new().step("x", 0.05), "every 0.05 s"),
        (Overrides::new().start_value("g.k", 2), "g.k = 2"),
        (Overrides::new().replace("g", Affine.fmu()), "component g"),
        (Overrides::new().output_variable("g.y"), "column"),
    ] {
        let other = system.with(&overrides).unwrap();
        let error = Run::new(&other).resume(&snapshots[0]).go().unwrap_err().to_string();
        assert!(error.contains("another system") && error.contains(part), "{error}");
    }
    // At the stop time there is nothing left to do.
    let over = system.with(&Overrides::new().stop_time(0.5)).unwrap();
    assert_eq!(Run::new(&over).resume(&snapshots[0]).go().unwrap().steps, 0);
    let late = system.with(&Overrides::new().stop_time(0.4)).unwrap();
    let error = Run::new(&late).resume(&snapshots[0]).go().unwrap_err();
    assert_eq!(error.code(), Code::Timing);
}

/// A time as it is in the file: its sign in the lowest bit, seven bits a byte.
fn encoded(ns: i64) -> Vec<u8> {
    let mut rest = (ns << 1 ^ ns >> 63) as u64;
    let mut bytes = Vec::new();
    while rest > 0x7f {
        bytes.push(rest as u8 | 0x80);
        rest >>= 7;
    }
    bytes.push(rest as u8);
    bytes
}

/// Otherwise a run would make up for all steps since then: 10^11.
#[test]
fn times_that_no_run_has_are_refused() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("x.snapshot");
    let ssd = Ssd::new().add("g", Gain).add("x", Integrator).connect("g.y", "x.u");
    let system = ssd.load(&Overrides::new()).unwrap();
    let (_, snapshots) = whole(&system, 0.5);
    snapshots[0].write(&file).unwrap();
    let good = std::fs::read(&file).unwrap();
    assert_eq!(snapshots[0].time(), seconds(0.5));
    let step = system.components()[0].step.rounded();
    let (now, end) = (encoded(500_000_000), encoded((seconds(0.5) + step).ns()));
    let count = good.windows(end.len()).filter(|window| **window == end).count();
    assert_eq!(count, 2, "the ends of the steps of both components");
    let refused = |wanted: &[u8], ns: i64| {
        let at = good.windows(wanted.len()).position(|window| window == wanted).unwrap();
        let mut bytes = good.clone();
        bytes.splice(at..at + wanted.len(), encoded(ns));
        let digest = Sha256::digest(&bytes[44..]);
        bytes[12..44].copy_from_slice(&digest);
        std::fs::write(&file, bytes).unwrap();
        let snapshot = Snapshot::read(&file).unwrap();
        let error = Run::new(&system).resume(&snapshot).go().unwrap_err();
        assert_eq!(error.code(), Code::Snapshot, "{error}");
        assert!(error.to_string().contains("its steps are not those of"), "{error}");
    };
    for ns in [i64::MIN, -1, 0, 400_000_000, 900_000_000, i64::MAX] {
        refused(&end, ns);
    }
    for ns in [i64::MIN, -1, 0, 300_000_000] {
        refused(&now, ns);
    }
    std::fs::write(&file, &good).unwrap();
    Run::new(&system).resume(&Snapshot::read(&file).unwrap()).go().unwrap();
}

#[test]
fn an_fmu_that_cannot_serialize_is_named() {
    let folder = TempDir::new().unwrap();
    let unable = Gain.varied(folder.path(), "canSerializeFMUstate=\"true\"", "");
    let ssd = Ssd::new().add("g", Gain).add("h", Gain).connect("g.y", "h.u");
    let system = ssd.load(&Overrides::new().replace("h", &unable)).unwrap();
    let mut keep = |_| Ok(());
    let run = Run::new(&system).snapshots(None, &[seconds(0.3)], &mut keep);
    let error = run.go().unwrap_err();
    assert_eq!(error.code(), Code::State);
    let text = error.to_string();
    assert!(text.contains("'h' cannot be part") && text.contains("canSerializeFMUstate"), "{text}");
}
