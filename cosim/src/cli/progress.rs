//! Progress on stderr: simulated time, real-time factor, remaining time.
//!
//! A bar on a terminal, otherwise occasional plain lines. The wall clock is read here and nowhere
//! else in the crate, and no result depends on it.

use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use cosim::Result;
use cosim::Time;
use cosim::observe::{Observer, RunInfo};

const REDRAW: Duration = Duration::from_millis(100);
const PLAIN_LINE: Duration = Duration::from_secs(10);

/// Shows the progress of a run.
pub(super) struct Progress {
    bar: Option<ProgressBar>,
    begun: Instant,
    shown: Instant,
    start: Time,
    stop: Time,
}

impl Progress {
    /// On a terminal a bar, otherwise lines.
    pub(super) fn new() -> Self {
        let now = Instant::now();
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::with_draw_target(Some(0), ProgressDrawTarget::stderr());
            let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  {msg}");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar
        });
        Self { bar, begun: now, shown: now, start: Time::ZERO, stop: Time::ZERO }
    }

    fn message(&self, time: Time, now: Instant) -> String {
        let (done, all) = ((time - self.start).seconds(), (self.stop - self.start).seconds());
        let spent = (now - self.begun).as_secs_f64().max(1e-9);
        let factor = done / spent;
        let remaining = (all - done) / factor.max(1e-9);
        format!(
            "t = {:.1} of {:.1} s, {factor:.0} x real time, {remaining:.0} s remain",
            time.seconds(),
            self.stop.seconds(),
        )
    }
}

impl Default for Progress {
    fn default() -> Self {
        Self::new()
    }
}

impl Observer for Progress {
    fn start(&mut self, info: &RunInfo<'_>) -> Result<()> {
        self.start = info.start;
        self.stop = info.stop;
        self.begun = Instant::now();
        self.shown = self.begun;
        if let Some(bar) = &self.bar {
            bar.set_length((info.stop - info.start).ns().unsigned_abs());
        }
        Ok(())
    }

    fn sample(&mut self, time: Time, _values: &[f64]) -> Result<()> {
        let now = Instant::now();
        let pause = if self.bar.is_some() { REDRAW } else { PLAIN_LINE };
        if now - self.shown < pause {
            return Ok(());
        }
        self.shown = now;
        let message = self.message(time, now);
        match &self.bar {
            Some(bar) => {
                bar.set_position((time - self.start).ns().unsigned_abs());
                bar.set_message(message);
            }
            // A closed stderr must not end a run.
            None => drop(writeln!(std::io::stderr(), "{message}")),
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<()> {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        Ok(())
    }
}
