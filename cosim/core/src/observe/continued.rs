//! Results that continue an existing file.

use super::{Observer, Recording, RunInfo, Stop};
use cosim_base::error::{Code, Error, Result};
use cosim_base::files::Unfinished;
use cosim_base::time::{self, Time};

/// Passes the recording of an earlier run to a recorder, and then that of the resumed run. In the
/// end, its file is the same as that of an uninterrupted run.
pub struct Continued {
    recorder: Box<dyn Observer>,
    old: Recording,
    /// The file of the recorder, which gets its final name once it contains the old results.
    unfinished: Option<Unfinished>,
}

impl Continued {
    /// `old` is the recording of the earlier run, of which the part up to the snapshot is used.
    pub fn new(recorder: Box<dyn Observer>, old: Recording) -> Self {
        Self { recorder, old, unfinished: None }
    }

    /// The recorder writes this file, which gets its final name as soon as it contains the old
    /// results: if the process is killed before that, nothing is lost.
    #[must_use]
    pub fn replacing(mut self, unfinished: Unfinished) -> Self {
        self.unfinished = Some(unfinished);
        self
    }

    fn rename(&mut self) -> Result<()> {
        let Some(unfinished) = self.unfinished.take() else {
            return Ok(());
        };
        self.recorder.flush()?;
        unfinished
            .finish()
            .map_err(|why| Error::new(Code::Output, "the results cannot be replaced").why(why))
    }
}

impl Observer for Continued {
    fn start(&mut self, info: &RunInfo<'_>) -> Result<()> {
        self.recorder.start(info)?;
        let until = info.resumed.unwrap_or(info.start);
        let mut last = None;
        let mut row = vec![0.0; info.columns.len()];
        for (sample, &seconds) in self.old.time().iter().enumerate() {
            let time = time::from_seconds(seconds, "a time of the results")?;
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
        if last
            .is_some_and(|last| info.start + info.output_interval.after(last - info.start) > until)
        {
            return self.rename();
        }
        self.unfinished = None;
        let end = last.map_or("nothing".to_owned(), |last| format!("values up to t = {last}"));
        Err(Error::new(Code::Results, "the results cannot be continued")
            .why(format!("they have {end}, the snapshot is at t = {until}"))
            .help("write to another file, or resume from an older snapshot"))
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
