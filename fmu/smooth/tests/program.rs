//! The program on small logs.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

const HEADER: &str = "time,ahrs.attitude.roll,ahrs.attitude.pitch,ahrs.attitude.yaw,ahrs.stamp,\
    dvl.velocity.u,dvl.velocity.v,dvl.velocity.w,dvl.stamp,pressure.depth,pressure.stamp,\
    fix.position.x,fix.position.y,fix.stamp";

/// A minute north at 1 m/s, 5 m deep, with a fix at the end that is 2 m farther east than the start.
fn log(held: bool) -> String {
    let mut text = HEADER.to_owned() + "\n";
    for i in 0..=600 {
        let t = f64::from(i) / 10.0;
        // Values that repeat bit for bit come from a stuck instrument.
        let e = f64::from(i * 7 % 11 - 5) * 1e-4;
        text += &format!("{t},{e},{e},{e},{t},");
        text += &match i % 10 {
            0 => format!("{},{e},{e},{t},", 1.0 + e),
            _ if held => {
                format!("{0},{1},{1},{2},", 1.0 + held_error(i), held_error(i), held_stamp(i))
            }
            // Both ways to omit a sample.
            1 => "nan,NaN,,,".to_owned(),
            _ => ",,,,".to_owned(),
        };
        text += &format!("{},{t},", 5.0 + e);
        text += if i == 600 { "60,2,60\n" } else { ",,\n" };
    }
    text
}

fn held_error(i: i32) -> f64 {
    f64::from(i / 10 * 10 * 7 % 11 - 5) * 1e-4
}

fn held_stamp(i: i32) -> f64 {
    f64::from(i / 10)
}

const PARAMETERS: &str = r#"{"fix_sigma": 0.01, "initial.pose.z": 5}"#;

fn smooth(folder: &TempDir, log: &str, parameters: &str, arguments: &[&str]) -> Output {
    fs::write(folder.path().join("log.csv"), log).unwrap();
    fs::write(folder.path().join("parameters.json"), parameters).unwrap();
    Command::new(env!("CARGO_BIN_EXE_rexrov-smooth"))
        .args(["--filter=NavInertial", "--parameters=parameters.json", "log.csv"])
        .args(arguments)
        .current_dir(folder.path())
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

fn table(csv: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let names = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let row = |row: csv::StringRecord| row.iter().map(|x| x.parse().unwrap()).collect();
    (names, reader.records().map(|r| row(r.unwrap())).collect())
}

#[test]
fn a_fix_at_the_end_moves_the_whole_path() {
    let folder = TempDir::new().unwrap();
    let done = smooth(&folder, &log(false), PARAMETERS, &[]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    assert!(
        text(&done.stderr).contains("dvl: 61 samples\nfix: 1 samples"),
        "{}",
        text(&done.stderr)
    );
    let (names, rows) = table(text(&done.stdout));
    let column = |name: &str| names.iter().position(|n| n == name).unwrap();
    let [x, y, sigma] = ["pose.x", "pose.y", "sigma.y"].map(column);
    assert_eq!((names[0].as_str(), rows.len()), ("time", 601));
    assert!(
        names.contains(&"covariance.x_y".to_owned()) && names.contains(&"velocity.u".to_owned())
    );
    let [middle, end] = [300, 600].map(|i| &rows[i]);
    assert!((end[y] - 2.0).abs() < 0.02 && (end[x] - 60.0).abs() < 0.1, "{end:?}");
    // The start is as uncertain as the heading over a minute: both are corrected.
    assert!((0.1..1.9).contains(&middle[y]) && end[sigma] < 0.1 * middle[sigma], "{middle:?}");
}

#[test]
fn values_that_are_held_and_those_of_a_component_are_the_same_samples() {
    let folder = TempDir::new().unwrap();
    let sparse = smooth(&folder, &log(false), PARAMETERS, &["-o", "smoothed.csv", "-q"]);
    assert_eq!((text(&sparse.stdout), text(&sparse.stderr)), ("", ""));
    let sparse = fs::read_to_string(folder.path().join("smoothed.csv")).unwrap();
    let held = smooth(&folder, &log(true), PARAMETERS, &[]);
    assert!(text(&held.stdout) == sparse, "the held values differ");
    let recorded = log(false).replacen("dvl.", "ins.dvl.", 4).replacen("ahrs.", "ins.ahrs.", 4);
    let recorded =
        recorded.replacen("pressure.", "ins.pressure.", 2).replacen("fix.", "ins.fix.", 3);
    let component = smooth(&folder, &recorded, PARAMETERS, &["--component=ins"]);
    assert!(text(&component.stdout) == sparse, "{}", text(&component.stderr));
}

#[test]
fn what_is_wrong_is_said_with_its_place_and_the_name_that_was_meant() {
    let folder = TempDir::new().unwrap();
    let good = log(false);
    let mut lines: Vec<&str> = good.lines().collect();
    lines[7] = "0.6,zero,0,0,0.6,,,,,5,0.6,,,";
    let number = lines.join("\n");
    lines[7] = "0.3,0,0,0,0.6,,,,,5,0.6,,,";
    let back = lines.join("\n");
    let renamed = |from: &str, to: &str| good.replacen(from, to, 1);
    let typo = r#"{"fix_sigmo": 1}"#;
    for (log, parameters, arguments, expected) in [
        (
            renamed("dvl.velocity.u", "dvl.velocity.x"),
            "{}",
            &[][..],
            "log.csv:1: column 'dvl.velocity.x'",
        ),
        (renamed("dvl.velocity.u", "dlv.velocity.u"), "{}", &[], "did you mean 'dvl.velocity.u'?"),
        (
            renamed("dvl.velocity.u", "surge"),
            "{}",
            &[],
            "'dvl.velocity.v', but none 'dvl.velocity.u'",
        ),
        (renamed("time", "seconds"), "{}", &[], "there is no column 'time'"),
        (number, "{}", &[], "log.csv:8: column 'ahrs.attitude.roll': 'zero' is not a number"),
        (back, "{}", &[], "log.csv:8: the time 0.3 s comes after 0.5 s"),
        (
            good.clone(),
            typo,
            &[],
            "parameters.json: 'fix_sigmo' is not a parameter of NavInertial; did you mean 'fix_sigma'?",
        ),
        (good.clone(), r#"{"fix_sigma": "a"}"#, &[], "parameter 'fix_sigma': expected a number"),
        (good.clone(), r#"{"fix_sigma": -1}"#, &[], "fix_sigma"),
        (good.clone(), "{}", &["--component=ins"], "no column with an input of 'ins'"),
    ] {
        let done = smooth(&folder, &log, parameters, arguments);
        assert!(!done.status.success() && done.stdout.is_empty(), "{expected}");
        assert!(text(&done.stderr).contains(expected), "{expected}: {}", text(&done.stderr));
    }
    let done = Command::new(env!("CARGO_BIN_EXE_rexrov-smooth"))
        .args(["--filter=NavInertail", "log.csv"])
        .current_dir(Path::new(folder.path()))
        .output()
        .unwrap();
    assert!(text(&done.stderr).contains("did you mean 'NavInertial'?"), "{}", text(&done.stderr));
}
