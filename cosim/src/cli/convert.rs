//! `cosim convert`: writes a system or results in another format.

use std::path::{Path, PathBuf};

use clap::Args;
use cosim::observe;
use cosim::observe::Trajectories;
use cosim::roles::Declaration;
use cosim::{Code, Error, Result, System, files};

use super::changes::Changes;
use super::messages;

/// Write a system or results in another format
///
/// A system is written as .ssd, .ssp, .xml (OSP) or a folder (OSP with its FMUs). Results are
/// written as .csv, .mcap or .parquet; the paths in them as .tum or .kitti, one file for each; a
/// layout for Foxglove as .json.
#[derive(Args)]
pub(crate) struct Convert {
    /// A .ssd, .ssp or OspSystemStructure.xml file, or the folder of the latter; or results
    from: PathBuf,
    /// Output file; its extension determines the format, without one it is an OSP folder
    to: PathBuf,
    /// For results: a file that assigns variables to the truth, its estimates and sensors (default:
    /// by the names of the variables)
    #[arg(long, value_name = "FILE")]
    roles: Option<PathBuf>,
    #[command(flatten)]
    changes: Changes,
    /// Show errors only
    #[arg(short, long)]
    quiet: bool,
}

impl Convert {
    pub(crate) fn run(self) -> Result<()> {
        if observe::is_results(&self.from) {
            return self.results();
        }
        if self.roles.is_some() {
            return Err(Error::new(Code::Usage, "--roles is for results, and a system is given")
                .at(&self.from));
        }
        let system = System::load(&self.from, &self.changes.overrides())?;
        messages::findings(&system, self.quiet);
        let notes = system.write(&self.to)?;
        if !self.quiet {
            notes.iter().for_each(|text| messages::note(text));
        }
        self.written(&self.to);
        Ok(())
    }

    fn written(&self, file: &Path) {
        if !self.quiet {
            messages::info(&format!("written: {}", file.display()));
        }
    }

    fn results(&self) -> Result<()> {
        let ending = self.to.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let roles = self.roles.as_ref().map(Declaration::read).transpose()?;
        let recording = cosim::observe::read(&self.from)?;
        files::refuse_inputs(&self.to, [])?;
        let trajectories = |format| -> Result<()> {
            for (name, text) in observe::trajectories(&recording, roles.as_ref(), format)? {
                let stem = self.to.file_stem().unwrap_or_default().to_string_lossy();
                self.write(&self.to.with_file_name(format!("{stem}_{name}.{ending}")), &text)?;
            }
            Ok(())
        };
        match ending.as_str() {
            "tum" => trajectories(Trajectories::Tum),
            "kitti" => trajectories(Trajectories::Kitti),
            "json" => self.write(&self.to, &observe::foxglove_layout(&recording, roles.as_ref())?),
            "csv" | "mcap" | "parquet" => {
                let name = self.from.file_stem().unwrap_or_default().to_string_lossy();
                let mut recorder = observe::create_with(&self.to, roles)?;
                observe::replay(&recording, &name, &mut *recorder)?;
                self.written(&self.to);
                Ok(())
            }
            _ => Err(Error::new(Code::Usage, format!("results cannot be written as '.{ending}'"))
                .at(&self.to)
                .help("use a name that ends in .csv, .mcap, .parquet, .tum, .kitti or .json")),
        }
    }

    fn write(&self, file: &Path, text: &str) -> Result<()> {
        files::replace(file, text.as_bytes())
            .map_err(|e| Error::new(Code::Output, "the file cannot be written").at(file).why(e))?;
        self.written(file);
        Ok(())
    }
}
