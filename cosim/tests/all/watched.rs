//! Observers of a distributed run: what they read, and that they cannot disturb it.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use tempfile::TempDir;
use zenoh::Wait;

use crate::distributed::{cosim, outcome, results, signal};
use crate::locked::{Running, free_port, start};
use crate::models::Model;
use crate::ssd::Ssd;

/// A chain with so many outputs that a row is some kilobytes of telemetry.
fn wide(stop: f64) -> Ssd {
    let mut system = Ssd::new().add("clock", Model::Clock);
    let mut before = "clock".to_owned();
    for number in 0..40 {
        let name = format!("a gain with a name that takes room, number {number}");
        let gain = system.add_with(&name, Model::Gain, &[("k", 0.99)], None);
        system = gain.connect(&format!("{before}.y"), &format!("{name}.u"));
        before = name;
    }
    system.stop(stop)
}

/// A session of an observer, as soon as the run listens.
fn observer(endpoint: &str) -> zenoh::Session {
    observer_by(endpoint, false)
}

/// The same, optionally with Zenoh's low-latency transport, which has no priorities.
fn observer_by(endpoint: &str, quick: bool) -> zenoh::Session {
    let mut config = zenoh::Config::default();
    for (key, value) in [
        ("mode", "\"client\"".to_owned()),
        ("connect/endpoints", format!("[{endpoint:?}]")),
        ("connect/timeout_ms", "20000".to_owned()),
        (
            "connect/retry",
            "{ period_init_ms: 20, period_max_ms: 100, period_increase_factor: 2 }".to_owned(),
        ),
        ("scouting/multicast/enabled", "false".to_owned()),
        // The run notices soon that it is gone.
        ("transport/link/tx/lease", "1000".to_owned()),
        ("transport/unicast/lowlatency", quick.to_string()),
        ("transport/unicast/qos/enabled", (!quick).to_string()),
    ] {
        config.insert_json5(key, &value).unwrap();
    }
    zenoh::open(config).wait().unwrap()
}

const ENDPOINT: &str = "COSIM_TEST_OBSERVED";
const QUICK: &str = "COSIM_TEST_OBSERVED_QUICKLY";
const LISTENS: &str = "it listens";

/// Not a test of its own: the process that [`stalled`] stops.
#[test]
fn an_observer_of_everything() {
    let Ok(endpoint) = std::env::var(ENDPOINT) else {
        return;
    };
    let session = observer_by(&endpoint, std::env::var_os(QUICK).is_some());
    let all = session.declare_subscriber("**").wait().unwrap();
    // The answer follows after what was declared.
    let answers = session.get("nothing/answers/this").wait().unwrap();
    assert!(answers.recv().is_err());
    println!("\n{LISTENS}");
    while all.recv().is_ok() {}
}

/// A process that subscribes to everything, and then stops reading.
fn stalled(endpoint: &str, quick: bool) -> Running {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", "watched::an_observer_of_everything", "--nocapture"]);
    command.env(ENDPOINT, endpoint).stdout(Stdio::piped());
    if quick {
        command.env(QUICK, "1");
    }
    let mut observer = Running(command.spawn().unwrap());
    let mut said = BufReader::new(observer.0.stdout.take().unwrap()).lines();
    assert!(said.any(|line| line.unwrap() == LISTENS));
    signal(observer.0.id(), "-STOP");
    observer
}

/// A run that publishes everything at an endpoint and waits for [`workers`], and a folder with the
/// results of the same run in one process.
fn reported() -> (TempDir, String, Running) {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    std::fs::write(at.join("wide.ssd"), wide(1000.0).text()).unwrap();
    let (code, stderr) = outcome(at, &["run", "wide.ssd", "-q", "-o", "here.csv"]);
    assert_eq!(code, 0, "{stderr}");
    let endpoint = format!("tcp/127.0.0.1:{}", free_port());
    let run = ["run", "wide.ssd", "-q", "-o", "there.csv", "--listen", &endpoint, "--telemetry"];
    let more = ["--distributed", "--min-workers", "2", "--wait", "600", "--real-time=150"];
    let run = start(at, &[&run[..], &more].concat());
    (folder, endpoint, run)
}

