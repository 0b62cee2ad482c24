//! In place of `distributed` in a program without that feature: no workers, and no options for them.

use clap::Args;
use cosim::{Result, Run, Summary, System};

/// The options for workers: none.
#[derive(Args)]
pub(crate) struct Distributed {}

impl Distributed {
    pub(crate) fn starts_workers(&self) -> bool {
        false
    }

    pub(crate) fn cluster(
        &self,
        _quiet: bool,
        _readable: impl Iterator<Item = String>,
    ) -> Result<Option<Cluster>> {
        Ok(None)
    }
}

/// There is none.
pub(crate) enum Cluster {}

impl Cluster {
    pub(crate) fn go(&self, _: &System, _: Run<'_>) -> Result<Summary> {
        match *self {}
    }
}
