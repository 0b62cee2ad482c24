//! Measures the cost of steps: some of them are timed.
//!
//! Reading the clock costs more than the step of a small FMU, so only some instants are timed, at
//! aperiodic intervals. The clock is read only for the summary: no result depends on it.

use std::time::{Duration, Instant};

/// Times of the components.
pub(super) struct Meter {
    /// Whether the steps of the current instant are timed.
    pub timing: bool,
    pub costs: Vec<Cost>,
    wait: u64,
    dice: u64,
    /// The cost of reading the clock.
    clock: Duration,
}

/// For one component.
#[derive(Clone, Copy, Default)]
pub(super) struct Cost {
    timed: u64,
    spent: Duration,
}

/// The first instants are all timed, for short runs: this many, and in large systems this many
/// steps.
const FIRST: u64 = 100;
const FIRST_STEPS: u64 = 1000;
/// The mean interval between timed instants is half of this.
const FAR: u64 = 512;

impl Meter {
    pub(super) fn new(components: usize) -> Self {
        let readings = (0..20).map(|_| {
            let begun = Instant::now();
            begun.elapsed()
        });
        let clock = readings.min().unwrap_or_default();
        let costs = vec![Cost::default(); components];
        let first = (FIRST_STEPS / components.max(1) as u64).clamp(1, FIRST);
        Self { timing: true, costs, wait: first + 1, dice: 1, clock }
    }

    /// The next instant begins.
    #[inline]
    pub(super) fn instant(&mut self) {
        self.wait -= 1;
        if self.wait == 0 {
            self.turn();
        }
    }

    #[cold]
    fn turn(&mut self) {
        self.timing = !self.timing;
        // Knuth's MMIX generator: intervals must not coincide with the periods of the steps.
        self.dice = self.dice.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        self.wait = if self.timing { 1 } else { 1 + (self.dice >> 33) % FAR };
    }

    #[cold]
    pub(super) fn timed(&mut self, component: usize, spent: Duration) {
        let cost = &mut self.costs[component];
        cost.timed += 1;
        cost.spent += spent.saturating_sub(self.clock);
    }
}

impl Cost {
    /// Mean seconds per step, if steps were timed.
    pub(super) fn seconds_per_step(&self) -> f64 {
        self.spent.as_secs_f64() / self.timed.max(1) as f64
    }
}
