//! `cargo xtask soak`: the paper's loop on workers that are killed repeatedly. Every run must give
//! the bytes of the undisturbed one; the times to detect and to recover from losses are reported.
//! With `--campaign`, a campaign that is killed and continues.

mod campaign;

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};

use crate::reproduce::{Case, arguments};
use crate::{package, paths, process};

/// What to kill.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// Number of processes to kill
    #[arg(long, default_value_t = 200)]
    kills: u32,
    /// Workers of each run
    #[arg(long, default_value_t = 3)]
    workers: u32,
    /// First compare every course and filter on 1 to 5 workers, by socket, TCP and TLS
    #[arg(long)]
    courses: bool,
    /// Kill a campaign instead of the workers of runs
    #[arg(long)]
    campaign: bool,
    /// Seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Kills until the number is reached; fails at the first byte that differs.
pub(crate) fn run(options: &Options) -> Result<()> {
    package::for_this_machine()?;
    process::run(&mut process::build_workspace())?;
    let folder = paths::target().join("soak");
    fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let soak = Soak { program: paths::target().join("release/cosim"), folder };
    let mut dice = Dice(options.seed);
    if options.campaign {
        return soak.campaign(options.kills, &mut dice);
    }
    if options.courses {
        soak.courses()?;
    }
    let first = Case::all(1).into_iter().next();
    let case = first.context("there is no course")?;
    let here = soak.undisturbed(&case)?;
    let (mut all, begun) = (Kills::default(), Instant::now());
    while all.killed < options.kills {
        soak.disturbed(&case, options, &mut dice, &here, &mut all)?;
        println!("{} killed, {} resumed, every byte the same", all.killed, all.resumed.len());
    }
    println!("{} kills in {:.0} s", all.killed, begun.elapsed().as_secs_f64());
    println!("killed to noticed: {}", spread(&mut all.noticed));
    println!("lost to resumed: {}", spread(&mut all.resumed));
    Ok(())
}

/// The kills, and the milliseconds that recovery took.
#[derive(Default)]
struct Kills {
    killed: u32,
    /// From a kill until the run reports a loss.
    noticed: Vec<f64>,
    /// From there until it continues, as reported by the run.
    resumed: Vec<f64>,
}

fn spread(took: &mut [f64]) -> String {
    took.sort_by(f64::total_cmp);
    let at = |part: f64| took.get((part * took.len() as f64) as usize).or(took.last());
    let [half, most, worst] = [0.5, 0.95, 1.0].map(|p| at(p).copied().unwrap_or(f64::NAN));
    format!("{half:.0} ms (median), {most:.0} ms (95 %), {worst:.0} ms (worst)")
}

struct Soak {
    program: PathBuf,
    folder: PathBuf,
}

impl Soak {
    fn command(&self, case: &Case, results: &Path, more: &[String]) -> Result<Command> {
        let mut command = Command::new(&self.program);
        let arguments = arguments(case)?;
        command.args(arguments.iter().flat_map(|(option, value)| [option, value]));
        command.arg("-o").arg(results).args(more);
        command.current_dir(paths::root()).env("NO_COLOR", "1");
        Ok(command)
    }

    /// The bytes of a run in one process.
    fn undisturbed(&self, case: &Case) -> Result<Vec<u8>> {
        let file = self.folder.join("here.csv");
        let status = self.command(case, &file, &["-q".to_owned()])?.status()?;
        ensure!(status.success(), "the run in one process ended with {status}");
        Ok(fs::read(file)?)
    }

    /// Every course and filter on 1 to 5 workers.
    fn courses(&self) -> Result<()> {
        let keys = self.folder.join("keys");
        if !keys.exists() {
            let mut command = Command::new(&self.program);
            let workers = (1..=5).map(|number| format!("--worker=worker-{number}"));
            process::run(command.arg("keys").arg(&keys).args(workers))?;
        }
        for case in Case::all(1).into_iter().filter(Case::is_in_paper) {
            let here = self.undisturbed(&case)?;
            for workers in 1..=5 {
                for (transport, keys) in [("unix", None), ("tcp", None), ("tls", Some(&*keys))] {
                    let there = self.distributed(&case, workers, transport, keys)?;
                    ensure!(there == here, "{case}, {workers} workers, {transport}: other bytes");
                }
            }
            println!("{case}: the same bytes with 1 to 5 workers by Unix socket, TCP and TLS");
        }
        Ok(())
    }

