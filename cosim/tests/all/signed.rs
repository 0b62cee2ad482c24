//! Signatures of FMUs on the command line.

use std::fs;

use tempfile::TempDir;

use crate::command::{cosim, text};
use crate::models::Model;

#[test]
fn what_is_not_signed_by_that_key_is_neither_valid_nor_allowed() {
    let folder = TempDir::new().unwrap();
    let run = |arguments: &[&str]| {
        let output = cosim(folder.path(), arguments);
        (output.status.code().unwrap(), text(&output.stderr))
    };
    let file = folder.path().join("gain.fmu");
    fs::copy(Model::Gain.fmu(), &file).unwrap();
    assert_eq!(run(&["keys", "pair", "ours"]).0, 0);
    assert_eq!(run(&["keys", "pair", "theirs"]).0, 0);
    let (code, stderr) = run(&["keys", "pair", "ours"]);
    assert!(code == 1 && stderr.contains("E302"), "{stderr}");
    let validate = |key: &str| run(&["validate", "--verify-signature", key, "gain.fmu"]);
    let allow = ["worker", "--allow", "gain.fmu", "--verify-signature", "ours.pub"];

    for refused in [validate("ours.pub"), run(&allow)] {
        assert!(refused.0 == 3 && refused.1.contains("E108"), "{refused:?}");
        assert!(refused.1.contains("is not signed"), "{refused:?}");
    }
    assert_eq!(run(&["keys", "sign", "--key", "ours.key", "gain.fmu"]).0, 0);
    assert_eq!(validate("ours.pub").0, 0);
    let (code, stderr) = validate("theirs.pub");
    assert!(code == 3 && stderr.contains("with another key"), "{stderr}");
    let (code, stderr) = validate("ours.key");
    assert!(code == 1 && stderr.contains("no public Ed25519 key"), "{stderr}");

    let mut bytes = fs::read(&file).unwrap();
    bytes.push(0);
    fs::write(&file, bytes).unwrap();
    for refused in [validate("ours.pub"), run(&allow)] {
        assert!(refused.0 == 3 && refused.1.contains("E108"), "{refused:?}");
    }
    let (code, stderr) = run(&[&allow[..], &["--allow-upload"]].concat());
    assert!(code == 2 && stderr.contains("--allow-upload"), "{stderr}");
    // A folder for certificates is still created by its name alone.
    assert_eq!(run(&["keys", "members"]).0, 0);
    assert!(folder.path().join("members/authority/ca.pem").is_file());
}
