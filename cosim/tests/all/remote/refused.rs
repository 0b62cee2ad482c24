//! What is refused, and that nothing is written in that case.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use cosim::fmi::Fmu;
use tempfile::TempDir;

use super::{Made, proxy};
use crate::locked::{free_port, start};
use crate::models::Model::{Ball, Gain, Integrator};
use crate::models::pack;

#[track_caller]
fn refused(fmu: &Path, arguments: &[&str], exit: i32, parts: &[&str]) {
    let folder = TempDir::new().unwrap();
    let (code, stderr) = proxy(folder.path(), fmu, arguments);
    assert_eq!(code, exit, "{stderr}");
    for part in parts {
        assert!(stderr.contains(part), "'{part}' is not in:\n{stderr}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn what_cannot_be_computed_elsewhere_is_not_written() {
    let folder = TempDir::new().unwrap();
    let no_fmu = folder.path().join("no.fmu");
    std::fs::write(&no_fmu, "no archive").unwrap();
    refused(&no_fmu, &[], 3, &["no.fmu"]);
    refused(&folder.path().join("none.fmu"), &[], 3, &["none.fmu"]);
    refused(&Ball.fmu(), &[], 3, &["no co-simulation part", "cosim export"]);
    let windows = folder.path().join("windows.fmu");
    let description = Gain.description().into_bytes();
    let entries =
        [("modelDescription.xml", description), ("binaries/win64/GAIN.dll", b"MZ".to_vec())];
    pack(&windows, &entries);
    refused(&windows, &[], 3, &["no binary", "win64"]);
}

#[test]
fn an_endpoint_that_is_open_or_without_keys_is_not_written() {
    let fmu = Gain.fmu();
    refused(&fmu, &["--listen", "tcp/0.0.0.0:7447"], 1, &["[E504]", "is refused", "--insecure"]);
    refused(&fmu, &["--listen", "udp/127.0.0.1:7447"], 1, &["[E504]", "the protocols are"]);
    refused(&fmu, &["--listen", "tls/0.0.0.0:7447"], 1, &["[E504]", "TLS needs certificates"]);
    let arguments = ["--listen", "tls/0.0.0.0:7447", "--credentials", "/nowhere"];
    refused(&fmu, &arguments, 1, &["[E506]", "/nowhere/ca.pem"]);
}

#[test]
fn where_nothing_can_be_written_it_is_said() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "").unwrap();
    let (gain, library) = (Gain.fmu(), super::library());
    let [gain, library] = [&gain, &library].map(|path| path.to_str().unwrap());
    let arguments = ["proxy", gain, "-o", "file/x.fmu", "--library", library];
    let (code, stderr) = crate::distributed::outcome(folder.path(), &arguments);
    assert!(code == 1 && stderr.contains("the FMU cannot be written"), "{stderr}");
    let own = folder.path().join("own.fmu");
    std::fs::copy(Gain.fmu(), &own).unwrap();
    let arguments = ["proxy", "own.fmu", "-o", "own.fmu", "--library", library];
    let (code, stderr) = crate::distributed::outcome(folder.path(), &arguments);
    assert!(code == 2 && stderr.contains("replace the FMU itself"), "{stderr}");
    assert_eq!(std::fs::read(own).unwrap(), std::fs::read(Gain.fmu()).unwrap());
}

#[test]
fn a_worker_that_does_not_allow_the_fmu_is_named() {
    let made = Made::of(Integrator, &["--wait", "5"]);
    let own = ["worker", "--name", "left", "--connect", &made.endpoint];
    let _worker = start(made.folder.path(), &own);
    let error = made.make().err().unwrap().to_string();
    for part in ["does not load INTEGRATOR.fmu", "worker left", "--allow"] {
        assert!(error.contains(part), "'{part}' is not in:\n{error}");
    }
}

#[test]
fn an_endpoint_that_is_taken_is_named_in_one_line() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let endpoint = format!("tcp/{}", taken.local_addr().unwrap());
    let made = Made::at(TempDir::new().unwrap(), endpoint, Integrator, &[]);
    let error = made.make().err().unwrap().to_string();
    assert!(error.contains(&made.endpoint) && error.contains("free?"), "{error}");
    assert_eq!(made.said().len(), 1);
}

#[test]
fn resources_may_be_read_only_and_must_be_whole() {
    let made = Made::of(Integrator, &[]);
    let unpacked = cosim::fmi::archive::unpack(&made.fmu).unwrap();
    let resources = unpacked.path().join("resources");
    for entry in std::fs::read_dir(&resources).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o400)).unwrap();
        }
    }
    let _worker = made.worker("left");
    drop(made.started(&[]));
    let program = resources.join("linux64/cosim");
    let mode = std::fs::metadata(program).unwrap().permissions().mode();
    assert_eq!(mode & 0o111, 0, "nothing depends on the program being one for the file system");
}

#[test]
fn a_held_fmu_is_not_packed_and_taken_from_the_worker() {
    let made = Made::of(Integrator, &["--held"]);
    let unpacked = cosim::fmi::archive::unpack(&made.fmu).unwrap();
    assert!(!unpacked.path().join("resources/INTEGRATOR.fmu").exists());
    assert!(unpacked.path().join("resources/remote.json").exists());
    let own = ["worker", "--name", "left", "--connect", &made.endpoint, "--allow"];
    let fmu = Integrator.fmu();
    let _worker = start(made.folder.path(), &[&own[..], &[fmu.to_str().unwrap()]].concat());
    drop(made.started(&[]));
}

#[test]
fn one_endpoint_is_for_one_instance_and_the_description_says_so() {
    let once = |made: &Made| {
        let description = Fmu::open(&made.fmu).unwrap();
        description.description().co_simulation.as_ref().unwrap().once_per_process
    };
    assert!(once(&Made::of(Gain, &[])));
    let second = format!("tcp/127.0.0.1:{}", free_port());
    assert!(!once(&Made::of(Gain, &["--listen", &second])));
}
