//! The summary of a run, and the cost of each component.

use serde::{Deserialize, Serialize};

use super::engine::Engine;
use super::iterate::Effort;
use crate::observe::Stop;
use crate::system::System;
use cosim_base::time::Time;

/// The summary of a run.
#[derive(Debug, Clone, Default)]
pub struct Summary {
    /// Total steps of all components, including repeated ones.
    pub steps: u64,
    /// Simulated seconds.
    pub simulated: f64,
    /// Why it ended before the stop time, if it did.
    pub stopped: Option<Stop>,
    /// For each component, in the order of the system.
    pub components: Vec<ComponentSummary>,
    /// Warnings.
    pub warnings: Vec<String>,
    /// Notes: the iterations that loops needed, the lengths of controlled steps.
    pub notes: Vec<String>,
    /// Messages logged by the components, `component: message`.
    pub messages: Vec<String>,
}

/// Work and cost of a component.
#[derive(Debug, Clone, PartialEq)]
pub struct ComponentSummary {
    /// Name in the system.
    pub name: String,
    /// Steps, including repeated ones.
    pub steps: u64,
    /// Steps that were rejected: because of their error, or because the FMU discarded them.
    pub rejected: u64,
    /// Mean wall-clock time of a step with its inputs and outputs, from a sample of the steps.
    pub seconds_per_step: f64,
    /// Its share of the total time of all components, from 0 to 1.
    pub share: f64,
}

/// The report of a scheduler at the end of a run.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Report {
    /// For each component.
    pub components: Vec<ComponentReport>,
    /// For each loop that is solved.
    pub efforts: Vec<Effort>,
    /// What went wrong without ending the run.
    pub warnings: Vec<String>,
    /// What is worth knowing.
    pub notes: Vec<String>,
}

/// Work, cost and messages of a component.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct ComponentReport {
    pub steps: u64,
    pub rejected: u64,
    pub seconds_per_step: f64,
    pub messages: Vec<String>,
}

/// Counters so far: steps per component, iterations per loop.
pub type Tally = (Vec<u64>, Vec<Effort>);

impl Engine {
    /// The counters so far.
    pub fn tally(&self) -> Tally {
        (self.paces.iter().map(|pace| pace.made).collect(), self.efforts.clone())
    }

    /// Continues counting from there.
    pub fn count_from(&mut self, (steps, efforts): &Tally) {
        for (pace, steps) in self.paces.iter_mut().zip(steps) {
            pace.made = *steps;
        }
        for (own, effort) in self.efforts.iter_mut().zip(efforts) {
            *own = *effort;
        }
    }

    pub(super) fn report(&mut self) -> Report {
        let (mut warnings, mut notes) = (self.warnings.clone(), Vec::new());
        self.report_control(&mut warnings, &mut notes);
        let taken_back = self.control.as_ref().map_or(0, |control| control.rejected);
        let each = self.slaves.iter_mut().zip(&self.paces).zip(&self.meter.costs);
        let components = each.map(|((slave, pace), cost)| ComponentReport {
            steps: pace.made,
            rejected: slave.rejected() + taken_back,
            seconds_per_step: cost.seconds_per_step(),
            messages: slave.messages(),
        });
        Report { components: components.collect(), efforts: self.efforts.clone(), warnings, notes }
    }

    fn report_control(&self, warnings: &mut Vec<String>, notes: &mut Vec<String>) {
        let Some(control) = &self.control else {
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
}

impl ComponentReport {
    fn seconds(&self) -> f64 {
        self.steps as f64 * self.seconds_per_step
    }
}

impl System {
    pub(super) fn summary(
        &self,
        report: Report,
        begin: Time,
        end: Time,
        stopped: Option<Stop>,
    ) -> Summary {
        let all: f64 = report.components.iter().map(ComponentReport::seconds).sum();
        let share = |one: f64| if all > 0.0 { one / all } else { 0.0 };
        let each = || self.components().iter().zip(&report.components);
        let mut notes = self.solved(&report.efforts);
        notes.extend(report.notes);
        Summary {
            steps: report.components.iter().map(|component| component.steps).sum(),
            simulated: (end - begin).seconds(),
            stopped,
            components: each()
                .map(|(component, report)| ComponentSummary {
                    name: component.name.clone(),
                    steps: report.steps,
                    rejected: report.rejected,
                    seconds_per_step: report.seconds_per_step,
                    share: share(report.seconds()),
                })
                .collect(),
            messages: each()
                .flat_map(|(component, report)| {
                    report.messages.iter().map(|line| format!("{}: {line}", component.name))
                })
                .collect(),
            warnings: report.warnings,
            notes,
        }
    }

    /// The iterations of each solved loop.
    fn solved(&self, efforts: &[Effort]) -> Vec<String> {
        let loops = self.solved_loops().zip(efforts);
        let lines = loops.filter(|(_, effort)| effort.solved > 0).map(|(found, effort)| {
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
        lines.collect()
    }
}
