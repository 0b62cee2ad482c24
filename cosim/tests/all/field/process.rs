//! What FMUs expect from their process and from the files around them.

use std::path::{Path, PathBuf};
use std::process::Command;

use cosim::Overrides;
use serde_json::Value;
use tempfile::TempDir;

use super::{run, with};
use crate::command::{cosim, text};
use crate::models::Model::Gain;
use crate::models::{compile_into, pack};
use crate::ssd::Ssd;

/// An FMU of a gain with this library, and with additional files.
fn filled(folder: &Path, library: &Path, more: &[(&str, Vec<u8>)]) -> PathBuf {
    let mut entries = vec![
        ("modelDescription.xml", Gain.description().into_bytes()),
        ("binaries/linux64/GAIN.so", std::fs::read(library).unwrap()),
    ];
    entries.extend(more.iter().cloned());
    let fmu = folder.join("filled.fmu");
    pack(&fmu, &entries);
    fmu
}

/// An FMU that reads its gain from a file in the folder given by this C expression.
fn reading(folder: &Path, place: &str) -> PathBuf {
    let library = folder.join("reading.so");
    compile_into(Gain, &library, &[&format!("READS={place}")], &[]);
    filled(folder, &library, &[("resources/gain.txt", b"4".to_vec())])
}

fn simulate(folder: &Path, fmu: &Path, temporary: &Path) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_cosim"))
        .args(["simulate", "--start-value", "u=1", "--output-file", "out.csv"])
        .arg(fmu)
        .current_dir(folder)
        .env("TMPDIR", temporary)
        .output()
        .unwrap();
    (output.status.code(), text(&output.stderr))
}

#[test]
fn resources_are_found_by_fmus_that_cut_the_uri_to_a_path() {
    let folder = TempDir::new().unwrap();
    let fmu = reading(folder.path(), "resources+7");
    let (recording, _) = run(&fmu, &Overrides::new().start_value("u", 1.0));
    assert_eq!(recording.column("y").unwrap()[0], 4.0);
    // The URI of such a folder is not a path, and the FMU itself reports what is missing.
    let odd = folder.path().join("temporary folder \u{fc}");
    std::fs::create_dir(&odd).unwrap();
    let (code, reported) = simulate(folder.path(), &fmu, &odd);
    assert_eq!(code, Some(1), "{reported}");
    assert!(reported.contains("fmi2Instantiate returned NULL"), "{reported}");
    assert!(reported.contains("temporary%20folder%20%C3%BC"), "{reported}");
}

#[test]
fn the_working_folder_is_the_users_and_an_fmu_that_wants_another_says_what_it_misses() {
    let folder = TempDir::new().unwrap();
    let fmu = reading(folder.path(), "\"resources\"");
    let (code, reported) = simulate(folder.path(), &fmu, folder.path());
    assert!(code == Some(1) && reported.contains("no file resources/gain.txt"), "{reported}");
    std::fs::create_dir(folder.path().join("resources")).unwrap();
    std::fs::write(folder.path().join("resources/gain.txt"), "3").unwrap();
    assert_eq!(simulate(folder.path(), &fmu, folder.path()).0, Some(0));
    let written = std::fs::read_to_string(folder.path().join("out.csv")).unwrap();
    assert!(written.contains("\n0.0,3.0,"), "{written}");
}

#[test]
fn a_library_beside_the_fmus_own_is_found() {
    let folder = TempDir::new().unwrap();
    let (source, other) = (folder.path().join("other.c"), folder.path().join("libother.so"));
    std::fs::write(&source, "double gain_of_another(void) { return 7; }").unwrap();
    let made = Command::new("cc")
        .args(["-shared", "-fPIC", "-Wl,-soname,libother.so", "-o"])
        .args([&other, &source])
        .status()
        .unwrap();
    assert!(made.success());
    let library = folder.path().join("needing.so");
    compile_into(Gain, &library, &["NEEDS_ANOTHER_LIBRARY"], &[other.to_str().unwrap()]);
    // It is linked by its name alone.
    let beside = ("binaries/linux64/libother.so", std::fs::read(&other).unwrap());
    let fmu = filled(folder.path(), &library, &[beside]);
    let (recording, _) = run(&fmu, &Overrides::new().start_value("u", 1.0));
    assert_eq!(recording.column("y").unwrap()[0], 7.0);
    let without = filled(folder.path(), &library, &[]);
    let (code, reported) = simulate(folder.path(), &without, folder.path());
    assert!(code == Some(3) && reported.contains("install the library libother.so"), "{reported}");
}

#[test]
fn what_an_fmu_prints_is_not_among_the_results() {
    let folder = TempDir::new().unwrap();
    let fmu = with(&folder, Gain, "PRINTS");
    let fmu = fmu.to_str().unwrap();
    let output = cosim(folder.path(), &["simulate", fmu, "--format=json"]);
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["steps"], 10);
    assert!(text(&output.stderr).contains("a line on standard output"));
    let output = cosim(folder.path(), &["simulate", fmu, "--output-file=-"]);
    let printed = text(&output.stdout);
    assert_eq!(printed.lines().count(), 12, "{printed}");
    assert!(printed.starts_with("time,") && !printed.contains("a line"), "{printed}");
}

#[test]
fn one_thread_with_the_stack_of_a_main_thread_calls_an_fmu() {
    let folder = TempDir::new().unwrap();
    let defines = ["DEEP_STACK", "ONE_THREAD"];
    let fmu = Gain.variant(&folder.path().join("deep.fmu"), &defines, |text| text);
    let ssd = Ssd::new().add("g", Gain).add("h", Gain).connect("g.y", "h.u");
    let (file, deep) = (ssd.write(), format!("g={}", fmu.display()));
    for more in [&[][..], &["--workers", "2"]] {
        let arguments = ["run", file.to_str().unwrap(), "--replace", &deep];
        let output = cosim(folder.path(), &[&arguments[..], more].concat());
        assert!(output.status.success(), "{more:?}: {}", text(&output.stderr));
    }
}

#[test]
fn a_thread_that_an_fmu_leaves_behind_does_no_harm() {
    let folder = TempDir::new().unwrap();
    let fmu = with(&folder, Gain, "LEAVES_A_THREAD");
    let output = cosim(folder.path(), &["simulate", fmu.to_str().unwrap()]);
    assert!(output.status.success(), "{:?} {}", output.status, text(&output.stderr));
}

/// The library is not unloaded, and what it was given to call is still there.
#[test]
fn a_thread_that_logs_after_its_instance_is_freed_does_no_harm() {
    let folder = TempDir::new().unwrap();
    let fmu = with(&folder, Gain, "LOGS_LATE");
    let ssd = Ssd::new().add("g", Gain).add("h", Gain).connect("g.y", "h.u");
    let (file, fmu) = (ssd.write(), fmu.display());
    let (g, h) = (format!("g={fmu}"), format!("h={fmu}"));
    for more in [&[][..], &["--isolate"], &["--workers", "1"]] {
        let arguments = ["run", file.to_str().unwrap(), "--replace", &g, "--replace", &h];
        let output = cosim(folder.path(), &[&arguments[..], more].concat());
        assert!(output.status.success(), "{more:?}: {:?} {}", output.status, text(&output.stderr));
    }
}
