//! Where results go, and running with a recorder and progress.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use cosim::distributed::Cluster;
use cosim::observe::{CsvRecorder, Progress, Stop};
use cosim::{Code, Error, Observer, Overrides, Result, Run, Summary, System};

use super::interrupt::Interrupt;
use super::messages;

#[derive(Args)]
pub(crate) struct Output {
    /// Record this variable; * and ? make a pattern (repeatable; default: all outputs)
    #[arg(long, value_name = "NAME")]
    output_variable: Vec<String>,
    /// Seconds between recorded samples (default: the smallest step)
    #[arg(long, value_name = "SECONDS", value_parser = super::values::seconds)]
    output_interval: Option<f64>,
    /// Write the results there, - for stdout (default: NAME_out.csv)
    #[arg(long, short, value_name = "FILE")]
    output_file: Option<PathBuf>,
    /// Write the results as NAME_out.csv into this folder, which is made if missing
    #[arg(long, value_name = "FOLDER", conflicts_with = "output_file")]
    output_dir: Option<PathBuf>,
    /// No progress and no summary
    #[arg(long, short)]
    quiet: bool,
}

impl Output {
    /// What of this is decided when the system is made.
    pub(crate) fn add_to(&self, overrides: Overrides) -> Overrides {
        let overrides = overrides.output_variables(&self.output_variable);
        match self.output_interval {
            Some(seconds) => overrides.output_interval(seconds),
            None => overrides,
        }
    }

    /// Runs `system` and writes what it records.
    pub(crate) fn run(&self, system: &System, cluster: Option<&Cluster>) -> Result<()> {
        messages::findings(system, self.quiet);
        let target = self.target(system.name())?;
        if target == Path::new("-") {
            let recorder = CsvRecorder::new(io::BufWriter::new(io::stdout().lock()), "stdout");
            return self.observe(system, cluster, recorder, "stdout");
        }
        let recorder = CsvRecorder::create(&target)?;
        self.observe(system, cluster, recorder, &target.display().to_string())
    }

    fn observe(
        &self,
        system: &System,
        cluster: Option<&Cluster>,
        mut recorder: impl Observer,
        target: &str,
    ) -> Result<()> {
        let begun = std::time::Instant::now();
        let mut progress = Progress::new();
        let mut interrupt = Interrupt::new();
        let mut observers: Vec<&mut dyn Observer> = vec![&mut recorder, &mut interrupt];
        if !self.quiet {
            observers.push(&mut progress);
        }
        let run = observers.iter_mut().fold(Run::new(system), |run, one| run.observe(*one));
        let outcome = match cluster {
            Some(cluster) => cluster.go(system, run),
            None => run.go(),
        };
        let summary = outcome.map_err(|e| match e.code() {
            Code::Fmu => e.maybe_help(Some(format!("the results until then are in {target}"))),
            _ => e,
        })?;
        for warning in &summary.warnings {
            messages::warning(warning);
        }
        if !self.quiet && summary.stopped != Some(Stop::ReaderGone) {
            summary.notes.iter().for_each(|note| messages::note(note));
            summary.messages.iter().for_each(|message| messages::tell(message));
            messages::tell(&told(system, &summary, begun.elapsed().as_secs_f64(), target));
        }
        match summary.stopped {
            Some(Stop::Interrupted) => {
                Err(Error::new(Code::Interrupted, "the run was interrupted")
                    .why(format!("at {} s after its start", summary.simulated))
                    .help(format!("the results until then are in {target}")))
            }
            _ => Ok(()),
        }
    }

    fn target(&self, name: &str) -> Result<PathBuf> {
        let file = format!("{}_out.csv", name.replace(['/', '\\', '\0'], "_"));
        match (&self.output_file, &self.output_dir) {
            (Some(file), _) => Ok(file.clone()),
            (None, None) => Ok(PathBuf::from(file)),
            (None, Some(folder)) => {
                std::fs::create_dir_all(folder).map_err(|e| {
                    Error::new(Code::Output, "the folder cannot be made").at(folder).why(e)
                })?;
                Ok(folder.join(file))
            }
        }
    }
}

/// What a run did, in one line.
fn told(system: &System, summary: &Summary, spent: f64, target: &str) -> String {
    format!(
        "{}: {} s simulated in {spent:.3} s ({:.0} x real time, {} steps); results in {target}",
        system.name(),
        summary.simulated,
        summary.simulated / spent.max(1e-9),
        summary.steps,
    )
}

/// Prints to stdout; a closed pipe (`| head`) ends quietly.
pub(crate) fn print(text: &str) -> Result<()> {
    match writeln!(io::stdout(), "{text}") {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::new(Code::Output, "stdout cannot be written").why(e))
        }
        _ => Ok(()),
    }
}
