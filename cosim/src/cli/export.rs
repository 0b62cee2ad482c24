//! `cosim export`: exports a system as one FMU.

use std::path::PathBuf;

use clap::Args;
use cosim::export::Export as Exporter;
use cosim::{Result, System};

use super::changes::Changes;
use super::{interrupt, messages};

/// Write a whole system as one FMU for co-simulation, with its FMUs and the master inside
#[derive(Args)]
pub(crate) struct Export {
    /// A .ssd, .ssp or OspSystemStructure.xml file, or the folder of the latter
    system: PathBuf,
    /// Output FMU; an existing file is replaced
    #[arg(long, short, value_name = "FILE.fmu")]
    output: PathBuf,
    /// Show only this variable; * and ? match parts of names (repeatable; default: all outputs, all
    /// parameters, and all unconnected inputs)
    #[arg(long, value_name = "NAME")]
    expose: Vec<String>,
    /// Do not show this variable; * and ? match parts of names (repeatable)
    #[arg(long, value_name = "NAME")]
    hide: Vec<String>,
    /// Name of the model (default: name of the system)
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// The library that runs the system in the FMU, one for each platform (repeatable; default:
    /// $COSIM_SYSTEM_LIBRARY, or libcosim_system.so beside this program or in ../lib/cosim)
    #[arg(long, value_name = "FILE.so")]
    library: Vec<PathBuf>,
    /// Apply the faults and changes of this file (TOML, or JSON of OSP) in the FMU
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
    #[command(flatten)]
    changes: Changes,
    /// Show errors only
    #[arg(short, long)]
    quiet: bool,
}

impl Export {
    pub(crate) fn run(self) -> Result<()> {
        interrupt::watch();
        let system = System::load(&self.system, &self.changes.overrides())?;
        messages::findings(&system, self.quiet);
        let mut exporter = self.expose.iter().fold(Exporter::new(), Exporter::expose);
        exporter = self.hide.iter().fold(exporter, Exporter::hide);
        exporter = self.library.iter().fold(exporter, Exporter::library);
        exporter = self.scenario.iter().fold(exporter, Exporter::scenario);
        if let Some(name) = &self.name {
            exporter = exporter.name(name);
        }
        let notes = exporter.write(&system, &self.output)?;
        if !self.quiet {
            notes.iter().for_each(|text| messages::note(text));
            messages::info(&format!("written: {}", self.output.display()));
        }
        Ok(())
    }
}
