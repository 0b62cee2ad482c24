//! `cargo xtask soak`: the paper's loop on workers that are killed again and again. Every run must
//! give the bytes of the undisturbed one; how long each loss took is told.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};

use crate::reproduce::{Case, arguments};
use crate::{package, paths, process};

/// What to kill.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// So many processes are killed
    #[arg(long, default_value_t = 200)]
    kills: u32,
    /// Workers of each run
    #[arg(long, default_value_t = 3)]
    workers: u32,
    /// First compare every course and filter on 1 to 5 workers, by socket and by TCP
    #[arg(long)]
    courses: bool,
    /// Where the random numbers begin
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Kills until enough were killed; fails at the first byte that differs.
pub(crate) fn run(options: &Options) -> Result<()> {
    package::for_this_machine()?;
    process::run(&mut process::build_cosim())?;
    let folder = paths::target().join("soak");
    fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let soak = Soak { program: paths::target().join("release/cosim"), folder };
    if options.courses {
        soak.courses()?;
    }
    let first = Case::all(1).into_iter().next();
    let case = first.context("there is no course")?;
    let here = soak.undisturbed(&case)?;
    let mut dice = Dice(options.seed);
    let (mut killed, mut took, begun) = (0, Vec::new(), Instant::now());
    while killed < options.kills {
        let (now, more) = soak.disturbed(&case, options, &mut dice, &here)?;
        killed += now;
        took.extend(more);
        println!("{killed} killed, {} resumed, every byte the same", took.len());
    }
    took.sort_by(f64::total_cmp);
    let at = |part: f64| took.get((part * took.len() as f64) as usize).or(took.last());
    let [half, most, worst] = [0.5, 0.95, 1.0].map(|p| at(p).copied().unwrap_or(f64::NAN));
    println!(
        "{killed} kills in {:.0} s: killed to resumed {half:.0} ms (median), {most:.0} ms (95 %), \
         {worst:.0} ms (worst)",
        begun.elapsed().as_secs_f64()
    );
    Ok(())
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
        let there = self.folder.join("there.csv");
        for case in Case::all(1).into_iter().filter(Case::is_in_paper) {
            let here = self.undisturbed(&case)?;
            for workers in 1..=5 {
                let port = std::net::TcpListener::bind("127.0.0.1:0")?.local_addr()?.port();
                for listen in [None, Some(format!("tcp/127.0.0.1:{port}"))] {
                    let mut more = vec!["-q".to_owned(), format!("--workers={workers}")];
                    more.extend(listen.iter().map(|endpoint| format!("--listen={endpoint}")));
                    let status = self.command(&case, &there, &more)?.status()?;
                    ensure!(status.success(), "{case}, {workers} workers: {status}");
                    let same = fs::read(&there)? == here;
                    ensure!(same, "{case}, {workers} workers, {listen:?}: other bytes");
                }
            }
            println!("{case}: the same bytes with 1 to 5 workers");
        }
        Ok(())
    }

    /// One run whose processes are killed: how many, and the milliseconds that each loss took.
    fn disturbed(
        &self,
        case: &Case,
        options: &Options,
        dice: &mut Dice,
        here: &[u8],
    ) -> Result<(u32, Vec<f64>)> {
        let there = self.folder.join("there.csv");
        let more = [format!("--workers={}", options.workers), "--format=json".to_owned()];
        let mut command = self.command(case, &there, &more)?;
        let mut run = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn()?;
        let mut killed = 0;
        while run.try_wait()?.is_none() {
            // Much more often, and a run would do nothing but begin anew.
            std::thread::sleep(Duration::from_millis(100 + dice.below(800)));
            let victims = victims(&run, dice.below(5) == 0);
            if let Some(victim) = victims.get(dice.below(victims.len() as u64) as usize) {
                let kill = Command::new("kill").args(["-KILL", &victim.to_string()]).status()?;
                killed += u32::from(kill.success());
            }
        }
        let output = run.wait_with_output()?;
        ensure!(output.status.success(), "after {killed} kills: {}", output.status);
        ensure!(fs::read(&there)? == here, "after {killed} kills the results have other bytes");
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout)?;
        let notes = summary["notes"].as_array().into_iter().flatten();
        let took = notes.filter_map(|note| {
            note.as_str()?.rsplit("after ").next()?.strip_suffix(" ms")?.parse().ok()
        });
        Ok((killed, took.collect()))
    }
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
        // After the name, which may have brackets itself: the state and the parent.
        let after = stat.rsplit_once(") ").map_or("", |(_, after)| after);
        let mut words = after.split(' ');
        words.next() != Some("Z") && words.next() == Some(parent.to_string().as_str())
    };
    numbers.filter(is_child).collect()
}

/// Random numbers that can be had again.
struct Dice(u64);

impl Dice {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % limit.max(1)
    }
}
