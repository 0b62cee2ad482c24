//! Access to remote FMUs: mutual TLS, as for runs.

use tempfile::TempDir;

use super::{Made, here, steps};
use crate::distributed::outcome;
use crate::locked::{free_port, start};
use crate::models::Model::Integrator;

/// Keys of two authorities, `keys` and `foreign`.
fn keys() -> TempDir {
    let folder = TempDir::new().unwrap();
    for name in ["keys", "foreign"] {
        let (code, stderr) = outcome(folder.path(), &["keys", name, "--worker", "left"]);
        assert_eq!(code, 0, "{stderr}");
    }
    folder
}

#[test]
fn only_a_worker_with_a_certificate_computes() {
    let folder = keys();
    let endpoint = format!("tls/127.0.0.1:{}", free_port());
    let arguments = ["--credentials", "keys/orchestrator", "--wait", "3"];
    let made = Made::at(folder, endpoint, Integrator, &arguments);
    let worker = |credentials: &str| {
        let fmu = Integrator.fmu();
        let own = ["worker", "--name", "left", "--connect", &made.endpoint, "--credentials"];
        let allow = ["--allow", fmu.to_str().unwrap()];
        start(made.folder.path(), &[&own[..], &[credentials], &allow].concat())
    };
    let foreign = worker("foreign/left");
    let error = made.make().err().unwrap().to_string();
    assert!(error.contains("no worker"), "{error}");
    drop(foreign);
    let _friend = worker("keys/left");
    let mut it = (0..5).find_map(|_| made.make().ok()).unwrap();
    super::initialize(&mut it, &[]);
    assert_eq!(steps(&mut it, 0..20), steps(&mut here(Integrator, &[]), 0..20));
}
