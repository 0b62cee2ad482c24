//! The observer: copies samples and returns.

use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::json;

use super::hub::{About, Hub, locked};
use cosim_base::error::Result;
use cosim_base::time::Time;
use cosim_core::observe::{Observer, RunInfo};
use cosim_core::scenario::Window;
use cosim_results::roles::{Declaration, Measure, Names, Roles};

/// Interval between batches.
const FRAME: Duration = Duration::from_millis(33);
/// Time over which the speed is measured.
const MEASURED: Duration = Duration::from_millis(500);
/// Maximum number of values in a batch, and in the history for clients that connect later.
const BATCH: usize = 200_000;
const HISTORY: usize = 400_000;

/// Shows a run to the clients of a [`super::Server`].
pub struct Watch {
    hub: Arc<Hub>,
    declared: Option<Declaration>,
    faults: Vec<Window>,
    sent: Instant,
    /// Start of the speed measurement: wall-clock time, and simulated time.
    since: (Instant, Time),
    now: Time,
    /// The newest sample is not in the history.
    skipped: bool,
}

impl Watch {
    pub(super) fn new(hub: Arc<Hub>, declared: Option<Declaration>, faults: Vec<Window>) -> Self {
        let (now, begun) = (Time::ZERO, Instant::now());
        Self { hub, declared, faults, sent: begun, since: (begun, now), now, skipped: false }
    }

    #[cold]
    fn send(&mut self, clock: Instant) {
        self.sent = clock;
        self.hub.publish();
        let spent = clock - self.since.0;
        let (time, since) = (self.now, self.since.1);
        self.hub.update(|newest| {
            newest.time = time;
            if spent >= MEASURED {
                newest.factor = (time - since).seconds() / spent.as_secs_f64();
            }
        });
        if spent >= MEASURED {
            self.since = (clock, time);
        }
    }
}

impl Observer for Watch {
    fn start(&mut self, info: &RunInfo<'_>) -> Result<()> {
        let names = Names::new(info.columns.iter().map(|column| column.name.as_str()));
        let measures: Vec<Measure> = info.columns.iter().map(Measure::of).collect();
        let width = info.columns.len();
        let about = About {
            name: info.name.to_owned(),
            columns: info.columns.to_vec(),
            start: info.resumed.unwrap_or(info.start),
            stop: info.stop,
            roles: Roles::find(&names, &measures, self.declared.as_ref())?,
            declared: self.declared.clone(),
            faults: json!(self.faults),
        };
        self.now = about.start;
        self.since = (Instant::now(), about.start);
        let rows = |values: usize| values / width.max(1);
        self.hub.begin(about, rows(HISTORY).clamp(40, 3000), rows(BATCH).clamp(4, 64));
        Ok(())
    }

    fn sample(&mut self, time: Time, values: &[f64]) -> Result<()> {
        let nanoseconds = time.ns();
        // The run waits for no client: a sample is skipped while a new client copies the history.
        self.skipped = match self.hub.history.try_lock() {
            Ok(mut history) => {
                history.push(nanoseconds, values);
                false
            }
            Err(_) => true,
        };
        locked(&self.hub.fresh).push(nanoseconds, values);
        self.now = time;
        let clock = Instant::now();
        if clock - self.sent >= FRAME {
            self.send(clock);
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<()> {
        if self.skipped
            && let Some((time, row)) = locked(&self.hub.fresh).all().rows().last()
        {
            locked(&self.hub.history).push(time, row);
        }
        self.send(Instant::now());
        Ok(())
    }
}