/// The run begins: its observers are connected.
fn workers(at: &Path, endpoint: &str) -> [Running; 2] {
    ["a", "b"]
        .map(|name| start(at, &["worker", "--name", name, "--connect", endpoint, "--allow-upload"]))
}

#[test]
fn a_stopped_observer_delays_no_step() {
    let (folder, endpoint, mut run) = reported();
    let at = folder.path();
    let good = observer(&endpoint);
    let status_told = good.declare_subscriber("cosim/1/*/status").wait().unwrap();
    let seen = Arc::new(AtomicUsize::new(0));
    let counted = seen.clone();
    let signals = good.declare_subscriber("cosim/1/*/signals");
    let count = move |_| {
        counted.fetch_add(1, Ordering::Relaxed);
    };
    let _signals = signals.callback(count).wait().unwrap();
    // The run closes their connections after a second, in which something waits for them.
    let stopped = [(); 3].map(|()| stalled(&endpoint, false));
    let _workers = workers(at, &endpoint);
    let mut status = serde_json::Value::Null;
    while status["ended"] != true {
        let message = status_told
            .recv_timeout(Duration::from_secs(30))
            .unwrap()
            .expect("the status of the run");
        status = serde_json::from_slice(&message.payload().to_bytes()).unwrap();
    }
    assert_eq!(run.0.wait().unwrap().code(), Some(0));
    drop(stopped);
    assert_eq!(results(at, "here.csv"), results(at, "there.csv"));
    assert!(seen.load(Ordering::Relaxed) > 100, "{seen:?}");
    let groups = status["groups"].as_array().unwrap();
    assert_eq!(groups.len(), 2);
    for group in groups {
        // A step that is held up for five seconds is made again.
        assert_eq!(group["generation"], 1, "{status}");
    }
}

/// Zenoh waits forever for a peer that requested low latency and does not read.
#[test]
fn an_observer_that_blocks_its_line_holds_up_neither_steps_nor_the_end() {
    let (folder, endpoint, mut run) = reported();
    let at = folder.path();
    let stopped = stalled(&endpoint, true);
    let _workers = workers(at, &endpoint);
    assert_eq!(run.0.wait().unwrap().code(), Some(0));
    drop(stopped);
    assert_eq!(results(at, "here.csv"), results(at, "there.csv"));
}

#[test]
fn watch_shows_a_run_until_it_ends() {
    let (folder, system) = (TempDir::new().unwrap(), wide(4.0));
    let file = system.write();
    let (at, path) = (folder.path(), file.to_str().unwrap());
    let endpoint = format!("tcp/127.0.0.1:{}", free_port());
    let run = ["run", path, "-q", "-o", "x.csv", "--workers", "2", "--real-time"];
    let mut run = start(at, &[&run[..], &["--listen", &endpoint]].concat());
    let address = endpoint.trim_start_matches("tcp/").to_owned();
    while std::net::TcpStream::connect(&address).is_err() {
        std::thread::sleep(Duration::from_millis(10));
    }
    let json = cosim(at, &["watch", "--connect", &endpoint, "--format", "json"]);
    let json = { json }.stdout(Stdio::piped()).spawn().unwrap();
    let text = cosim(at, &["watch", "--connect", &endpoint]).output().unwrap();
    let json = json.wait_with_output().unwrap();
    assert_eq!(run.0.wait().unwrap().code(), Some(0));
    assert!(text.status.success() && json.status.success());
    let text = String::from_utf8(text.stdout).unwrap();
    let last = text.lines().last().unwrap();
    assert!(last.starts_with("test: t = 4.000 of 4 s, "), "{text}");
    assert!(last.ends_with("ended"), "{text}");
    let lines = String::from_utf8(json.stdout).unwrap();
    let lines: Vec<serde_json::Value> =
        lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(lines.len() > 5);
    let places: Vec<&str> =
        lines[2]["groups"].as_array().unwrap().iter().filter_map(|g| g["place"].as_str()).collect();
    assert_eq!(places, ["worker worker-1", "worker worker-2"]);
    let (code, stderr) = outcome(at, &["watch", "--connect", &endpoint]);
    assert_eq!(code, 1);
    assert!(stderr.contains("[E504]") && stderr.contains("nothing listens"), "{stderr}");
}
