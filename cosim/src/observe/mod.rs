//! Observers of a run: recorders and progress. They only read; nothing they do changes values.

mod closeness;
mod continued;
mod csv;
mod csv_read;
mod digest;
#[cfg(feature = "program")]
mod mcap;
#[cfg(feature = "program")]
mod mcap_read;
#[cfg(feature = "program")]
mod mcap_records;
#[cfg(feature = "campaign")]
mod parquet;
#[cfg(feature = "program")]
mod progress;
mod recording;
mod verify;

pub use closeness::{Apart, Beyond, Closeness, Tolerance};
pub use continued::Continued;
pub use csv::CsvRecorder;
pub(crate) use csv::Form;
pub use digest::{Digested, RunningDigest};
#[cfg(feature = "program")]
pub use mcap::McapRecorder;
#[cfg(feature = "campaign")]
pub use parquet::ParquetRecorder;
#[cfg(feature = "campaign")]
pub(crate) use parquet::check_footer;
#[cfg(feature = "program")]
pub use progress::Progress;
pub use recording::Recording;
pub use verify::{Comparison, Differing, Parting};

use std::path::Path;

use crate::error::{Code, Error, Result};
use crate::files::Unfinished;
use crate::roles::Declaration;
use crate::system::Column;
use crate::time::{Step, Time};

/// Properties of a run that is about to start.
pub struct RunInfo<'a> {
    /// Name of the system.
    pub name: &'a str,
    /// The recorded variables, in this order.
    pub columns: &'a [Column],
    /// Start time.
    pub start: Time,
    /// Stop time.
    pub stop: Time,
    /// Time between samples.
    pub output_interval: Step,
    /// The run continues from a snapshot of this instant: samples come after it.
    pub resumed: Option<Time>,
}

/// Observes a run. Calls come in the order start, sample ..., finish; an error ends the run.
pub trait Observer {
    /// Before the first sample.
    fn start(&mut self, info: &RunInfo<'_>) -> Result<()>;

    /// The recorded values at an output instant; Integers and Booleans (0, 1) as numbers.
    fn sample(&mut self, time: Time, values: &[f64]) -> Result<()>;

    /// Before a snapshot is saved: everything received so far must survive the end of the process.
    fn flush(&mut self) -> Result<()> {
        Ok(())
    }

    /// After the last sample, also if the run failed.
    fn finish(&mut self) -> Result<()>;

    /// Called after each sample; a reason ends the run there, without an error.
    fn stop(&self) -> Option<Stop> {
        None
    }
}

/// The format of a results file, given by its extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Csv,
    #[cfg(feature = "program")]
    Mcap,
    #[cfg(feature = "campaign")]
    Parquet,
}

impl Format {
    /// CSV for any extension that does not belong to another format.
    fn of(file: &Path) -> Self {
        let ending = file.extension().and_then(|ending| ending.to_str()).unwrap_or("");
        match ending.to_ascii_lowercase().as_str() {
            #[cfg(feature = "program")]
            "mcap" => Self::Mcap,
            #[cfg(feature = "campaign")]
            "parquet" => Self::Parquet,
            _ => Self::Csv,
        }
    }

    /// The format of a file to be written. An extension of an unsupported format is refused.
    fn to_write(file: &Path) -> Result<Self> {
        let Some(ending) = file.extension().map(|ending| ending.to_string_lossy()) else {
            // Also for devices and pipes.
            return Ok(Self::Csv);
        };
        let format = Self::of(file);
        if format != Self::Csv || ending.eq_ignore_ascii_case("csv") {
            return Ok(format);
        }
        Err(Error::new(Code::Usage, format!("results cannot be written as '.{ending}'"))
            .at(file)
            .help("use a name that ends in .csv, .mcap or .parquet"))
    }
}

/// Whether a file name has an extension of results.
pub fn is_results(file: &Path) -> bool {
    let csv = file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv"));
    csv || Format::of(file) != Format::Csv
}

/// Refuses a results file whose extension is not a format that can be written.
pub fn check_ending(file: &Path) -> Result<()> {
    Format::to_write(file).map(drop)
}

/// Creates a results file: CSV, MCAP or Parquet, according to its extension.
#[cfg(feature = "program")]
pub fn create(file: impl AsRef<Path>) -> Result<Box<dyn Observer>> {
    create_with(file, None)
}

/// Like [`create`]; ROS messages are made from the variables that `roles` names.
#[cfg(feature = "program")]
pub fn create_with(
    file: impl AsRef<Path>,
    roles: Option<Declaration>,
) -> Result<Box<dyn Observer>> {
    let file = file.as_ref();
    Ok(match Format::to_write(file)? {
        Format::Csv => Box::new(CsvRecorder::create(file)?),
        #[cfg(feature = "program")]
        Format::Mcap => Box::new(McapRecorder::create(file)?.declared(roles)),
        #[cfg(feature = "campaign")]
        Format::Parquet => Box::new(ParquetRecorder::create(file)?),
    })
}

/// Creates a results file that gets its final name when it is finished; see [`Continued`].
#[cfg(feature = "program")]
pub fn create_unfinished(
    target: &Path,
    roles: Option<Declaration>,
) -> Result<(Box<dyn Observer>, Unfinished)> {
    let unwritten = |why| Error::new(Code::Output, csv::UNWRITTEN).at(target).why(why);
    let format = Format::to_write(target)?;
    let unfinished = Unfinished::new(target).map_err(unwritten)?;
    let (output, name) = (unfinished.writer().map_err(unwritten)?, target.to_owned());
    Ok(match format {
        Format::Csv => (Box::new(CsvRecorder::on(output, name)), unfinished),
        #[cfg(feature = "program")]
        Format::Mcap => (Box::new(McapRecorder::on(output, name)?.declared(roles)), unfinished),
        #[cfg(feature = "campaign")]
        Format::Parquet => (Box::new(ParquetRecorder::on(output, name)), unfinished),
    })
}

/// Why a run ends before its stop time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// The observer needs no more samples.
    Enough,
    /// The results are no longer read: the pipe was closed.
    ReaderGone,
    /// The user requested it.
    Interrupted,
    /// An FMU ended it; a warning of the run names the FMU and the time.
    Component,
}
