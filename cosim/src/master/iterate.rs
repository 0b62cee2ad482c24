//! Algebraic loops solved by iteration: at the initialization and at steps.
//!
//! The unknowns are the values of the connections at which a loop is cut. In initialization mode
//! a pass sets and reads the members in their order; at a step it takes them back to its
//! beginning first (fmi2SetFMUstate) and steps them again.

use super::engine::{Engine, copy, exchange};
use super::newton::{self, Outcome};
use super::plan::Cut;
use crate::error::Result;
use crate::time::Time;

/// What the iterations of one loop needed.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Effort {
    /// How often the loop was solved.
    pub solved: u64,
    /// Passes of all of these together.
    pub passes: u64,
    /// How often it could not be solved, when first, and how far off it was then.
    pub failed: u64,
    pub first: Time,
    pub residual: f64,
}

impl Effort {
    fn add(&mut self, outcome: Outcome, now: Time) {
        self.solved += 1;
        self.passes += u64::from(outcome.passes);
        if !outcome.converged() {
            if self.failed == 0 {
                (self.first, self.residual) = (now, outcome.residual);
            }
            self.failed += 1;
        }
    }
}

impl Engine {
    /// Solves a loop in initialization mode.
    pub(super) fn solve_initially(&mut self, position: usize) -> Result<()> {
        let found = &self.plan.loops[position];
        let (cuts, members) = (found.cuts.clone(), found.members.clone());
        for &c in &members {
            copy(&self.plan.nodes[c].held, &self.values, &mut self.inputs);
        }
        let outcome = self.solve(&cuts, &mut |engine| {
            for &c in &members {
                let node = &engine.plan.nodes[c];
                copy(&node.fresh, &engine.values, &mut engine.inputs);
                exchange(node, &mut *engine.slaves[c], &engine.inputs, &mut engine.values)?;
            }
            Ok(())
        })?;
        self.efforts[position].add(outcome, self.start);
        Ok(())
    }

    /// Steps the members of a loop whose steps end now.
    pub(super) fn step_loop(&mut self, position: usize, now: Time) -> Result<()> {
        let found = &self.plan.loops[position];
        let active = |c: usize| self.ends[c] == now;
        let members: Vec<usize> = found.members.iter().copied().filter(|&c| active(c)).collect();
        let (cuts, known): (Vec<Cut>, Vec<Cut>) =
            found.cuts.iter().filter(|cut| active(cut.to)).partition(|cut| active(cut.from));
        known.iter().for_each(|cut| self.inputs[cut.route.to] = self.values[cut.route.from]);
        if cuts.is_empty() {
            return members.iter().try_for_each(|&c| self.step_one(c, now));
        }
        for &c in &members {
            self.slaves[c].save()?;
        }
        let mut first = true;
        let outcome = self.solve(&cuts, &mut |engine| {
            for &c in &members {
                if !first {
                    let begin = now - engine.plan.nodes[c].step;
                    engine.slaves[c].restore(begin)?;
                }
                engine.step_one(c, now)?;
            }
            first = false;
            Ok(())
        })?;
        self.efforts[position].add(outcome, now);
        Ok(())
    }

    /// Solves for the values of `cuts`; `pass` computes all outputs from the inputs.
    fn solve(
        &mut self,
        cuts: &[Cut],
        pass: &mut dyn FnMut(&mut Self) -> Result<()>,
    ) -> Result<Outcome> {
        let mut unknown: Vec<f64> = cuts.iter().map(|cut| self.values[cut.route.from]).collect();
        newton::solve(&mut unknown, &mut |v, image| {
            for (cut, v) in cuts.iter().zip(v) {
                self.inputs[cut.route.to] = *v;
            }
            pass(self)?;
            for (cut, image) in cuts.iter().zip(image) {
                *image = self.values[cut.route.from];
            }
            Ok(())
        })
    }
}
