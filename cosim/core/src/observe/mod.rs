//! Observers of a run: recorders and progress. They only read; nothing they do changes values.

mod closeness;
mod continued;
mod csv;
mod csv_read;
mod digest;
mod recording;
mod verify;

pub use closeness::{Apart, Beyond, Closeness, Tolerance};
pub use continued::Continued;
pub use csv::CsvRecorder;
pub use csv::Form;
pub use digest::{Digested, RunningDigest};
pub use recording::Recording;
pub use verify::{Comparison, Differing, Parting};

use crate::system::Column;
use cosim_base::error::Result;
use cosim_base::time::{Step, Time};

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
