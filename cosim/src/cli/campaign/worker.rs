//! A process that makes runs of a campaign, one after another, for the process that stores them.

use std::io::BufRead;
use std::path::PathBuf;

use clap::Args;
use cosim::campaign::{Bench, Campaign, fingerprint};
use cosim::confine::kill_started;
use cosim::scripted::is_host;
use cosim::texts::Scope;
use cosim::{Code, Error, Result};
use rustix::process::Signal;

use crate::cli::{interrupt, standard};

/// Make the runs whose numbers arrive on stdin, one per line; write their rows to stdout
#[derive(Args)]
pub(crate) struct CampaignWorker {
    /// The campaign
    file: PathBuf,
    /// Its expected identity
    #[arg(long)]
    identity: String,
}

impl CampaignWorker {
    pub(crate) fn run(self) -> Result<()> {
        let broken = |e: std::io::Error| Error::new(Code::Output, "a row cannot be written").why(e);
        // Output of FMUs must not appear between the rows.
        standard::keep_apart()?;
        interrupt::watch();
        interrupt::end_with_parent(Signal::TERM)?;
        let mut rows = standard::out();
        let bench = Bench::open(Campaign::read(&self.file)?)?;
        if fingerprint(&bench.identity()?) != self.identity {
            return Err(Error::new(
                Code::Campaign,
                "the campaign has changed while it was running",
            )
            .at(&self.file));
        }
        for line in std::io::stdin().lock().lines() {
            let line = line.map_err(broken)?;
            let run = line.trim().parse().map_err(|e| {
                Error::new(Code::Usage, format!("'{line}' is not the number of a run")).why(e)
            })?;
            let _texts = Scope::begin();
            let mut row = serde_json::to_vec(&bench.run(run)).unwrap_or_default();
            row.push(b'\n');
            // What FMUs started ends with the run, before its row counts; a process that serves a
            // class forks for each run.
            kill_started(&is_host);
            rows.write_all(&row).map_err(broken)?;
        }
        Ok(())
    }
}
