//! The cost of a step of a remote FMU, compared with a raw Zenoh ping-pong in the same run:
//! microseconds for set, step and get of one instance on a worker of this machine.
//!
//! `cargo bench -p cosim --bench remote`. Both are measured alternately, several times, and medians
//! are shown: a disturbance affects both.

#[path = "../tests/element/mod.rs"]
#[allow(dead_code, reason = "a chain is not needed here")]
mod element;

use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use cosim::Time;
use cosim::distributed::proxy::Proxy;
use cosim::fmi::{Fmu, Instance, Logging};
use zenoh::qos::CongestionControl;
use zenoh::{Config, Session, Wait};

const REPETITIONS: usize = 9;
const STEPS: u32 = 2_000;
/// Size of a ping in octets, about that of a step.
const PING: usize = 64;
/// The endpoint to which the other side of a ping-pong connects.
const ECHO: &str = "COSIM_BENCH_ECHO";

fn main() {
    if let Ok(endpoint) = std::env::var(ECHO) {
        return echo(&endpoint);
    }
    let folder = tempfile::TempDir::new().unwrap();
    let fmu = element::fmu(folder.path());
    let mut local = instance(&fmu);
    let endpoint = free_endpoint();
    let remote = proxy(&fmu, &endpoint);
    let _worker = worker(&endpoint);
    let mut there = instance(&remote);
    let pings = Pings::new();
    let (mut raw, mut steps, mut here) = (Vec::new(), Vec::new(), Vec::new());
    for number in 0..REPETITIONS as u32 {
        raw.push(pings.round_trip());
        steps.push(stepped(&mut there, number));
        here.push(stepped(&mut local, number));
    }
    let [raw, steps, here] = [raw, steps, here].map(median);
    println!("raw Zenoh publication there and back, {PING} octets: {raw:.1} us");
    println!("a step of a remote FMU             {steps:9.1} us {:8.2} x (at most 2)", steps / raw);
    println!("a step of the same FMU here        {here:9.3} us");
}

/// A process that ends with the benchmark.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

fn free_endpoint() -> String {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    format!("tcp/127.0.0.1:{port}")
}

fn proxy(fmu: &Path, endpoint: &str) -> PathBuf {
    let library = std::env::current_exe().unwrap().with_file_name("libcosim_proxy.so");
    let remote = fmu.with_file_name("element.remote.fmu");
    let proxy = Proxy::new().listen(endpoint).library(library).save_every(50);
    proxy.program(env!("CARGO_BIN_EXE_cosim")).write(fmu, &remote).unwrap();
    remote
}

fn worker(endpoint: &str) -> Running {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cosim"));
    command.args(["worker", "--name", "bench", "--allow-upload", "--connect", endpoint]);
    Running(command.stderr(Stdio::null()).spawn().unwrap())
}

fn instance(fmu: &Path) -> Instance {
    let fmu = Fmu::open(fmu).unwrap();
    let mut instance = Instance::new(fmu, "element", &Logging::default()).unwrap();
    instance.enter_initialization(Time::ZERO, Time::NEVER).unwrap();
    instance.exit_initialization().unwrap();
    instance
}

/// Microseconds per step: an input is set, the step made, the output read.
fn stepped(instance: &mut Instance, number: u32) -> f64 {
    let reference =
        |name: &str| [instance.fmu().description().variable(name).unwrap().value_reference];
    let (u, y) = (reference("u"), reference("y"));
    let step = Time::from_seconds(1e-3);
    let mut now = Time::from_seconds(f64::from(number * STEPS) * 1e-3);
    let mut value = [0.0];
    let begun = Instant::now();
    for k in 0..STEPS {
        instance.set_real(&u, &[f64::from(k)]).unwrap();
        instance.do_step(now, step).unwrap();
        instance.get_real(&y, &mut value).unwrap();
        now = now + step;
    }
    begun.elapsed().as_secs_f64() / f64::from(STEPS) * 1e6
}

/// A session configured as in runs.
fn open(mode: &str, what: &str, endpoint: &str) -> Session {
    let mut config = Config::default();
    for (key, value) in [
        ("mode", format!("\"{mode}\"")),
        ("scouting/multicast/enabled", "false".to_owned()),
        ("scouting/gossip/enabled", "false".to_owned()),
        ("listen/endpoints", "[]".to_owned()),
        (what, format!("[\"{endpoint}\"]")),
        ("connect/timeout_ms", "5000".to_owned()),
    ] {
        config.insert_json5(key, &value).unwrap();
    }
    zenoh::open(config).wait().unwrap()
}

/// The other side: echoes what it receives, until it is killed.
fn echo(endpoint: &str) {
    let session = open("client", "connect/endpoints", endpoint);
    let (heard, pings) = channel();
    let _subscriber = session
        .declare_subscriber("bench/ping")
        .callback(move |sample| drop(heard.send(sample.payload().to_bytes().into_owned())))
        .wait()
        .unwrap();
    let publisher = session
        .declare_publisher("bench/pong")
        .congestion_control(CongestionControl::Block)
        .express(true)
        .wait()
        .unwrap();
    while let Ok(ping) = pings.recv() {
        publisher.put(ping).wait().unwrap();
    }
}

/// This side.
struct Pings {
    session: Session,
    _echo: Running,
}

impl Pings {
    fn new() -> Self {
        let endpoint = free_endpoint();
        let session = open("router", "listen/endpoints", &endpoint);
        let program = std::env::current_exe().unwrap();
        let echo = Running(Command::new(program).env(ECHO, &endpoint).spawn().unwrap());
        Self { session, _echo: echo }
    }

    /// Microseconds until a message is back.
    fn round_trip(&self) -> f64 {
        let (heard, pongs) = channel();
        let _subscriber = self
            .session
            .declare_subscriber("bench/pong")
            .callback(move |sample| drop(heard.send(sample.payload().to_bytes().into_owned())))
            .wait()
            .unwrap();
        let publisher = self
            .session
            .declare_publisher("bench/ping")
            .congestion_control(CongestionControl::Block)
            .express(true)
            .wait()
            .unwrap();
        // Messages sent before the other side listens are lost.
        while !publisher.matching_status().wait().unwrap().matching() {
            std::thread::sleep(Duration::from_millis(5));
        }
        std::thread::sleep(Duration::from_millis(100));
        let begun = Instant::now();
        for _ in 0..STEPS {
            publisher.put([1_u8; PING].to_vec()).wait().unwrap();
            pongs.recv_timeout(Duration::from_secs(5)).unwrap();
        }
        begun.elapsed().as_secs_f64() / f64::from(STEPS) * 1e6
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
