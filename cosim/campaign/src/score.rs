//! Figures of merit of existing results.

use std::path::Path;

use super::figure::Figure;
use super::file::read_figures;
use cosim_base::error::{Code, Error, Result};
use cosim_core::observe::Recording;
use cosim_core::table::Document;

/// Figures of a file.
#[derive(Debug)]
pub struct Figures(Vec<(String, Figure)>);

impl Figures {
    /// Reads `[figures]` of a TOML file, such as that of a campaign.
    pub fn read(file: impl AsRef<Path>) -> Result<Self> {
        let file = file.as_ref();
        let text = cosim_base::files::read_input_text(file)
            .map_err(|e| Error::new(Code::File, "the figures cannot be read").at(file).why(e))?;
        let document = Document::new(&text, file, Code::Campaign);
        let parsed = document.parse()?;
        let figures = read_figures(&document.root(&parsed));
        document.finish()?;
        if figures.is_empty() {
            return Err(Error::new(Code::Campaign, "[figures] is missing").at(file));
        }
        Ok(Self(figures))
    }

    /// Their names.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|(name, _)| name.as_str())
    }

    /// Their values, in the order of the names; NaN if the results have none. Figures of a part
    /// before, during or after faults have none: results do not say when the faults were.
    pub fn of(&self, results: &Recording) -> Result<Vec<f64>> {
        self.0.iter().map(|(_, figure)| figure.compute(results, None)).collect()
    }
}
