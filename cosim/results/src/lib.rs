//! Results of `cosim` in other formats than CSV, and what their variables are.
//!
//! | module | contents |
//! |---|---|
//! | `roles` | which variables are truth, estimates and measurements |
//! | `ros` | ROS 2 messages made from recorded values |
//! | `mcap` | results as MCAP with these messages |
//! | `parquet`, `columns` | results, and other tables, as Apache Parquet |
//! | `trajectories` | results as trajectories for odometry and SLAM tools |

#![forbid(unsafe_code)]

pub mod columns;
mod mcap;
mod mcap_read;
mod mcap_records;
mod parquet;
pub mod roles;
pub mod ros;
mod trajectories;

pub use mcap::McapRecorder;
pub use parquet::{ParquetRecorder, check_footer};
pub use trajectories::{Trajectories, foxglove_layout, replay, trajectories};

use std::path::Path;

use cosim_base::files::Unfinished;
use cosim_core::observe::{CsvRecorder, Observer, Recording};
use cosim_core::{Code, Error, Result};
use roles::Declaration;

const UNWRITTEN: &str = "the results cannot be written";

/// The format of a results file, given by its extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Csv,
    Mcap,
    Parquet,
}

impl Format {
    /// CSV for any extension that does not belong to another format.
    fn of(file: &Path) -> Self {
        let ending = file.extension().and_then(|ending| ending.to_str()).unwrap_or("");
        match ending.to_ascii_lowercase().as_str() {
            "mcap" => Self::Mcap,
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
pub fn create(file: impl AsRef<Path>) -> Result<Box<dyn Observer>> {
    create_with(file, None)
}

/// Like [`create`]; ROS messages are made from the variables that `roles` names.
pub fn create_with(
    file: impl AsRef<Path>,
    roles: Option<Declaration>,
) -> Result<Box<dyn Observer>> {
    let file = file.as_ref();
    Ok(match Format::to_write(file)? {
        Format::Csv => Box::new(CsvRecorder::create(file)?),
        Format::Mcap => Box::new(McapRecorder::create(file)?.declared(roles)),
        Format::Parquet => Box::new(ParquetRecorder::create(file)?),
    })
}

/// Creates a results file that gets its final name when it is finished; see [`cosim_core::observe::Continued`].
pub fn create_unfinished(
    target: &Path,
    roles: Option<Declaration>,
) -> Result<(Box<dyn Observer>, Unfinished)> {
    let unwritten = |why| Error::new(Code::Output, UNWRITTEN).at(target).why(why);
    let format = Format::to_write(target)?;
    let unfinished = Unfinished::new(target).map_err(unwritten)?;
    let (output, name) = (unfinished.writer().map_err(unwritten)?, target.to_owned());
    Ok(match format {
        Format::Csv => (Box::new(CsvRecorder::new(output, name)), unfinished),
        Format::Mcap => (Box::new(McapRecorder::on(output, name)?.declared(roles)), unfinished),
        Format::Parquet => (Box::new(ParquetRecorder::on(output, name)), unfinished),
    })
}

/// Reads results: MCAP if the file name ends in `.mcap`, Parquet if in `.parquet`, otherwise CSV.
pub fn read(file: impl AsRef<Path>) -> Result<Recording> {
    let file = file.as_ref();
    match Format::of(file) {
        Format::Csv => Recording::read_csv(file),
        Format::Mcap => mcap_read::read(file),
        Format::Parquet => parquet::read(file),
    }
}

/// Reads results whose writer may have been killed: an incomplete last sample is ignored.
pub fn read_unfinished(file: impl AsRef<Path>) -> Result<Recording> {
    let file = file.as_ref();
    if Format::of(file) == Format::Csv {
        return Recording::read_unfinished_csv(file);
    }
    read(file)
}
