//! Algebraic loops solved by iteration: during initialization and at steps.
//!
//! The unknowns are the values of the connections at which a loop is cut. In initialization mode, a
//! pass sets and reads the members in order; at a step it first takes them back to the start of the
//! step (fmi2SetFMUstate) and steps them again.

use serde::{Deserialize, Serialize};

use super::engine::{Engine, copy, exchange};
use super::newton::{self, Outcome};
use super::plan::Cut;
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::Time;
use cosim_import::{Place, Scalar};

/// Statistics of the iterations of one loop.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub struct Effort {
    /// How often the loop was solved.
    pub solved: u64,
    /// Total number of passes.
    pub passes: u64,
    /// Maximum number of passes of one solution.
    pub most: u32,
    /// The greatest residual, relative to 1 + |v|, that was accepted as a solution.
    pub residual: f64,
    /// How often the Jacobian was computed from directional derivatives, and by differences.
    pub directional: u64,
    pub differences: u64,
}

impl Effort {
    fn add(&mut self, outcome: Outcome) {
        self.solved += 1;
        self.passes += u64::from(outcome.passes);
        self.most = self.most.max(outcome.passes);
        self.residual = self.residual.max(outcome.residual);
        self.directional += u64::from(outcome.directional);
        self.differences += u64::from(outcome.differences);
    }

    /// Describes how the Jacobians were computed.
    pub(super) fn jacobian(&self) -> String {
        match (self.directional, self.differences) {
            (0, 0) => String::new(),
            (n, 0) => format!("; {n} Jacobians by directional derivatives"),
            (0, n) => format!("; {n} Jacobians by differences"),
            (n, m) => format!("; {n} Jacobians by directional derivatives, {m} by differences"),
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
        let outcome = self.solve(&cuts, &members, &mut |engine| {
            for &c in &members {
                let node = &engine.plan.nodes[c];
                copy(&node.fresh, &engine.values, &mut engine.inputs);
                exchange(node, &mut *engine.slaves[c], &engine.inputs, &mut engine.values)?;
            }
            Ok(())
        })?;
        self.solved(position, outcome, self.start)
    }

    /// Steps the members of a loop whose steps end now.
    pub(super) fn step_loop(&mut self, position: usize, now: Time) -> Result<()> {
        let found = &self.plan.loops[position];
        let active = |c: usize| self.due(c, now);
        let members: Vec<usize> = found.members.iter().copied().filter(|&c| active(c)).collect();
        let (cuts, known): (Vec<Cut>, Vec<Cut>) =
            found.cuts.iter().filter(|cut| active(cut.to)).partition(|cut| active(cut.from));
        known.iter().for_each(|cut| self.inputs[cut.route.to] = self.values[cut.route.from]);
        if cuts.is_empty() {
            return members.iter().try_for_each(|&c| self.step_one(c, now));
        }
        for &c in &members {
            self.slaves[c].save(Place::Iteration)?;
        }
        let mut first = true;
        let outcome = self.solve(&cuts, &members, &mut |engine| {
            for &c in &members {
                if !first {
                    let begin = now - engine.paces[c].length;
                    engine.slaves[c].restore(Place::Iteration, begin)?;
                }
                engine.step_one(c, now)?;
            }
            first = false;
            Ok(())
        })?;
        self.solved(position, outcome, now)
    }

    /// Counts a solution; an error if there is none, unless the step is rolled back anyway.
    fn solved(&mut self, position: usize, outcome: Outcome, now: Time) -> Result<()> {
        if outcome.converged() {
            self.efforts[position].add(outcome);
            return Ok(());
        }
        if self.control.is_some() && now > self.start {
            let begin = self.control.as_ref().map_or(now, |control| control.now);
            self.discarded = Some(begin);
            return Ok(());
        }
        let names = &self.plan.loops[position].names;
        Err(Error::new(
            Code::Loop,
            format!("the loop through {names} has no solution at t = {now}"),
        )
        .why(format!(
            "after {} passes the residual is {:.1e}, relative to 1 + |value|; the limit is {:.0e}",
            outcome.passes,
            outcome.residual,
            newton::SOLVED
        ))
        .help("a smaller --step, or --algorithm gauss-seidel, which cuts the loop"))
    }

    /// Solves for the values of `cuts`; `pass` computes all outputs from the inputs.
    fn solve(
        &mut self,
        cuts: &[Cut],
        members: &[usize],
        pass: &mut dyn FnMut(&mut Self) -> Result<()>,
    ) -> Result<Outcome> {
        let mut unknown: Vec<f64> = cuts.iter().map(|cut| cut.number(&self.values)).collect();
        newton::solve(&mut unknown, &mut OneLoop { engine: self, cuts, members, pass })
    }

    /// How the outputs at the cuts change with the input at `seeded`, by chaining the members' own
    /// directional derivatives; `false` if a member has none.
    fn loop_tangent(
        &mut self,
        cuts: &[Cut],
        members: &[usize],
        seeded: usize,
        column: &mut [f64],
    ) -> Result<bool> {
        let mut changes = vec![0.0; self.values.len()];
        for &c in members {
            let node = &self.plan.nodes[c];
            let mut seed = vec![0.0; node.input_slots.len()];
            for route in &node.fresh {
                seed[route.to - node.input_slots.start] = changes[route.from];
            }
            let cut = &cuts[seeded];
            if cut.to == c {
                seed[cut.route.to - node.input_slots.start] = 1.0;
            }
            let outputs = &mut changes[node.output_slots.clone()];
            if !self.slaves[c].tangent(&seed, outputs)? {
                return Ok(false);
            }
        }
        for (change, cut) in column.iter_mut().zip(cuts) {
            *change = changes[cut.route.from];
        }
        Ok(true)
    }
}

/// One loop as the function whose fixed point is sought.
struct OneLoop<'a, 'p> {
    engine: &'a mut Engine,
    cuts: &'a [Cut],
    members: &'a [usize],
    pass: &'a mut (dyn FnMut(&mut Engine) -> Result<()> + 'p),
}

impl newton::Function for OneLoop<'_, '_> {
    fn value(&mut self, v: &[f64], image: &mut [f64]) -> Result<()> {
        for (cut, v) in self.cuts.iter().zip(v) {
            self.engine.inputs[cut.route.to] = Scalar::of_number(cut.basic, *v);
        }
        (self.pass)(self.engine)?;
        for (cut, image) in self.cuts.iter().zip(image) {
            *image = cut.number(&self.engine.values);
        }
        Ok(())
    }

    fn column(&mut self, position: usize, column: &mut [f64]) -> Result<bool> {
        self.engine.loop_tangent(self.cuts, self.members, position, column)
    }
}
