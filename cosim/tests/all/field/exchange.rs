//! Model exchange as in other tools.

use std::path::{Path, PathBuf};

use cosim::{Overrides, Recording, Result, System};
use tempfile::TempDir;

use crate::models::Model::{self, Ball, Lag, Oscillator, Ticker};

fn variant(folder: &TempDir, model: Model, define: &str, change: (&str, &str)) -> PathBuf {
    model.variant(&folder.path().join("me.fmu"), &[define], |text| {
        assert!(text.contains(change.0), "{}", change.0);
        text.replace(change.0, change.1)
    })
}

fn outputs(fmu: &Path) -> Result<Vec<f64>> {
    let system = System::single(fmu, &Overrides::new(), None)?;
    let mut recording = Recording::new();
    system.run(&mut [&mut recording])?;
    Ok(recording.column("y").unwrap().to_vec())
}

#[test]
fn an_event_that_never_settles_ends_the_run() {
    let folder = TempDir::new().unwrap();
    let error = outputs(&variant(&folder, Lag, "STORM", ("", ""))).unwrap_err().to_string();
    assert!(error.contains("'LAG' does not settle at t = 0 s"), "{error}");
}

#[test]
fn events_that_are_due_already_do_not_stop_the_time_unnoticed() {
    let folder = TempDir::new().unwrap();
    let error = outputs(&variant(&folder, Ticker, "LATE", ("", ""))).unwrap_err().to_string();
    assert!(error.contains("more than 1000 events follow at one instant"), "{error}");
    // An invalid instant is not an event.
    assert!(outputs(&variant(&folder, Ticker, "UNDEFINED", ("", ""))).is_ok());
}

#[test]
fn states_that_jumped_in_an_earlier_iteration_are_read() {
    let folder = TempDir::new().unwrap();
    let found = outputs(&variant(&folder, Ball, "SAYS_IT_ONCE", ("", ""))).unwrap();
    assert_eq!(found, outputs(&Ball.fmu()).unwrap());
}

#[test]
fn what_is_declared_as_not_needed_need_not_be_there() {
    let folder = TempDir::new().unwrap();
    let flag = "canGetAndSetFMUstate=\"true\"";
    let not_needed = "completedIntegratorStepNotNeeded=\"true\"";
    let fmu = variant(&folder, Lag, "LACKS_OPTIONAL", (flag, not_needed));
    assert_eq!(outputs(&fmu).unwrap(), outputs(&Lag.fmu()).unwrap());
}

#[test]
fn nominal_values_that_are_no_magnitudes_do_not_disturb_the_error_control() {
    let folder = TempDir::new().unwrap();
    for nominal in ["NOMINAL=0", "NOMINAL=-1", "NOMINAL=(0.0/0.0)"] {
        assert_eq!(
            outputs(&variant(&folder, Ball, nominal, ("", ""))).unwrap(),
            outputs(&Ball.fmu()).unwrap(),
            "{nominal}"
        );
    }
}

#[test]
fn states_stand_in_the_order_of_the_derivatives() {
    let folder = TempDir::new().unwrap();
    let order =
        |indices: [u32; 3]| indices.map(|index| format!("<Unknown index=\"{index}\"/>")).concat();
    let (usual, reversed) = (order([5, 7, 9]), order([9, 7, 5]));
    let fmu = variant(&folder, Oscillator, "REVERSED", (&usual, &reversed));
    let (found, wanted) = (outputs(&fmu).unwrap(), outputs(&Oscillator.fmu()).unwrap());
    let error = found.iter().zip(&wanted).map(|(f, w)| (f - w).abs()).fold(0.0, f64::max);
    assert!(error < 1e-12, "{error}");
}
