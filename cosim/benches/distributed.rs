//! The cost of distribution, compared with a raw TCP ping-pong in the same run: microseconds per
//! macro-step on 2 and 8 workers, with and without snapshots and TLS; the time from a kill until
//! the run continues; the time to transfer an FMU of 100 MB.
//!
//! `cargo bench -p cosim --bench distributed`. All are measured alternately, several times, and
//! medians are shown. A cost per step is the difference between a long and a short run, divided by
//! the steps between them, so start and end do not count.

#[path = "../tests/element/mod.rs"]
mod element;

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use zip::ZipWriter;
use zip::write::SimpleFileOptions;

const REPETITIONS: usize = 5;
const STEP: f64 = 1e-3;
/// Steps of the short and of the long run.
const STEPS: [u32; 2] = [1_000, 25_000];
/// Size of a ping in octets, about that of a step.
const PING: usize = 64;
const PINGS: u32 = 4_000;
/// Marks this process as the other side of a ping-pong.
const ECHO: &str = "COSIM_BENCH_ECHO";
const KILLS: usize = 12;

fn main() {
    if let Ok(address) = std::env::var(ECHO) {
        return echo(&address);
    }
    let bench = Bench::new();
    let mut samples: [Vec<f64>; 6] = Default::default();
    for _ in 0..REPETITIONS {
        let values = [
            Some(ping_pong(1)),
            Some(ping_pong(8)),
            Some(bench.step(2, false, 0)),
            Some(bench.step(2, false, 50)),
            bench.keys.is_some().then(|| bench.step(2, true, 0)),
            Some(bench.step(8, false, 0)),
        ];
        for (samples, value) in samples.iter_mut().zip(values) {
            samples.extend(value);
        }
    }
    let [rtt, barrier, two, saved, tls, eight] = samples.map(median);
    println!("raw TCP, {PING} octets, two processes: {rtt:.1} us; barrier of 8: {barrier:.1} us");
    print_result("2 workers, a macro-step", two, "us", two / rtt, "x RTT", 6.0);
    print_result("2 workers with TLS", tls, "us", tls / rtt, "x RTT", 7.0);
    print_result("8 workers", eight, "us", eight / barrier, "x barrier", 8.0);
    print_result(
        "snapshots every 50 steps",
        saved,
        "us",
        100.0 * (saved / two - 1.0),
        "% more",
        10.0,
    );
    let mut resumed = bench.kills();
    resumed.sort_by(f64::total_cmp);
    let worst = resumed.last().copied().unwrap_or(f64::NAN);
    let (count, middle) = (resumed.len(), median(resumed));
    print_result(
        &format!("killed to resumed, median of {count}"),
        middle,
        "ms",
        worst,
        "ms worst",
        500.0,
    );
    let delivered = bench.delivery();
    print_result("an FMU of 100 MB", delivered, "s", delivered, "s", 2.0);
}

fn print_result(what: &str, value: f64, unit: &str, ratio: f64, of: &str, goal: f64) {
    println!("{what:34} {value:9.1} {unit:2} {ratio:8.2} {of} (at most {goal})");
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The other side: echoes what it receives.
fn echo(address: &str) {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_nodelay(true).unwrap();
    let mut message = [0; PING];
    while stream.read_exact(&mut message).is_ok() {
        stream.write_all(&message).unwrap();
    }
}

/// Microseconds until all of `others` have echoed a message.
fn ping_pong(others: usize) -> f64 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let program = std::env::current_exe().unwrap();
    let start = || Command::new(&program).env(ECHO, &address).spawn().unwrap();
    let children: Vec<Child> = (0..others).map(|_| start()).collect();
    let mut streams: Vec<TcpStream> = (0..others).map(|_| listener.accept().unwrap().0).collect();
    streams.iter().for_each(|stream| stream.set_nodelay(true).unwrap());
    let mut message = [1; PING];
    let begun = Instant::now();
    for _ in 0..PINGS {
        streams.iter_mut().for_each(|stream| stream.write_all(&message).unwrap());
        streams.iter_mut().for_each(|stream| stream.read_exact(&mut message).unwrap());
    }
    let spent = begun.elapsed().as_secs_f64() / f64::from(PINGS);
    drop(streams);
    children.into_iter().for_each(|mut child| drop(child.wait()));
    spent * 1e6
}

