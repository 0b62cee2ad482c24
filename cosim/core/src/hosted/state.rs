//! The state of a hosted system: everything needed to continue, in this process or in another.
//!
//! Before steps are made, it contains what the host has set, and initialization is repeated; after
//! that, it contains the serialized states of the components.

use serde::{Deserialize, Serialize};

use super::{Basic, Hosted, Stage};
use crate::master::EngineState;
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::Time;
use cosim_import::Value;

/// A state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    stage: Stage,
    start: Time,
    stop: Time,
    tolerance: Option<f64>,
    time: Time,
    given: Vec<Vec<(usize, Value)>>,
    values: Vec<Value>,
    pending: Vec<(Basic, u32)>,
    engine: Option<EngineState>,
    acted: Option<Time>,
}

impl Hosted {
    /// The current state.
    pub fn save(&mut self) -> Result<Kept> {
        let engine = match (&mut self.engine, self.stage) {
            (Some(engine), Stage::Running) => {
                engine.come_to(self.time);
                Some(engine.save()?)
            }
            _ => None,
        };
        Ok(Kept {
            stage: self.stage,
            start: self.start,
            stop: self.stop,
            tolerance: self.tolerance,
            time: self.time,
            given: self.given.clone(),
            values: self.table.values(),
            pending: self.pending.clone(),
            engine,
            acted: self.acted,
        })
    }

    /// Continues from a state of this system.
    pub fn restore(&mut self, kept: &Kept) -> Result<()> {
        self.check(kept)?;
        // Components without an error restore their states; otherwise they are created again.
        let alike = self.stage == Stage::Running
            && (self.start, self.stop, self.tolerance) == (kept.start, kept.stop, kept.tolerance)
            && self.given == kept.given;
        self.table.take(&kept.values);
        self.given.clone_from(&kept.given);
        if !(alike && self.take_on(kept).is_ok()) {
            self.rebuild(kept)?;
        }
        self.pending.clone_from(&kept.pending);
        self.time = kept.time;
        self.unread.fill(true);
        Ok(())
    }

    fn rebuild(&mut self, kept: &Kept) -> Result<()> {
        if kept.stage == Stage::Before {
            self.engine = None;
            self.stage = Stage::Before;
            return Ok(());
        }
        self.enter(kept.start, kept.stop, kept.tolerance)?;
        if kept.stage == Stage::Running {
            self.exit()?;
            self.take_on(kept)?;
        }
        Ok(())
    }

    fn take_on(&mut self, kept: &Kept) -> Result<()> {
        match (&mut self.engine, &kept.engine) {
            (Some(engine), Some(state)) => engine.restore(state, kept.time)?,
            _ => return Err(self.strange()),
        }
        self.begin_scenario(kept.acted)
    }

    /// Whether the state belongs to this system.
    fn check(&self, kept: &Kept) -> Result<()> {
        let variables = |component: usize| {
            let model = &self.system.components()[component].model;
            model.description().map_or(0, |d| d.variables.len())
        };
        let fits = kept.given.len() == self.given.len()
            && kept.given.iter().enumerate().all(|(component, given)| {
                given.iter().all(|(variable, _)| *variable < variables(component))
            })
            && kept.pending.iter().all(|&(basic, r)| self.table.known(basic, r).is_ok())
            && self.table.fits(&kept.values)
            && kept.engine.is_some() == (kept.stage == Stage::Running);
        if fits { Ok(()) } else { Err(self.strange()) }
    }

    fn strange(&self) -> Error {
        Error::new(
            Code::State,
            format!("the state does not belong to the system '{}'", self.system.name()),
        )
    }
}
