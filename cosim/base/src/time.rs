//! Seconds from files and callers as times, with errors that name the value.

pub use fmu_standard::{Step, Time};

use crate::error::{Code, Error, Result};

/// The instant nearest to `seconds`; `name` describes the value in the error.
pub fn from_seconds(seconds: f64, name: &str) -> Result<Time> {
    named(Time::try_from_seconds(seconds), seconds, name)
}

/// A step of this many seconds; `name` describes the value in the error.
pub fn step_from_seconds(seconds: f64, name: &str) -> Result<Step> {
    named(Step::from_seconds(seconds), seconds, name)
}

fn named<T>(time: Result<T, fmu_standard::TimeError>, seconds: f64, name: &str) -> Result<T> {
    time.map_err(|e| Error::new(Code::Timing, format!("{name} is {seconds} s")).why(e))
}
