//! What a run drives: the engine of this process, or groups of components elsewhere.

use super::engine::Engine;
use super::manipulate::Change;
use super::snapshot::EngineState;
use super::summary::Report;
use crate::error::Result;
use crate::time::Time;

/// A system that is stepped, wherever it is.
pub(crate) trait Drive {
    /// Initializes all components with values that agree along all connections.
    fn initialize(&mut self, stop: Time) -> Result<()>;

    /// Makes every step that ends at or before `limit`.
    fn run_until(&mut self, limit: Time) -> Result<()>;

    /// The recorded values of the present instant.
    fn sample(&mut self, row: &mut [f64]) -> Result<()>;

    /// Changes a variable of a component from now on.
    fn change(&mut self, component: usize, change: Change) -> Result<()>;

    /// The state after all steps that end now or before.
    fn save(&mut self) -> Result<EngineState>;

    /// Goes on from a state of the instant `time`.
    fn resume(&mut self, state: &EngineState, time: Time, stop: Time) -> Result<()>;

    /// What the run cost and what there is to tell, at its end.
    fn report(&mut self) -> Result<Report>;
}

impl Drive for Engine {
    fn initialize(&mut self, stop: Time) -> Result<()> {
        Engine::initialize(self, stop)
    }

    fn run_until(&mut self, limit: Time) -> Result<()> {
        Engine::run_until(self, limit)
    }

    fn sample(&mut self, row: &mut [f64]) -> Result<()> {
        self.read_recorded()?;
        for (value, &slot) in row.iter_mut().zip(&self.plan.columns) {
            *value = self.values[slot];
        }
        Ok(())
    }

    fn change(&mut self, component: usize, change: Change) -> Result<()> {
        Engine::change(self, component, change)
    }

    fn save(&mut self) -> Result<EngineState> {
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
