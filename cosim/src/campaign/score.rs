//! Figures of merit of results that exist already.

use std::path::Path;

use super::figure::Figure;
use super::file::read_figures;
use crate::error::{Code, Error, Result};
use crate::observe::Recording;
use crate::table::Document;

/// Figures of a file.
#[derive(Debug)]
pub struct Figures(Vec<(String, Figure)>);

impl Figures {
    /// Reads `[figures]` of a TOML file; that of a campaign will do.
    pub fn read(file: impl AsRef<Path>) -> Result<Self> {
        let file = file.as_ref();
        let text = std::fs::read_to_string(file)
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

    /// Their values, in the order of the names; NaN where the results have none. Figures of a part
    /// before, during or after faults have none: results do not say when those were.
    pub fn of(&self, results: &Recording) -> Result<Vec<f64>> {
        self.0.iter().map(|(_, figure)| figure.compute(results, None)).collect()
    }
}
