//! Runs in real time, or at a multiple of it.
//!
//! At each instant the run waits for the clock. If the clock is ahead, that is an overrun: the run
//! does not wait until it has caught up. Results do not depend on any of this.

use std::time::{Duration, Instant};

use crate::master::{Controls, Manipulator};
use crate::system::System;
use cosim_base::error::Result;
use cosim_base::time::Time;

/// The minimum interval between two readings of the clock.
const SHORTEST: Duration = Duration::from_millis(1);

/// Limits a run to the pace of the clock.
#[derive(Debug)]
pub struct Pace {
    /// Simulated seconds per second; `None`: as fast as possible.
    factor: Option<f64>,
    /// The clock and the simulated time at the start of the run.
    begun: Option<(Instant, Time)>,
    /// The smallest step of the system.
    smallest: Time,
    step: Time,
    next: Time,
    overruns: Overruns,
}

/// Instants that came too late.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Overruns {
    /// How many.
    pub count: u64,
    /// How many instants there were.
    pub instants: u64,
    /// How late the latest was, in seconds of wall-clock time.
    pub worst: f64,
    /// Which instant that was.
    pub when: Time,
}

impl Pace {
    /// `factor` simulated seconds per second; it must be greater than zero.
    pub fn new(factor: f64) -> Self {
        let zero = Time::ZERO;
        let (factor, overruns) = (Some(factor), Overruns::default());
        Self { factor, begun: None, smallest: zero, step: zero, next: zero, overruns }
    }

    /// Changes the pace from now on; `None`: as fast as possible.
    pub fn change(&mut self, factor: Option<f64>, now: Time) {
        (self.factor, self.begun) = (factor, None);
        self.choose_step();
        self.next = now + self.step;
    }

    /// The number of steps between readings of the clock, so that they are not too frequent.
    fn choose_step(&mut self) {
        let shortest = SHORTEST.as_nanos() as f64 * self.factor.unwrap_or(1.0);
        let smallest = self.smallest.ns();
        let count = (shortest / smallest as f64).ceil().clamp(1.0, 1e9) as i64;
        self.step = Time::from_ns(smallest.saturating_mul(count));
    }

    /// The overruns so far.
    pub fn overruns(&self) -> Overruns {
        self.overruns
    }

    /// The time for which the run was paused.
    pub fn paused(&mut self, length: Duration) {
        if let Some((begun, _)) = &mut self.begun {
            *begun += length;
        }
    }

    fn wait(&mut self, now: Time, factor: f64) {
        let clock = Instant::now();
        let (begun, first) = *self.begun.get_or_insert((clock, now));
        let due = Duration::try_from_secs_f64((now - first).seconds() / factor);
        let due = begun + due.unwrap_or_default();
        self.overruns.instants += 1;
        if clock <= due {
            std::thread::sleep(due - clock);
            return;
        }
        let late = (clock - due).as_secs_f64();
        self.overruns.count += 1;
        if late > self.overruns.worst {
            (self.overruns.worst, self.overruns.when) = (late, now);
        }
    }
}

impl Manipulator for Pace {
    fn start(&mut self, system: &System, resumed: Option<Time>) -> Result<()> {
        let steps = system.components().iter().map(|component| component.step);
        self.smallest = steps.min().unwrap_or(system.output_interval()).rounded();
        self.choose_step();
        self.next = resumed.unwrap_or(system.start_time());
        if resumed.is_some() {
            self.next = self.next + self.step;
        }
        Ok(())
    }

    fn next(&self) -> Option<Time> {
        self.factor.map(|_| self.next)
    }

    fn act(&mut self, now: Time, _: &mut Controls<'_>) -> Result<()> {
        if let Some(factor) = self.factor {
            self.wait(now, factor);
        }
        self.next = now + self.step;
        Ok(())
    }
}
