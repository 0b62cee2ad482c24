//! `cosim run`: a system.

use std::path::PathBuf;

use clap::Args;
use cosim::{Result, System};

use super::changes::Changes;
use super::interrupt;
use super::logging::Logging;
use super::output::Output;

/// Run a system: SSP (.ssd, .ssp) or OSP (OspSystemStructure.xml or its folder)
#[derive(Args)]
pub(crate) struct Run {
    /// The system
    file: PathBuf,
    #[command(flatten)]
    changes: Changes,
    #[command(flatten)]
    logging: Logging,
    #[command(flatten)]
    output: Output,
}

impl Run {
    pub(crate) fn run(self) -> Result<()> {
        interrupt::listen();
        let overrides = self.logging.add_to(self.output.add_to(self.changes.overrides()))?;
        self.output.run(&System::load(&self.file, &overrides)?)
    }
}
