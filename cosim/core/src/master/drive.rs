//! What a run drives: the engine of this process, or groups of components in other processes.

use super::engine::Engine;
use super::manipulate::Change;
use super::snapshot::EngineState;
use super::summary::Report;
use cosim_base::error::Result;
use cosim_base::time::Time;

/// A system that is stepped, wherever it runs.
pub trait Drive {
    /// Initializes all components with values that are consistent along all connections.
    fn initialize(&mut self, stop: Time) -> Result<()>;

    /// Makes every step that ends at or before `limit`.
    fn run_until(&mut self, limit: Time) -> Result<()>;

    /// Ends at `now` all steps that have begun and would end later, because the run ends there.
    fn conclude(&mut self, now: Time) -> Result<()>;

    /// The recorded values of the current instant `now`, as numbers ([`cosim_import::Scalar::number`]).
    fn sample(&mut self, now: Time, row: &mut [f64]) -> Result<()>;

    /// Changes a variable of a component from now on.
    fn change(&mut self, component: usize, change: Change, now: Time) -> Result<()>;

    /// The state after all steps that end now or before.
    fn save(&mut self, now: Time) -> Result<EngineState>;

    /// Continues from a state of the instant `time`.
    fn resume(&mut self, state: &EngineState, time: Time, stop: Time) -> Result<()>;

    /// The cost of the run, warnings and notes, at its end.
    fn report(&mut self) -> Result<Report>;
}

impl Drive for Engine {
    fn initialize(&mut self, stop: Time) -> Result<()> {
        Engine::initialize(self, stop)
    }

    fn run_until(&mut self, limit: Time) -> Result<()> {
        Engine::run_until(self, limit)
    }

    fn conclude(&mut self, now: Time) -> Result<()> {
        Engine::conclude(self, now)
    }

    fn sample(&mut self, now: Time, row: &mut [f64]) -> Result<()> {
        self.read_recorded(now)?;
        self.plan.row(&self.values, row);
        Ok(())
    }

    fn change(&mut self, component: usize, change: Change, now: Time) -> Result<()> {
        self.come_to(now);
        Engine::change(self, component, change)
    }

    fn save(&mut self, now: Time) -> Result<EngineState> {
        self.come_to(now);
        Engine::save(self)
    }

    fn resume(&mut self, state: &EngineState, time: Time, stop: Time) -> Result<()> {
        Engine::initialize(self, stop)?;
        self.restore(state, time)
    }

    fn report(&mut self) -> Result<Report> {
        Ok(Engine::report(self))
    }
}
