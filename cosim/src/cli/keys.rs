//! `cosim keys`: certificates for runs between machines.

use std::path::PathBuf;

use clap::Args;
use cosim::Result;
use cosim::distributed::Authority;

/// Make an authority and certificates for runs between machines
#[derive(Args)]
pub(crate) struct Keys {
    /// The folder to make; what is there is never overwritten
    folder: PathBuf,
    /// Name of a worker (repeatable; default: worker-1 to worker-3)
    #[arg(long, value_name = "NAME")]
    worker: Vec<String>,
    /// Name of an observer, who may only read telemetry (repeatable; default: observer)
    #[arg(long, value_name = "NAME")]
    observer: Vec<String>,
    /// Name or address by which the machine of the run is dialled (repeatable)
    #[arg(long, value_name = "HOST")]
    host: Vec<String>,
    /// How long the certificates are valid
    #[arg(long, default_value_t = 365, value_parser = clap::value_parser!(u32).range(1..=36500))]
    days: u32,
}

impl Keys {
    pub(crate) fn run(self) -> Result<()> {
        let or = |names: Vec<String>, default: &[&str]| match names.is_empty() {
            true => default.iter().map(|name| (*name).to_owned()).collect(),
            false => names,
        };
        let authority = Authority {
            folder: self.folder,
            workers: or(self.worker, &["worker-1", "worker-2", "worker-3"]),
            observers: or(self.observer, &["observer"]),
            hosts: self.host,
            days: self.days,
        };
        for folder in authority.make()? {
            super::output::print(&folder.display().to_string())?;
        }
        Ok(())
    }
}