struct Bench {
    folder: tempfile::TempDir,
    fmu: PathBuf,
    /// Certificates, if they could be made.
    keys: Option<PathBuf>,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::TempDir::new().unwrap();
        let fmu = element::fmu(folder.path());
        let keys = folder.path().join("keys");
        let mut make = Command::new(env!("CARGO_BIN_EXE_cosim"));
        make.arg("keys").arg(&keys).stdout(Stdio::null());
        let keys = make.status().is_ok_and(|status| status.success()).then_some(keys);
        Self { folder, fmu, keys }
    }

    fn command(&self, system: &Path, steps: u32, more: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cosim"));
        let stop = (f64::from(steps) * STEP).to_string();
        command.arg("run").arg(system).args(["--algorithm", "jacobi", "--format", "json"]);
        command.args(["--stop-time", &stop, "--output-interval", &stop, "-o", "x.csv"]);
        command.args(more).current_dir(self.folder.path());
        command
    }

    /// Microseconds per macro-step: two FMUs per worker, all workers at once.
    fn step(&self, workers: usize, tls: bool, save_every: u32) -> f64 {
        let stop = f64::from(STEPS[1]) * STEP;
        let system = element::chain(&self.fmu, 2 * workers, STEP, stop);
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let (count, save) = (workers.to_string(), save_every.to_string());
        let mut more = vec!["--save-every", &save];
        let endpoint = match tls {
            true => format!("tls/localhost:{port}"),
            false => format!("tcp/127.0.0.1:{port}"),
        };
        more.extend(["--listen", &endpoint]);
        let mut lent = Vec::new();
        match (&self.keys, tls) {
            (Some(keys), true) => {
                for number in 1..=workers {
                    lent.push(self.lend(keys, &format!("worker-{number}"), &endpoint));
                }
                let own = keys.join("orchestrator").to_string_lossy().into_owned();
                return self.difference(
                    &system,
                    &[
                        &more[..],
                        &[
                            "--distributed",
                            "--min-workers",
                            &count,
                            "--wait",
                            "20",
                            "--credentials",
                            &own,
                        ],
                    ]
                    .concat(),
                );
            }
            _ => more.extend(["--workers", &count]),
        }
        self.difference(&system, &more)
    }

    fn difference(&self, system: &Path, more: &[&str]) -> f64 {
        let spent = STEPS.map(|steps| {
            let output = self.command(system, steps, more).output().unwrap();
            let reported = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{reported}");
            let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
            summary["spent"].as_f64().unwrap()
        });
        (spent[1] - spent[0]) / f64::from(STEPS[1] - STEPS[0]) * 1e6
    }

    /// A worker with certificates.
    fn lend(&self, keys: &Path, name: &str, endpoint: &str) -> Lent {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cosim"));
        command.args(["worker", "--name", name, "--connect", endpoint, "--allow-upload"]);
        command.arg("--credentials").arg(keys.join(name)).stderr(Stdio::null());
        // It reconnects until something listens.
        Lent(command.spawn().unwrap())
    }

    /// Milliseconds from kills of groups until the run continued, as it reports them.
    fn kills(&self) -> Vec<f64> {
        let system = element::chain(&self.fmu, 4, STEP, 1e4);
        let mut command = self.command(&system, 400_000, &["--workers", "2"]);
        let mut run = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        for number in 0..KILLS {
            std::thread::sleep(Duration::from_millis(300));
            let groups: Vec<u32> =
                children(run.id()).iter().flat_map(|&worker| children(worker)).collect();
            if let Some(group) = groups.get(number % groups.len().max(1)) {
                drop(Command::new("kill").args(["-KILL", &group.to_string()]).status());
            }
        }
        std::thread::sleep(Duration::from_millis(500));
        // Ctrl-C ends it in order, with a summary.
        drop(Command::new("kill").args(["-INT", &run.id().to_string()]).status());
        let mut reported = String::new();
        run.stdout.take().unwrap().read_to_string(&mut reported).unwrap();
        run.wait().unwrap();
        let summary: serde_json::Value = serde_json::from_str(&reported).unwrap();
        let notes = summary["notes"].as_array().unwrap().iter().filter_map(|note| note.as_str());
        notes
            .filter_map(|note| note.split("after ").last()?.strip_suffix(" ms")?.parse().ok())
            .collect()
    }

    /// By how many seconds a run of one step on a worker is longer with an FMU of 100 MB than with
    /// a small one.
    fn delivery(&self) -> f64 {
        let large = self.folder.path().join("large").join("element.fmu");
        std::fs::create_dir_all(large.parent().unwrap()).unwrap();
        padded(&self.fmu, &large);
        let spent = [&self.fmu, &large].map(|fmu| {
            let system = element::chain(fmu, 2, STEP, 1.0);
            let run = |more: &[&str]| {
                let begun = Instant::now();
                let output = self.command(&system, 1, more).output().unwrap();
                assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
                begun.elapsed().as_secs_f64()
            };
            // The run itself unpacks and hashes the FMU in any case.
            median((0..3).map(|_| run(&["--workers", "1"]) - run(&[])).collect())
        });
        spent[1] - spent[0]
    }
}

struct Lent(Child);

impl Drop for Lent {
    fn drop(&mut self) {
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

/// The same FMU with 100 MB of incompressible data among its resources.
fn padded(fmu: &Path, large: &Path) {
    let library = fmu.with_file_name("element.so");
    let mut state = 1_u64;
    let noise: Vec<u8> = (0..12_500_000)
        .flat_map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state ^ (state >> 29)).to_le_bytes()
        })
        .collect();
    let mut zip = ZipWriter::new(std::fs::File::create(large).unwrap());
    let stored = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    let entries = [
        ("modelDescription.xml", include_bytes!("../tests/element/element.xml").to_vec()),
        ("binaries/linux64/element.so", std::fs::read(library).unwrap()),
        ("resources/noise", noise),
    ];
    for (name, bytes) in entries {
        zip.start_file(name, stored).unwrap();
        zip.write_all(&bytes).unwrap();
    }
    zip.finish().unwrap();
}

/// The processes whose parent is `parent`.
fn children(parent: u32) -> Vec<u32> {
    let all = std::fs::read_dir("/proc").unwrap().flatten();
    let numbers = all.filter_map(|entry| entry.file_name().to_str()?.parse::<u32>().ok());
    let is_child = |number: &u32| {
        let stat = std::fs::read_to_string(format!("/proc/{number}/stat")).unwrap_or_default();
        let after = stat.rsplit_once(") ").map_or("", |(_, after)| after);
        let mut words = after.split(' ');
        words.next() != Some("Z") && words.next() == Some(parent.to_string().as_str())
    };
    numbers.filter(is_child).collect()
}
