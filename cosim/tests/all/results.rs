//! Results files: MCAP and CSV contain the same.

use std::process::Command;

use cosim::observe::McapRecorder;
use cosim::{Overrides, Recording};
use tempfile::TempDir;

use crate::models::Model::{Clock, Counter, Gain, Integrator};
use crate::ssd::Ssd;

fn ssd() -> Ssd {
    Ssd::new()
        .add("clock", Clock)
        .add("9 lives", Gain)
        .add("count", Counter)
        .add("x", Integrator)
        .connect("clock.y", "9 lives.u")
        .connect("9 lives.y", "x.u")
        .stop(3.0)
}

#[test]
fn mcap_is_read_back_bit_by_bit_with_names_and_types() {
    let folder = TempDir::new().unwrap();
    // A Boolean before Reals, which are aligned to their size.
    let system = ssd().load(&Overrides::new().output_variable("*.even").output_variable("*.?"));
    let (system, mut memory) = (system.unwrap(), Recording::new());
    let file = folder.path().join("a.mcap");
    let mut mcap = McapRecorder::create(&file).unwrap();
    system.run(&mut [&mut memory, &mut mcap]).unwrap();
    assert!(memory.names().contains(&"9 lives.k".to_owned()));
    assert!(cosim::observe::read(&file).unwrap() == memory);
    // The same run gives the same bytes.
    let again = folder.path().join("b.mcap");
    system.run(&mut [&mut McapRecorder::create(&again).unwrap()]).unwrap();
    assert!(std::fs::read(&file).unwrap() == std::fs::read(&again).unwrap());
    // An unfinished file is read as far as it goes.
    let bytes = std::fs::read(&file).unwrap();
    std::fs::write(&again, &bytes[..bytes.len() / 2]).unwrap();
    let cut = cosim::observe::read(&again).unwrap();
    assert!(cut.time().len() < memory.time().len());
    std::fs::write(&again, b"time,x\n0,1\n").unwrap();
    assert!(cosim::observe::read(&again).unwrap_err().to_string().contains("b.mcap"));
    let early = system.with(&Overrides::new().start_time(-1.0)).unwrap();
    let error = early.run(&mut [&mut McapRecorder::create(&again).unwrap()]).unwrap_err();
    assert!(error.to_string().contains("negative time"), "{error}");
}

#[test]
fn the_command_line_chooses_by_the_ending_and_reports_either() {
    let (folder, ssd) = (TempDir::new().unwrap(), ssd());
    let file = ssd.write();
    let cosim = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_cosim"))
            .args(arguments)
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let file = file.to_str().unwrap();
    let json = cosim(&["run", file, "-o", "r.mcap", "--format=json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((&json["steps"], &json["components"][3]["steps"]), (&120.into(), &30.into()));
    assert_eq!(json["components"][1]["name"], "9 lives");
    cosim(&["run", file, "-q", "-o", "r.csv"]);
    let [mcap, csv] =
        ["r.mcap", "r.csv"].map(|f| cosim::observe::read(folder.path().join(f)).unwrap());
    assert_eq!(mcap.names(), csv.names());
    assert!(mcap.columns().eq(csv.columns()));
    cosim(&["report", "r.mcap"]);
    let page = std::fs::read_to_string(folder.path().join("r.html")).unwrap();
    assert!(page.contains("9 lives.y"), "{page}");
}
