//! Snapshots: when to save one, into which file, and how to continue from one.

use std::path::{Path, PathBuf};

use clap::Args;
use cosim::{Error, Result, Snapshot, Step, System, Time};

use super::output::file_name;
use super::values;

#[derive(Args)]
pub(crate) struct Snapshots {
    /// Save the state of the whole system at multiples of this (at the next output instant)
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds)]
    snapshot_every: Option<f64>,
    /// Save the state at this time (repeatable)
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds, allow_negative_numbers = true)]
    snapshot_at: Vec<f64>,
    /// The snapshot file, which is replaced by the newest snapshot; {t} in it stands for the time
    /// (default: NAME.snapshot)
    #[arg(long, value_name = "FILE")]
    snapshot_file: Option<PathBuf>,
    /// Continue from this snapshot; existing results are continued
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,
}

impl Snapshots {
    /// The times, if any.
    pub(crate) fn wanted(&self) -> Result<Option<(Option<Time>, Vec<Time>)>> {
        if self.snapshot_every.is_none() && self.snapshot_at.is_empty() {
            return Ok(None);
        }
        let every =
            self.snapshot_every.map(|s| cosim::time::step_from_seconds(s, "--snapshot-every"));
        let at = self.snapshot_at.iter().map(|s| cosim::time::from_seconds(*s, "--snapshot-at"));
        Ok(Some((every.transpose()?.map(Step::rounded), at.collect::<Result<_>>()?)))
    }

    /// The snapshot to continue from: it must belong to this system.
    pub(crate) fn resumed(&self, system: &System) -> Result<Option<Snapshot>> {
        let Some(file) = &self.resume else {
            return Ok(None);
        };
        let snapshot = Snapshot::read(file)?;
        snapshot.check(system).map_err(|error| Error::at(error, file))?;
        Ok(Some(snapshot))
    }

    /// What is resumed.
    pub(crate) fn file(&self) -> Option<&Path> {
        self.resume.as_deref()
    }

    /// Where snapshots go; `{t}` in it stands for the time.
    pub(crate) fn target(&self, system: &System) -> PathBuf {
        let default = || PathBuf::from(format!("{}.snapshot", file_name(system.name())));
        self.snapshot_file.clone().unwrap_or_else(default)
    }

    pub(crate) fn write(&self, system: &System, snapshot: &Snapshot) -> Result<()> {
        let file = self.target(system);
        let time = snapshot.time().seconds().to_string();
        snapshot.write(file.to_string_lossy().replace("{t}", &time))
    }
}