    /// The bytes of a run on its own workers, or with keys on separate workers.
    fn distributed(
        &self,
        case: &Case,
        workers: u32,
        transport: &str,
        keys: Option<&Path>,
    ) -> Result<Vec<u8>> {
        let port = std::net::TcpListener::bind("127.0.0.1:0")?.local_addr()?.port();
        let endpoint = format!("{transport}/127.0.0.1:{port}");
        let mut more = vec!["-q".to_owned()];
        if transport != "unix" {
            more.push(format!("--listen={endpoint}"));
        }
        let mut lent = Vec::new();
        if let Some(keys) = keys {
            more.extend(["--distributed".to_owned(), format!("--min-workers={workers}")]);
            more.push(format!("--credentials={}", keys.join("orchestrator").display()));
            for number in 1..=workers {
                let name = format!("worker-{number}");
                let mut worker = Command::new(&self.program);
                worker.args(["worker", "--allow-upload", "--connect", &endpoint, "--name", &name]);
                worker.arg("--credentials").arg(keys.join(&name)).stderr(Stdio::null());
                lent.push(worker.spawn()?);
            }
        } else {
            more.push(format!("--workers={workers}"));
        }
        let file = self.folder.join("there.csv");
        let status = self.command(case, &file, &more)?.status();
        for mut worker in lent {
            worker.kill()?;
            worker.wait()?;
        }
        ensure!(status?.success(), "{case}, {workers} workers by {transport}: it failed");
        Ok(fs::read(&file)?)
    }

    /// One run whose processes are killed, one after the other: the next when the previous loss was
    /// detected.
    fn disturbed(
        &self,
        case: &Case,
        options: &Options,
        dice: &mut Dice,
        here: &[u8],
        all: &mut Kills,
    ) -> Result<()> {
        let there = self.folder.join("there.csv");
        let more = [format!("--workers={}", options.workers), "--format=json".to_owned()];
        let mut command = self.command(case, &there, &more)?;
        let mut run = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
        let losses = losses(&mut run)?;
        while run.try_wait()?.is_none() {
            // More often, and a run would only restart.
            std::thread::sleep(Duration::from_millis(100 + dice.below(800)));
            let victims = victims(&run, dice.below(5) == 0);
            if let Some(&victim) = victims.get(dice.below(victims.len() as u64) as usize) {
                all.kill(victim, &losses)?;
            }
        }
        let (output, killed) = (run.wait_with_output()?, all.killed);
        ensure!(output.status.success(), "after {killed} kills: {}", output.status);
        ensure!(fs::read(&there)? == here, "after {killed} kills the results have other bytes");
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout)?;
        let notes = summary["notes"].as_array().into_iter().flatten();
        all.resumed.extend(notes.filter_map(|note| {
            let took = note.as_str()?.rsplit("after ").next()?.strip_suffix(" ms")?;
            took.parse::<f64>().ok()
        }));
        Ok(())
    }
}

/// How long a loss may go undetected before the soak continues without it.
const UNNOTICED: Duration = Duration::from_secs(2);

impl Kills {
    fn kill(&mut self, victim: u32, losses: &Receiver<Instant>) -> Result<()> {
        // A worker without a process of its own computes nothing, so its loss has no effect.
        let idle = is_worker(victim) && children(victim).is_empty();
        // One loss of several groups may be reported several times.
        losses.try_iter().for_each(drop);
        let begun = Instant::now();
        let kill = Command::new("kill").args(["-KILL", &victim.to_string()]).status()?;
        self.killed += u32::from(kill.success());
        if kill.success()
            && !idle
            && let Ok(heard) = losses.recv_timeout(UNNOTICED)
        {
            self.noticed.push(heard.duration_since(begun).as_secs_f64() * 1e3);
        }
        Ok(())
    }
}

fn is_worker(process: u32) -> bool {
    let arguments = fs::read(format!("/proc/{process}/cmdline")).unwrap_or_default();
    arguments.split(|byte| *byte == 0).nth(1) == Some(b"worker")
}

/// When a run reports a loss.
fn losses(run: &mut Child) -> Result<Receiver<Instant>> {
    let stderr = run.stderr.take().context("the run has no stderr")?;
    let (heard, losses) = channel();
    std::thread::spawn(move || {
        for line in BufReader::new(stderr).lines().map_while(Result::ok) {
            // Those at the end also say how it continued.
            if line.contains(": lost at ") && !line.contains("; went on") {
                // The run may have ended in the meantime.
                let _ = heard.send(Instant::now());
            }
        }
    });
    Ok(losses)
}

/// The workers of a run, or the processes with its components.
fn victims(run: &Child, workers: bool) -> Vec<u32> {
    let own = children(run.id());
    if workers { own } else { own.into_iter().flat_map(children).collect() }
}

/// The processes whose parent is `parent`.
fn children(parent: u32) -> Vec<u32> {
    let all = fs::read_dir("/proc").into_iter().flatten().flatten();
    let numbers = all.filter_map(|entry| entry.file_name().to_str()?.parse::<u32>().ok());
    let is_child = |number: &u32| {
        let stat = fs::read_to_string(format!("/proc/{number}/stat")).unwrap_or_default();
        // After the name, which may contain brackets: the state and the parent.
        let after = stat.rsplit_once(") ").map_or("", |(_, after)| after);
        let mut words = after.split(' ');
        words.next() != Some("Z") && words.next() == Some(parent.to_string().as_str())
    };
    numbers.filter(is_child).collect()
}

/// Repeatable random numbers.
struct Dice(u64);

impl Dice {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % limit.max(1)
    }
}
