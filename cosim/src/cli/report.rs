//! `cosim report`: results as a page or a picture.

use std::path::PathBuf;

use clap::Args;
use cosim::report::{Options, Plot, XyPlot, html, svg};
use cosim::{Code, Error, Recording, Result, files};

use super::messages;
use super::output::print;

/// Make a self-contained HTML page, or one picture, of recorded results
#[derive(Args)]
pub(crate) struct Report {
    /// The results: CSV with the time in its first column, or MCAP of this program
    file: PathBuf,
    /// Write the page there, or the figure if the name ends in .svg; - for stdout (default: the
    /// results' name with .html)
    #[arg(long, short, value_name = "FILE")]
    output_file: Option<PathBuf>,
    /// Title of the page (default: the results' name)
    #[arg(long)]
    title: Option<String>,
    /// Plot these columns over time (repeatable; default: all)
    #[arg(long, value_name = "TITLE: COLUMN, ...")]
    plot: Vec<Plot>,
    /// Plot columns against each other (repeatable)
    #[arg(long, value_name = "TITLE: X, Y; ...")]
    xy: Vec<XyPlot>,
}

impl Report {
    pub(crate) fn run(self) -> Result<()> {
        let recording = Recording::read(&self.file)?;
        let stem = || self.file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let title = self.title.unwrap_or_else(stem);
        let options = Options { title, plots: self.plot, paths: self.xy };
        let target = self.output_file.unwrap_or_else(|| self.file.with_extension("html"));
        let picture = target.extension().is_some_and(|ending| ending == "svg");
        let page = if picture { svg(&recording, &options)? } else { html(&recording, &options)? };
        if target.as_os_str() == "-" {
            return print(&page);
        }
        files::refuse_inputs(&target, [self.file.as_path()])?;
        files::replace(&target, page.as_bytes()).map_err(|e| {
            Error::new(Code::Output, "the page cannot be written").at(&target).why(e)
        })?;
        messages::tell(&format!("the report is in {}", target.display()));
        Ok(())
    }
}
