//! `cosim keys`: certificates for runs across machines, and signatures of files.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use cosim::distributed::Authority;
use cosim::{Result, signature};

use super::output::print;

/// Make an authority and certificates for runs across machines; sign files
#[derive(Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(crate) struct Keys {
    #[command(subcommand)]
    signatures: Option<Signatures>,
    /// The folder to create; existing files are never overwritten
    #[arg(required = true)]
    folder: Option<PathBuf>,
    /// Name of a worker (repeatable; default: worker-1 to worker-3)
    #[arg(long, value_name = "NAME")]
    worker: Vec<String>,
    /// Name of an observer, which may only read telemetry (repeatable; default: observer)
    #[arg(long, value_name = "NAME")]
    observer: Vec<String>,
    /// Host name or address by which workers reach the machine of the run (repeatable)
    #[arg(long, value_name = "HOST")]
    host: Vec<String>,
    /// Validity of the certificates, in days
    #[arg(long, default_value_t = 365, value_parser = clap::value_parser!(u32).range(1..=36500))]
    days: u32,
}

#[derive(Subcommand)]
enum Signatures {
    /// Make a key pair for signatures: NAME.key, which stays secret, and NAME.pub
    Pair {
        /// The names of both files without their extensions
        name: PathBuf,
    },
    /// Sign files: writes FILE.sig beside each, for `cosim validate --verify-signature`
    Sign {
        /// The secret key (Ed25519, PKCS#8 in PEM format)
        #[arg(long, value_name = "NAME.key")]
        key: PathBuf,
        /// The files to sign
        #[arg(required = true, value_name = "FILE")]
        files: Vec<PathBuf>,
    },
}

impl Signatures {
    fn run(self) -> Result<()> {
        let written = match self {
            Signatures::Pair { name } => signature::make(&name)?.to_vec(),
            Signatures::Sign { key, files } => {
                files.iter().map(|file| signature::sign(file, &key)).collect::<Result<_>>()?
            }
        };
        written.iter().try_for_each(|path| print(&path.display().to_string()))
    }
}

impl Keys {
    pub(crate) fn run(self) -> Result<()> {
        if let Some(signatures) = self.signatures {
            return signatures.run();
        }
        let or = |names: Vec<String>, default: &[&str]| match names.is_empty() {
            true => default.iter().map(|name| (*name).to_owned()).collect(),
            false => names,
        };
        let authority = Authority {
            // Required without a subcommand.
            folder: self.folder.unwrap_or_default(),
            workers: or(self.worker, &["worker-1", "worker-2", "worker-3"]),
            observers: or(self.observer, &["observer"]),
            hosts: self.host,
            days: self.days,
        };
        for folder in authority.make()? {
            print(&folder.display().to_string())?;
        }
        Ok(())
    }
}
