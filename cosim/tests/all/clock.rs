//! Real time, and keys.

use std::io::Read;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use cosim::Pace;
use cosim::{Overrides, Run, System};

use crate::models::Model::Clock;

#[test]
fn a_run_is_no_faster_than_the_clock_and_reports_when_it_is_slower() {
    let overrides = Overrides::new().stop_time(2.0);
    let system = System::single(&Clock.fmu(), &overrides, None).unwrap();
    let (begun, mut pace) = (Instant::now(), Pace::new(10.0));
    Run::new(&system).manipulate(&mut pace).go().unwrap();
    assert!(begun.elapsed() >= Duration::from_millis(200));
    assert_eq!(pace.overruns().instants, 21);
    // A billion times real time is too fast.
    let overrides = Overrides::new().stop_time(1e6).output_interval(1000.0);
    let system = System::single(&Clock.fmu(), &overrides, None).unwrap();
    let mut pace = Pace::new(1e9);
    Run::new(&system).manipulate(&mut pace).go().unwrap();
    let overruns = pace.overruns();
    assert!(overruns.count > 0 && overruns.worst > 0.0, "{overruns:?}");
}

#[test]
fn real_time_is_an_option_and_overruns_are_reported() {
    let run = |arguments: &[&str]| {
        let fmu = Clock.fmu();
        let output = Command::new(env!("CARGO_BIN_EXE_cosim"))
            .args(["simulate", fmu.to_str().unwrap(), "-o", "/dev/null"])
            .args(arguments)
            .stdin(Stdio::null())
            .output()
            .unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, stderr) = run(&["--stop-time=0.5", "--real-time"]);
    assert!(code == Some(0) && stderr.contains("real time: "), "{stderr}");
    assert_eq!(run(&["--real-time=0"]).0, Some(2));
}

/// Runs the command in its own terminal with Python's pty, which sends the keys: the first when
/// progress is shown, each other one this many seconds after the pause caused by the previous one.
fn in_terminal(keys: &str, gap: f64, arguments: &[&str]) -> String {
    let script = r"
import os, pty, select, sys, time
pid, fd = pty.fork()
if pid == 0:
    os.execv(sys.argv[3], sys.argv[3:])
text, keys, sent, gap, seen = b'', sys.argv[1].encode(), 0, float(sys.argv[2]), None
while True:
    if select.select([fd], [], [], 0.05)[0]:
        try:
            data = os.read(fd, 4096)
        except OSError:
            break
        if not data:
            break
        text += data
    if seen is None and b' of ' in text and text.count(b'paused at t') >= sent:
        seen = time.time()
    if sent < len(keys) and seen and time.time() - seen > gap:
        os.write(fd, keys[sent:sent + 1])
        sent, seen = sent + 1, None
print(text.decode(), os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))
";
    let mut child = Command::new("python3")
        .args(["-c", script, keys, &gap.to_string(), env!("CARGO_BIN_EXE_cosim")])
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut text = String::new();
    child.stdout.take().unwrap().read_to_string(&mut text).unwrap();
    assert!(child.wait().unwrap().success());
    text
}

#[test]
fn keys_pause_step_and_end_a_run() {
    let fmu = Clock.fmu();
    let arguments = ["simulate", fmu.to_str().unwrap(), "-o", "/dev/null", "--real-time"];
    let arguments = [&arguments[..], &["--stop-time=100"]].concat();
    let text = in_terminal(" ssq", 0.1, &arguments);
    // One pause, two steps of 0.1 s, each shown with its time.
    let paused: Vec<f64> = text
        .split("paused at t = ")
        .skip(1)
        .map(|rest| rest.split(' ').next().unwrap().parse().unwrap())
        .collect();
    assert_eq!(paused.len(), 3, "{text}");
    assert!((paused[2] - paused[0] - 0.2).abs() < 1e-9, "{paused:?}");
    assert!(text.contains("E303") && text.trim().ends_with(" 130"), "{text}");
    // A pause, which lasts two seconds, does not count as an overrun; a busy machine may be late.
    let short = [&arguments[..arguments.len() - 1], &["--stop-time=3"]].concat();
    let text = in_terminal("  ", 2.0, &short);
    assert!(text.contains("paused") && text.trim().ends_with('0'), "{text}");
    let worst = text.split("the worst ").nth(1).map_or("0", |rest| rest.split(' ').next().unwrap());
    assert!(worst.parse::<f64>().unwrap() < 1500.0, "{text}");
}
