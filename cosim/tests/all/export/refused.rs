//! What cannot be exported, and exported FMUs that cannot run.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::sync::Arc;

use cosim::fmi::{Fmu, Instance, Logging, Mailbox};
use tempfile::TempDir;

use super::{command, export, library};
use crate::command::{cosim, text};
use crate::models::Model::{Clock, Gain};
use crate::models::{compile, pack};
use crate::ssd::Ssd;

/// Nothing is written, and the message contains these parts.
#[track_caller]
fn refused(system: &Path, arguments: &[&str], exit: i32, parts: &[&str]) {
    let folder = TempDir::new().unwrap();
    let (code, message) = command(folder.path(), system, arguments);
    assert_eq!(code, exit, "{message}");
    for part in parts {
        assert!(message.contains(part), "'{part}' is not in:\n{message}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_system_that_does_not_check_is_not_exported() {
    let system = Ssd::new().add("clock", Clock).add("g", Gain).connect("clock.y", "g.uu");
    refused(&system.write(), &[], 3, &["E202", "'uu'", "'u'?"]);
}

#[test]
fn names_that_are_not_there_are_reported_with_the_nearest() {
    let system = Ssd::new().add("clock", Clock);
    let file = system.write();
    refused(&file, &["--hide", "clock.yy"], 3, &["E202", "'clock.yy'", "'clock.y'?"]);
    refused(&file, &["--expose", "klock.*"], 3, &["E202", "matches no variable"]);
}

#[test]
fn two_variables_of_one_name_are_reported() {
    let folder = TempDir::new().unwrap();
    let dotted = Gain.varied(folder.path(), "name=\"k\"", "name=\"b.k\"");
    let system = Ssd::new().add("a", Gain).add("a.b", Gain);
    let file = system.write();
    let replaced = format!("a={}", dotted.display());
    let replaced = ["--replace", &replaced];
    refused(&file, &replaced, 3, &["E210", "two variables", "'a.b.k'", "--hide"]);
    let hidden = [&replaced[..], &["--hide", "a.b.*"]].concat();
    export(&file, &hidden);
}

#[test]
fn another_name_than_an_fmus_is_refused() {
    let system = Ssd::new().add("clock", Clock);
    let file = system.write();
    let library = library().to_str().unwrap();
    let folder = TempDir::new().unwrap();
    let arguments = ["export", file.to_str().unwrap(), "-o", "Loop.zip", "--library", library];
    let output = cosim(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("ends in .fmu"));
    let arguments = ["export", file.to_str().unwrap(), "-o", "Loop.fmu", "--library", "none.so"];
    let output = cosim(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(3), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("none.so"));
}

#[test]
fn a_place_that_cannot_be_written_is_reported() {
    let system = Ssd::new().add("clock", Clock);
    let file = system.write();
    let library = library().to_str().unwrap();
    let output = cosim(
        file.parent().unwrap(),
        &["export", file.to_str().unwrap(), "-o", "/proc/x/Loop.fmu", "--library", library],
    );
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("E302"));
}

/// A library for ARM: only an ELF header and the marker are checked.
fn foreign(folder: &Path) -> std::path::PathBuf {
    let mut bytes = vec![0; 64];
    bytes[..6].copy_from_slice(b"\x7fELF\x02\x01");
    (bytes[16], bytes[18]) = (3, 183);
    bytes.extend(cosim::hosted::MARK.as_bytes());
    let path = folder.join("foreign.so");
    fs::write(&path, bytes).unwrap();
    path
}

#[test]
fn every_fmu_inside_must_have_a_binary_for_each_platform() {
    let folder = TempDir::new().unwrap();
    let foreign = foreign(folder.path());
    let system = Ssd::new().add("clock", Clock);
    let file = system.write();
    let arm = ["--library", foreign.to_str().unwrap()];
    let reported = ["E105", "'clock' has no binary for aarch64-linux", "foreign.so"];
    refused(&file, &arm, 3, &reported);
    let both = folder.path().join("both.fmu");
    pack(
        &both,
        &[
            ("modelDescription.xml", Gain.description().into_bytes()),
            ("binaries/linux64/GAIN.so", fs::read(compile(Gain)).unwrap()),
            ("binaries/aarch64-linux/GAIN.so", fs::read(&foreign).unwrap()),
        ],
    );
    let replaced = format!("clock={}", both.display());
    let exported = export(
        &Ssd::new().add("clock", Gain).write(),
        &[&arm[..], &["--replace", &replaced]].concat(),
    );
    let unpacked = cosim::fmi::archive::unpack(&exported.fmu).unwrap();
    assert!(unpacked.path().join("binaries/aarch64-linux/test.so").is_file());
    assert!(unpacked.path().join("binaries/linux64/test.so").is_file());
}

#[test]
fn other_libraries_are_refused() {
    let folder = TempDir::new().unwrap();
    let system = Ssd::new().add("clock", Clock);
    let file = system.write();
    for (name, bytes, part) in [
        ("wrong.so", fs::read(compile(Gain)).unwrap(), "does not contain"),
        ("text.so", b"no library, but long enough".to_vec(), "not an ELF"),
    ] {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        refused(&file, &["--library", path.to_str().unwrap()], 3, &["E105", name, part]);
    }
    let same = library().to_str().unwrap();
    refused(&file, &["--library", same], 2, &["two libraries are for linux64"]);
}

/// Files of the FMU inside.
const LIBRARY: &str = "resources/fmus/GAIN.fmu/binaries/linux64/GAIN.so";
const DESCRIPTION: &str = "resources/fmus/GAIN.fmu/modelDescription.xml";

/// An exported FMU, repacked with a changed file in its resources.
fn changed(name: &str, bytes: Option<&[u8]>) -> (TempDir, std::path::PathBuf) {
    let exported = export(&Ssd::new().add("g", Gain).write(), &[]);
    let unpacked = cosim::fmi::archive::unpack(&exported.fmu).unwrap();
    let names = [
        "modelDescription.xml",
        "binaries/linux64/test.so",
        "resources/SystemStructure.ssd",
        LIBRARY,
        DESCRIPTION,
        "resources/interface.bin",
    ];
    let mut entries = Vec::new();
    for entry in names {
        match (entry == name, bytes) {
            (true, None) => (),
            (true, Some(bytes)) => entries.push((entry, bytes.to_vec())),
            (false, _) => entries.push((entry, fs::read(unpacked.path().join(entry)).unwrap())),
        }
    }
    let fmu = exported.folder.path().join("changed.fmu");
    pack(&fmu, &entries);
    (exported.folder, fmu)
}

#[test]
fn without_sound_resources_there_is_no_instance_but_one_line() {
    for (name, bytes, part) in [
        ("resources/interface.bin", None, "interface.bin"),
        ("resources/interface.bin", Some(&b"\x01x"[..]), "interface.bin"),
        ("resources/SystemStructure.ssd", None, "SystemStructure.ssd"),
        ("resources/SystemStructure.ssd", Some(b"<a/>"), "root element is <a>"),
        (DESCRIPTION, None, "GAIN.fmu"),
        (DESCRIPTION, Some(b"<a/>"), "GAIN.fmu"),
        (LIBRARY, None, "GAIN.fmu"),
        (LIBRARY, Some(b"no library"), "GAIN.fmu"),
    ] {
        let (_folder, fmu) = changed(name, bytes);
        let mailbox = Arc::new(Mailbox::default());
        let logging = Logging { mailbox: Some(mailbox.clone()), ..Logging::default() };
        let made = Instance::new(Fmu::open(&fmu).unwrap(), "x", &logging);
        assert!(made.is_err(), "{name}");
        let reported = mailbox.take();
        assert_eq!(reported.len(), 1, "{name}: {reported:?}");
        assert!(reported[0].text.starts_with("fmi2Instantiate: "), "{reported:?}");
        assert!(
            reported[0].text.contains(part) && !reported[0].text.contains('\n'),
            "{reported:?}"
        );
    }
}

#[test]
fn resources_may_be_read_only() {
    let exported = export(&Ssd::new().add("clock", Clock).write(), &[]);
    let fmu = Fmu::open(&exported.fmu).unwrap();
    let mut instance = Instance::new(fmu, "x", &Logging::default()).unwrap();
    instance.enter_initialization(super::seconds(0.0), super::seconds(1.0)).unwrap();
    let folder = cosim::fmi::archive::unpack(&exported.fmu).unwrap();
    let resources = folder.path().join("resources");
    let mode = |mode| fs::set_permissions(&resources, fs::Permissions::from_mode(mode)).unwrap();
    mode(0o500);
    let hosted = cosim::hosted::Hosted::open(&resources, false);
    mode(0o700);
    assert!(hosted.is_ok());
}
