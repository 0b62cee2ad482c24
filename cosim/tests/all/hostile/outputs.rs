//! Where results go: never onto an input.

use std::process::Command;

use tempfile::TempDir;

use super::Workspace;
use crate::command::text;
use crate::models::Model;

#[test]
fn results_never_take_the_place_of_an_input() {
    let workspace = Workspace::new();
    let inside = workspace.folder.path().join("a/b");
    let fmu = std::fs::read(Model::Gain.fmu()).unwrap();
    let ssd = crate::ssd::Ssd::new().add("g", Model::Gain);
    let ssd = std::fs::read(ssd.write()).unwrap();
    std::fs::write(inside.join("in.csv"), "time,u\n0,1\n1,1\n").unwrap();
    std::fs::write(inside.join("other.csv"), "<?xml version='1.0'?><x/>").unwrap();
    for (verb, name, bytes, code) in [
        ("simulate -o x.fmu", "x.fmu", &fmu, 2),
        ("simulate -o ../b/x.fmu", "x.fmu", &fmu, 2),
        ("simulate --digest-file x.fmu -o -", "x.fmu", &fmu, 2),
        ("simulate --input-file in.csv -o in.csv", "x.fmu", &fmu, 2),
        ("simulate -o other.csv", "x.fmu", &fmu, 1),
        ("run -o x.ssd", "x.ssd", &ssd, 2),
        ("simulate --input-file in.csv --log-fmi-calls=in.csv -o -", "x.fmu", &fmu, 2),
        ("simulate --log-fmi-calls=x.fmu -o -", "x.fmu", &fmu, 1),
        ("simulate --snapshot-file x.fmu --snapshot-every 1 -o -", "x.fmu", &fmu, 2),
        ("simulate --snapshot-file x.fmu --snapshot-every 1 -o - --isolate", "x.fmu", &fmu, 2),
        (
            "simulate --input-file in.csv --snapshot-file in.csv --snapshot-every 1 -o -",
            "x.fmu",
            &fmu,
            2,
        ),
        ("simulate --start-value text=in.csv -o in.csv", "x.fmu", &fmu, 2),
        ("convert x.ssd", "x.ssd", &ssd, 1),
        ("report in.csv -o", "in.csv", &b"time,u\n0,1\n1,1\n".to_vec(), 2),
    ] {
        let (found, shown) = workspace.run(verb, name, bytes);
        assert_eq!(found, code, "{verb}: {shown}");
        assert_eq!(&std::fs::read(inside.join(name)).unwrap(), bytes, "{verb}");
    }
    let inputs = std::fs::read_to_string(inside.join("in.csv")).unwrap();
    assert_eq!(inputs, "time,u\n0,1\n1,1\n");
}

#[test]
fn a_missing_temporary_folder_is_named() {
    let folder = TempDir::new().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_cosim"))
        .args(["info", Model::Gain.fmu().to_str().unwrap()])
        .env("TMPDIR", folder.path().join("missing"))
        .output()
        .unwrap();
    let shown = text(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{shown}");
    assert!(shown.contains("no temporary folder can be created"), "{shown}");
    assert!(shown.contains("missing") && shown.contains("TMPDIR"), "{shown}");
}
