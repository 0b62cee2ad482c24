//! `cosim run`: runs a system.

use std::path::PathBuf;

use clap::Args;
use cosim::{Code, Error, Result, System};

use super::changes::Changes;
use super::distributed::Distributed;
use super::interrupt;
use super::isolate::{self, Isolation};
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
    #[command(flatten)]
    isolation: Isolation,
}

impl Run {
    /// Whether workers may connect with TLS.
    #[cfg(feature = "distributed")]
    pub(crate) fn may_use_tls(&self) -> bool {
        self.distributed.may_use_tls()
    }

    pub(crate) fn run(self) -> Result<u8> {
        interrupt::begin();
        problems::reported(self.output.format, self.computed())
    }

    fn computed(&self) -> Result<u8> {
        self.isolation.check(self.distributed.starts_workers())?;
        let overrides = self.output.add_to(self.changes.overrides());
        let overrides = match self.isolation.wanted() {
            true => overrides,
            false => self.logging.add_to(overrides)?,
        };
        let system = System::load(&self.file, &overrides)?;
        system.ready()?;
        // Files named here by the user, not by the system's file.
        let readable = self.changes.files().chain(self.isolation.readable());
        let cluster = self.distributed.cluster(self.output.quiet, readable)?;
        if self.isolation.wanted() && cluster.is_some() {
            return Err(Error::new(Code::Usage, "--isolate is for runs in this process")
                .help("workers confine their FMUs anyway, unless started with --no-confine"));
        }
        if self.isolation.wanted() {
            self.output.unwatched()?;
            let written = self.output.written(&system, self.logging.file())?;
            return isolate::supervise(written, self.changes.starts_tools());
        }
        self.logging.begin()?;
        match &cluster {
            Some(_) => interrupt::be_patient(),
            None => interrupt::watch(),
        }
        let shut = || self.isolation.shut(self.changes.starts_tools());
        self.output.run(&system, cluster.as_ref(), &shut).map(|()| 0)
    }
}
