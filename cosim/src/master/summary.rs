//! What a run did, and what each component cost.

use super::engine::Engine;
use crate::observe::Stop;
use crate::system::System;
use crate::time::Time;

/// What a run did.
#[derive(Debug, Clone, Default)]
pub struct Summary {
    /// Steps of all components together, those made again included.
    pub steps: u64,
    /// Simulated seconds.
    pub simulated: f64,
    /// Why it ended before the stop time, if it did.
    pub stopped: Option<Stop>,
    /// Per component, in the order of the system.
    pub components: Vec<ComponentSummary>,
    /// What is odd but did not end the run.
    pub warnings: Vec<String>,
    /// What is good to know: the iterations that loops needed, the lengths of controlled steps.
    pub notes: Vec<String>,
    /// What the components logged, `component: message`.
    pub messages: Vec<String>,
}

/// What a component did and cost.
#[derive(Debug, Clone, PartialEq)]
pub struct ComponentSummary {
    /// Name in the system.
    pub name: String,
    /// Steps, those made again included.
    pub steps: u64,
    /// Steps that were taken back: for their error, or because the FMU discarded them.
    pub rejected: u64,
    /// Mean wall clock time of a step with its inputs and outputs, by a sample of the steps.
    pub seconds_per_step: f64,
    /// Its part of the time that all components took together, from 0 to 1.
    pub share: f64,
}

impl System {
    pub(super) fn summary(
        &self,
        engine: &mut Engine,
        begin: Time,
        end: Time,
        stopped: Option<Stop>,
    ) -> Summary {
        let mut warnings = engine.warnings.clone();
        let mut notes = self.solved(engine);
        self.tell_control(engine, &mut warnings, &mut notes);
        Summary {
            steps: engine.made.iter().sum(),
            simulated: (end - begin).seconds(),
            stopped,
            components: self.costs(engine),
            warnings,
            notes,
            messages: self.named(engine.messages()),
        }
    }

    fn costs(&self, engine: &Engine) -> Vec<ComponentSummary> {
        let whole: Vec<f64> = engine
            .made
            .iter()
            .zip(&engine.meter.costs)
            .map(|(made, cost)| *made as f64 * cost.seconds_per_step())
            .collect();
        let all: f64 = whole.iter().sum();
        let taken_back = engine.control.as_ref().map_or(0, |control| control.rejected);
        let each = self.components().iter().enumerate();
        each.map(|(c, component)| ComponentSummary {
            name: component.name.clone(),
            steps: engine.made[c],
            rejected: engine.slaves[c].rejected() + taken_back,
            seconds_per_step: engine.meter.costs[c].seconds_per_step(),
            share: if all > 0.0 { whole[c] / all } else { 0.0 },
        })
        .collect()
    }

    /// The effort for each loop that was solved by iteration.
    fn solved(&self, engine: &Engine) -> Vec<String> {
        let loops = self.solved_loops().zip(&engine.efforts);
        let told = loops.filter(|(_, effort)| effort.solved > 0).map(|(found, effort)| {
            let mean = effort.passes as f64 / effort.solved as f64;
            format!(
                "loop through {}: {} solutions, {mean:.1} passes each, at most {}, greatest \
                 residual {:.1e}{}",
                self.members(found),
                effort.solved,
                effort.most,
                effort.residual,
                effort.jacobian()
            )
        });
        told.collect()
    }

    fn tell_control(&self, engine: &Engine, warnings: &mut Vec<String>, notes: &mut Vec<String>) {
        let Some(control) = &engine.control else {
            return;
        };
        notes.push(format!(
            "steps under error control: {} accepted, {} rejected, from {} to {}",
            control.accepted, control.rejected, control.shortest, control.longest
        ));
        if control.forced > 0 {
            warnings.push(format!(
                "{} steps miss the tolerance though they are the smallest, the first at t = {}",
                control.forced, control.first_forced
            ));
        }
    }

    fn named(&self, messages: Vec<Vec<String>>) -> Vec<String> {
        let all = self.components().iter().zip(messages);
        all.flat_map(|(c, lines)| lines.into_iter().map(move |l| format!("{}: {l}", c.name)))
            .collect()
    }
}
