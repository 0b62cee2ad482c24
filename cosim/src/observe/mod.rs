//! What watches a run: recorders and progress. Observers read; nothing they do changes values.

mod closeness;
mod continued;
mod csv;
mod csv_read;
mod digest;
mod mcap;
mod mcap_read;
mod mcap_records;
#[cfg(feature = "campaign")]
mod parquet;
mod progress;
mod recording;
mod verify;

pub use closeness::{Apart, Beyond, Closeness, Tolerance};
pub use continued::Continued;
pub use csv::CsvRecorder;
pub(crate) use csv::Form;
pub use digest::{Digested, RunningDigest};
pub use mcap::McapRecorder;
#[cfg(feature = "campaign")]
pub use parquet::ParquetRecorder;
pub use progress::Progress;
pub use recording::Recording;
pub use verify::{Comparison, Differing, Parting};

use std::path::Path;

use crate::error::{Code, Error, Result};
use crate::files::Unfinished;
use crate::roles::Declaration;
use crate::system::Column;
use crate::time::{Step, Time};

/// What a run is about to do.
pub struct RunInfo<'a> {
    /// Name of the system.
    pub name: &'a str,
    /// What is recorded, in this order.
    pub columns: &'a [Column],
    /// First instant.
    pub start: Time,
    /// Last instant.
    pub stop: Time,
    /// Time between samples.
    pub output_interval: Step,
    /// The run goes on from a snapshot of this instant: samples come after it.
    pub resumed: Option<Time>,
}

/// Watches a run. Calls come in the order start, sample ..., finish; an error ends the run.
pub trait Observer {
    /// Before the first sample.
    fn start(&mut self, info: &RunInfo<'_>) -> Result<()>;

    /// The recorded values at an output instant; Integers and Booleans (0, 1) as numbers.
    fn sample(&mut self, time: Time, values: &[f64]) -> Result<()>;

    /// Before a snapshot is kept: what was given so far must outlive the process.
    fn flush(&mut self) -> Result<()> {
        Ok(())
    }

    /// After the last sample, also when the run failed.
    fn finish(&mut self) -> Result<()>;

    /// Asked after each sample; a reason ends the run there, without an error.
    fn stop(&self) -> Option<Stop> {
        None
    }
}

/// The format of a file of results: the ending of its name says which.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Csv,
    Mcap,
    #[cfg(feature = "campaign")]
    Parquet,
}

impl Format {
    /// CSV for any ending that is not another format's.
    fn of(file: &Path) -> Self {
        let ending = file.extension().and_then(|ending| ending.to_str()).unwrap_or("");
        match ending.to_ascii_lowercase().as_str() {
            "mcap" => Self::Mcap,
            #[cfg(feature = "campaign")]
            "parquet" => Self::Parquet,
            _ => Self::Csv,
        }
    }

    /// The format of a file that is to be written. An ending that promises another format is refused.
    fn to_write(file: &Path) -> Result<Self> {
        let Some(ending) = file.extension().map(|ending| ending.to_string_lossy()) else {
            // Devices and pipes, too.
            return Ok(Self::Csv);
        };
        let format = Self::of(file);
        if format != Self::Csv || ending.eq_ignore_ascii_case("csv") {
            return Ok(format);
        }
        Err(Error::new(Code::Usage, format!("results cannot be written as '.{ending}'"))
            .at(file)
            .help("let the name end in .csv, .mcap or .parquet"))
    }
}

/// Whether a file's name ends as one of results.
pub fn is_results(file: &Path) -> bool {
    let csv = file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv"));
    csv || Format::of(file) != Format::Csv
}

/// Refuses a file of results whose ending names no format that can be written.
pub fn check_ending(file: &Path) -> Result<()> {
    Format::to_write(file).map(drop)
}

/// Creates a file of results: CSV, MCAP or Parquet, as the ending of its name says.
pub fn create(file: impl AsRef<Path>) -> Result<Box<dyn Observer>> {
    create_with(file, None)
}

/// As [`create`]; messages of ROS are made of the variables that `roles` names.
pub fn create_with(
    file: impl AsRef<Path>,
    roles: Option<Declaration>,
) -> Result<Box<dyn Observer>> {
    let file = file.as_ref();
    Ok(match Format::to_write(file)? {
        Format::Csv => Box::new(CsvRecorder::create(file)?),
        Format::Mcap => Box::new(McapRecorder::create(file)?.declared(roles)),
        #[cfg(feature = "campaign")]
        Format::Parquet => Box::new(ParquetRecorder::create(file)?),
    })
}

/// Creates a file of results that gets its name when it is finished; see [`Continued`].
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
        Format::Mcap => (Box::new(McapRecorder::on(output, name)?.declared(roles)), unfinished),
        #[cfg(feature = "campaign")]
        Format::Parquet => (Box::new(ParquetRecorder::on(output, name)), unfinished),
    })
}

/// Why a run ends before its stop time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// The observer has seen enough.
    Enough,
    /// Nobody reads the results any more: the pipe was closed.
    ReaderGone,
    /// The user asked for it.
    Interrupted,
    /// An FMU ended it; a warning of the run says which and when.
    Component,
}
