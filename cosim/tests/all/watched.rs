//! Observers of a distributed run: what they read, and that they cannot disturb it.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use cosim::distributed::Threads;
use tempfile::TempDir;
use zenoh::Wait;

use crate::distributed::{cosim, outcome, results, signal};
use crate::locked::{Running, free_port, keys, start};
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

/// A session of an observer, as soon as the run listens; with these settings besides the usual ones.
fn observer(endpoint: &str, more: &[(String, String)]) -> zenoh::Session {
    let mut config = zenoh::Config::default();
    let usual = [
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
    ];
    let more = more.iter().map(|(key, value)| (key.as_str(), value.clone()));
    for (key, value) in usual.into_iter().chain(more) {
        config.insert_json5(key, &value).unwrap();
    }
    zenoh::open(config).wait().unwrap()
}

const ENDPOINT: &str = "COSIM_TEST_OBSERVED";
const MORE: &str = "COSIM_TEST_OBSERVED_WITH";
const LISTENS: &str = "it listens";

/// Not a test of its own: the process that [`stalled`] stops.
#[test]
fn an_observer_of_everything() {
    let Ok(endpoint) = std::env::var(ENDPOINT) else {
        return;
    };
    let more = serde_json::from_str::<Vec<_>>(&std::env::var(MORE).unwrap()).unwrap();
    let session = observer(&endpoint, &more);
    let all = session.declare_subscriber("cosim/1/**").wait().unwrap();
    // The answer follows after what was declared.
    let answers = session.get("nothing/answers/this").wait().unwrap();
    assert!(answers.recv().is_err());
    println!("\n{LISTENS}");
    while all.recv().is_ok() {}
}

/// A process that subscribes to all that observers may hear, and then stops reading.
fn stalled(endpoint: &str, more: &[(String, String)]) -> Running {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", "watched::an_observer_of_everything", "--nocapture"]);
    command.env(ENDPOINT, endpoint).env(MORE, serde_json::to_string(more).unwrap());
    command.envs(Threads::One.setting()).stdout(Stdio::piped());
    let mut observer = Running(command.spawn().unwrap());
    let mut said = BufReader::new(observer.0.stdout.take().unwrap()).lines();
    assert!(said.any(|line| line.unwrap() == LISTENS));
    signal(observer.0.id(), "-STOP");
    observer
}

/// A run that publishes everything at an endpoint, waits for [`workers`] and must not lose them;
/// before that, the same run in one process.
fn reported(at: &Path, protocol: &str, more: &[&str]) -> (String, Running) {
    std::fs::write(at.join("wide.ssd"), wide(1000.0).text()).unwrap();
    let (code, stderr) = outcome(at, &["run", "wide.ssd", "-q", "-o", "here.csv"]);
    assert_eq!(code, 0, "{stderr}");
    let endpoint = format!("{protocol}/127.0.0.1:{}", free_port());
    let run = ["run", "wide.ssd", "-q", "-o", "there.csv", "--listen", &endpoint, "--telemetry"];
    let run = [&run[..], &["--distributed", "--min-workers", "2", "--wait", "600"]].concat();
    let run = [&run[..], &["--real-time=150", "--recoveries", "0"], more].concat();
    let run = start(at, &run);
    (endpoint, run)
}

/// The run begins: its observers are connected.
fn workers(at: &Path, endpoint: &str) -> [Running; 2] {
    ["left", "right"].map(|name| {
        let worker = ["worker", "--name", name, "--connect", endpoint, "--allow-upload"];
        let keys = format!("keys/{name}");
        let keys = ["--credentials", &keys];
        start(at, &[&worker[..], if endpoint.starts_with("tls") { &keys } else { &[] }].concat())
    })
}

#[test]
fn stopped_observers_delay_no_step() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let (endpoint, mut run) = reported(at, "tcp", &[]);
    let good = observer(&endpoint, &[]);
    let status_told = good.declare_subscriber("cosim/1/*/status").wait().unwrap();
    let seen = Arc::new(AtomicUsize::new(0));
    let counted = seen.clone();
    let signals = good.declare_subscriber("cosim/1/*/signals");
    let count = move |_| {
        counted.fetch_add(1, Ordering::Relaxed);
    };
    let _signals = signals.callback(count).wait().unwrap();
    // The run closes their connections after a second, in which something waits for them.
    let stopped = [(); 3].map(|()| stalled(&endpoint, &[]));
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
    assert_eq!(status["groups"].as_array().unwrap().len(), 2);
}

#[test]
fn stopped_observers_with_certificates_delay_no_step() {
    let folder = keys();
    let at = folder.path();
    let (endpoint, mut run) = reported(at, "tls", &["--credentials", "keys/orchestrator"]);
    let file = |name: &str| format!("{:?}", at.join("keys/observer").join(name));
    let more = [
        ("transport/link/tls/root_ca_certificate".to_owned(), file("ca.pem")),
        ("transport/link/tls/connect_certificate".to_owned(), file("cert.pem")),
        ("transport/link/tls/connect_private_key".to_owned(), file("key.pem")),
        ("transport/link/tls/enable_mtls".to_owned(), "true".to_owned()),
    ];
    let stopped = [(); 3].map(|()| stalled(&endpoint, &more));
    let _workers = workers(at, &endpoint);
    assert_eq!(run.0.wait().unwrap().code(), Some(0));
    drop(stopped);
    assert_eq!(results(at, "here.csv"), results(at, "there.csv"));
}

/// Zenoh waits forever for a peer that requested low latency and does not read.
#[test]
fn an_observer_that_blocks_its_line_holds_up_neither_steps_nor_the_end() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let (endpoint, mut run) = reported(at, "tcp", &[]);
    let quick =
        [("transport/unicast/lowlatency", "true"), ("transport/unicast/qos/enabled", "false")];
    let stopped = stalled(&endpoint, &quick.map(|(key, value)| (key.to_owned(), value.to_owned())));
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
