//! `cosim run`: a system.

use std::path::PathBuf;

use clap::Args;
use cosim::{Result, System};

use super::changes::Changes;
use super::distributed::Distributed;
use super::interrupt;
use super::logging::Logging;
use super::output::Output;
use super::problems;

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
    #[command(flatten)]
    distributed: Distributed,
}

impl Run {
    /// Whether others may dial by TLS.
    pub(crate) fn may_use_tls(&self) -> bool {
        self.distributed.may_use_tls()
    }

    pub(crate) fn run(self) -> Result<()> {
        interrupt::listen();
        problems::told(self.output.format, self.computed())
    }

    fn computed(&self) -> Result<()> {
        let overrides = self.logging.add_to(self.output.add_to(self.changes.overrides()))?;
        let system = System::load(&self.file, &overrides)?;
        system.ready()?;
        let cluster = self.distributed.cluster(self.output.quiet)?;
        self.output.run(&system, cluster.as_ref())
    }
}
