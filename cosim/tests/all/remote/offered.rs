//! Remote FMUs of FMUs that a worker holds, made without the FMU itself.

use std::path::Path;
use std::sync::Arc;

use tempfile::TempDir;

use super::{Made, here, proxy, steps};
use crate::locked::{Running, free_port, start};
use crate::models::Model::{Gain, Integrator};

/// A worker that holds two FMUs, connecting to an endpoint where nothing listens yet.
fn holder(folder: &Path, endpoint: &str) -> Running {
    let (one, other) = (Integrator.fmu(), Gain.fmu());
    let [one, other] = [&one, &other].map(|file| file.to_str().unwrap());
    let own = ["worker", "--name", "left", "--connect", endpoint, "--allow", one, "--allow", other];
    start(folder, &own)
}

#[test]
fn a_worker_provides_enough_of_an_fmu_for_a_remote_one() {
    let (folder, empty) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let endpoint = format!("tcp/127.0.0.1:{}", free_port());
    let _worker = holder(empty.path(), &endpoint);
    let file = Integrator.fmu();
    let name = file.file_name().unwrap();
    let from = ["--listen", &endpoint, "--from", "left"];
    let (code, stderr) = proxy(folder.path(), Path::new(name), &from);
    assert_eq!(code, 0, "{stderr}");
    let fmu = folder.path().join("x.remote.fmu");
    let unpacked = cosim::fmi::archive::unpack(&fmu).unwrap();
    assert!(!unpacked.path().join("resources").join(name).exists());

    // The same description as when made from the file, and the same bits.
    let at_hand = Made::at(TempDir::new().unwrap(), endpoint.clone(), Integrator, &["--held"]);
    assert_eq!(std::fs::read(&fmu).unwrap(), std::fs::read(&at_hand.fmu).unwrap());
    let made = Made { folder, fmu, endpoint, mailbox: Arc::default() };
    let (mut there, mut local) = (made.started(&[]), here(Integrator, &[]));
    assert_eq!(steps(&mut there, 0..50), steps(&mut local, 0..50));
}

#[test]
fn what_no_worker_offers_is_named_and_nothing_is_written() {
    let (folder, empty) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let endpoint = format!("tcp/127.0.0.1:{}", free_port());
    let _worker = holder(empty.path(), &endpoint);
    let file = Integrator.fmu();
    let held = file.file_name().unwrap().to_str().unwrap();
    let typo = held.replace(".fmu", "s.fmu");
    let ask = |fmu: &str, worker: &str| {
        let from = ["--listen", &endpoint, "--from", worker, "--wait", "1"];
        proxy(folder.path(), Path::new(fmu), &from)
    };
    let (code, stderr) = ask(&typo, "left");
    for part in ["worker left offers no", &typo, "did you mean", held] {
        assert!(code != 0 && stderr.contains(part), "'{part}' is not in:\n{stderr}");
    }
    let (code, stderr) = ask(held, "lefty");
    for part in ["worker lefty did not connect to", &endpoint, "connected: left", "--allow"] {
        assert!(code != 0 && stderr.contains(part), "'{part}' is not in:\n{stderr}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
