//! Results that go on where a file of a run before ends.

use super::{Observer, Recording, RunInfo, Stop};
use crate::error::{Code, Error, Result};
use crate::time::Time;

/// Passes on to a recorder what an older run recorded, and then what the resumed run does. So its
/// file is in the end that of a run that nothing interrupted.
pub struct Continued {
    recorder: Box<dyn Observer>,
    old: Recording,
}

impl Continued {
    /// `old` is what the run before recorded, of which the part up to the snapshot is used.
    pub fn new(recorder: Box<dyn Observer>, old: Recording) -> Self {
        Self { recorder, old }
    }
}

impl Observer for Continued {
    fn start(&mut self, info: &RunInfo<'_>) -> Result<()> {
        self.recorder.start(info)?;
        let until = info.resumed.unwrap_or(info.start);
        let mut last = None;
        let mut row = vec![0.0; info.columns.len()];
        for (sample, &seconds) in self.old.time().iter().enumerate() {
            let time = Time::from_seconds(seconds, "a time of the results")?;
            if time > until {
                break;
            }
            for (value, (_, column)) in row.iter_mut().zip(self.old.columns()) {
                *value = column[sample];
            }
            self.recorder.sample(time, &row)?;
            last = Some(time);
        }
        self.old = Recording::new();
        if last.is_some_and(|last| until - last < info.output_interval) {
            return Ok(());
        }
        let end = last.map_or("nothing".to_owned(), |last| format!("values up to t = {last}"));
        Err(Error::new(Code::Results, "the results cannot be continued")
            .why(format!("they have {end}, the snapshot is of t = {until}"))
            .help("resume into another file, or from an older snapshot"))
    }

    fn sample(&mut self, time: Time, values: &[f64]) -> Result<()> {
        self.recorder.sample(time, values)
    }

    fn flush(&mut self) -> Result<()> {
        self.recorder.flush()
    }

    fn finish(&mut self) -> Result<()> {
        self.recorder.finish()
    }

    fn stop(&self) -> Option<Stop> {
        self.recorder.stop()
    }
}
