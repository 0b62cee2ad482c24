//! `cosim replay`: repeats a run of a campaign and records everything.

use std::path::PathBuf;

use clap::Args;
use cosim::campaign::{Bench, Campaign, Folder, Status};
use cosim::{Code, Error, Result, observe};

use super::interrupt;
use super::messages;

/// Repeat a run of a campaign, record everything, and prove that it is the same
#[derive(Args)]
pub(crate) struct Replay {
    /// The results folder of the campaign
    folder: PathBuf,
    /// The number of the run
    run: u64,
    /// Output file for the results: CSV, MCAP or Parquet, by the extension .csv, .mcap or .parquet
    /// (default: runN.csv)
    #[arg(long, short, value_name = "FILE")]
    output_file: Option<PathBuf>,
    /// Record this variable; * and ? match parts of names (repeatable; default: all)
    #[arg(long, value_name = "NAME", default_value = "*")]
    output_variable: Vec<String>,
}

impl Replay {
    pub(crate) fn run(self) -> Result<()> {
        interrupt::watch();
        let bench = Bench::open(Campaign::read(Folder::campaign(&self.folder)?)?)?;
        let row = Folder::row(&self.folder, self.run, &bench.identity()?)?;
        let target =
            self.output_file.unwrap_or_else(|| PathBuf::from(format!("run{}.csv", self.run)));
        let mut results = observe::create(&target)?;
        let again = bench.replay(self.run, &self.output_variable, &mut *results);
        if again.status == Status::Failed {
            let what = format!("run {} fails", self.run);
            let same = row.status == Status::Failed && row.reason == again.reason;
            let before = if same { "as before" } else { "not as before" };
            return Err(Error::new(Code::Fmu, what)
                .why(again.reason)
                .help(format!("{before}; the results until then are in {}", target.display())));
        }
        if again.digest != row.digest || again.figures != row.figures {
            let before = if row.digest.is_empty() {
                format!("it was {}: {}", row.status.word(), row.reason)
            } else {
                format!("the digest was {} and is now {}", row.digest, again.digest)
            };
            return Err(Error::new(
                Code::Parted,
                format!("run {} gives a different result", self.run),
            )
            .why(before)
            .help(format!("the results are in {}", target.display())));
        }
        messages::info(&format!(
            "run {}: the same to the last bit ({}); the results are in {}",
            self.run,
            row.digest,
            target.display()
        ));
        Ok(())
    }
}
