//! `cosim convert`: a system in another format.

use std::path::PathBuf;

use clap::Args;
use cosim::{Result, System};

use super::changes::Changes;
use super::messages;

/// Write a system in another format: .ssd, .ssp, .xml (OSP) or a folder (OSP with its FMUs)
#[derive(Args)]
pub(crate) struct Convert {
    /// A .ssd, .ssp or OspSystemStructure.xml file, or the folder of the last
    from: PathBuf,
    /// What is written; its ending says how, without one it is an OSP folder
    to: PathBuf,
    #[command(flatten)]
    changes: Changes,
    /// No messages but errors
    #[arg(short, long)]
    quiet: bool,
}

impl Convert {
    pub(crate) fn run(self) -> Result<()> {
        let system = System::load(&self.from, &self.changes.overrides())?;
        messages::findings(&system, self.quiet);
        let notes = system.write(&self.to)?;
        if !self.quiet {
            notes.iter().for_each(|text| messages::note(text));
            messages::tell(&format!("written: {}", self.to.display()));
        }
        Ok(())
    }
}
