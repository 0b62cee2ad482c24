//! `cosim info`: describes an FMU or a system.

mod fmu;
mod system;

use std::path::PathBuf;

use clap::Args;
use cosim::fmi::Fmu;
use cosim::{Overrides, Result, System};

use super::output::{print, print_lines};
use super::{Format, messages};

/// Show the contents of an FMU or a system; a system is checked as by validate
#[derive(Args)]
pub(crate) struct Info {
    /// A .fmu, .ssd, .ssp or OspSystemStructure.xml file, or the folder of the latter
    file: PathBuf,
    /// Output format
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

impl Info {
    pub(crate) fn run(self) -> Result<()> {
        if System::is_system(&self.file) {
            let system = System::load(&self.file, &Overrides::new())?;
            messages::findings(&system, false);
            return match self.format {
                Format::Text => print_lines(&system::text(&system)),
                Format::Json => print(&system::json(&system).to_string()),
            };
        }
        let fmu = Fmu::open(&self.file)?;
        match self.format {
            Format::Text => print_lines(&fmu::text(&fmu)),
            Format::Json => print(&fmu::json(&fmu).to_string()),
        }
    }
}
