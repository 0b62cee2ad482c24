//! What a worker loads, and what an FMU can do there.

use std::net::TcpListener;
use std::path::Path;

use tempfile::TempDir;

use super::on_worker;
use crate::distributed::outcome;
use crate::models::Model;
use crate::ssd::Ssd;

#[test]
fn a_worker_loads_only_what_was_allowed_there() {
    let (folder, system) = (TempDir::new().unwrap(), Ssd::new().add("pump", Model::Gain).stop(1.0));
    let (at, file) = (folder.path(), system.write());
    let fmu = Model::Gain.fmu();
    let other = Model::Clock.fmu();
    let (code, stderr) = on_worker(at, &file, &["--allow", other.to_str().unwrap()], &[]);
    assert_eq!(code, 1, "{stderr}");
    let hash = sha256(&fmu);
    for part in ["[E508] pump: this worker does not load", &hash, "--allow-upload", "worker w"] {
        assert!(stderr.contains(part), "{stderr}");
    }
    let allowed = [fmu.to_str().unwrap(), &hash];
    for allowed in allowed {
        let (code, stderr) = on_worker(at, &file, &["--allow", allowed], &[]);
        assert_eq!(code, 0, "{stderr}");
    }
    let (code, stderr) = outcome(at, &["worker", "--allow", "nothing.fmu"]);
    assert_eq!(code, 3, "{stderr}");
}

fn sha256(file: &Path) -> String {
    use sha2::{Digest, Sha256};
    let hash = Sha256::digest(std::fs::read(file).unwrap());
    hash.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The kernel version, as far as it matters for Landlock.
fn has_landlock() -> bool {
    let release = std::fs::read_to_string("/proc/sys/kernel/osrelease").unwrap();
    let mut numbers = release.split(['.', '-']).map(|n| n.parse::<u32>().unwrap_or(0));
    (numbers.next(), numbers.next()) >= (Some(6), Some(7))
        && cosim::distributed::unconfined().is_none()
}

#[test]
fn an_fmu_of_a_worker_writes_only_in_its_folder_and_makes_no_connections() {
    let (folder, home) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = f64::from(listener.local_addr().unwrap().port());
    let system = Ssd::new().add_with("spy", Model::Nosy, &[("k", port)], None).stop(1.0);
    let (at, file) = (folder.path(), system.write());
    let environment = [("HOME", home.path().to_str().unwrap())];
    let run = |lent: &[&str]| {
        let (code, stderr) =
            on_worker(at, &file, &[&["--allow-upload"], lent].concat(), &environment);
        assert_eq!(code, 0, "{stderr}");
        (stderr, home.path().join("nosy.txt").exists())
    };
    if has_landlock() {
        let (said, written) = run(&[]);
        let wanted = "home: Permission denied; network: Permission denied; own folder: done";
        assert!(said.contains(wanted), "{said}");
        assert!(!written);
    } else {
        eprintln!("skipped: this kernel has no Landlock that knows networks");
    }
    let (said, written) = run(&["--no-confine"]);
    assert!(said.contains("home: done; network: done; own folder: done"), "{said}");
    assert!(written);
}
