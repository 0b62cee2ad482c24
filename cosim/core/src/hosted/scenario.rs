//! Faults and changes in a hosted system: the scenario that was exported with it.

use super::Hosted;
use crate::master::{Controls, Manipulator};
use cosim_base::error::Result;
use cosim_base::time::Time;

impl Hosted {
    /// From here on the scenario acts; everything due until `acted` has been applied.
    pub(super) fn begin_scenario(&mut self, acted: Option<Time>) -> Result<()> {
        self.acted = acted;
        let system = &self.system;
        self.scenario.as_mut().map_or(Ok(()), |scenario| scenario.start(system, acted))
    }

    /// Makes the steps up to each action of the scenario before `end`, and applies the action. An
    /// action at `end` waits for the next step: as in a run, values there are those before it. It
    /// acts on what the host has set.
    pub(super) fn act_before(&mut self, end: Time) -> Result<()> {
        let (Some(scenario), Some(engine)) = (&mut self.scenario, &mut self.engine) else {
            return Ok(());
        };
        while let Some(at) = scenario.next().map(|at| at.max(self.start)) {
            if at >= end || self.acted.is_some_and(|acted| at <= acted) {
                break;
            }
            engine.run_until(at)?;
            scenario.act(at, &mut Controls::of(&self.system, engine, at))?;
            self.acted = Some(at);
            for (end, value) in self.table.open() {
                engine.rebase(end.port, end.inward(value)?.number())?;
            }
        }
        Ok(())
    }
}
