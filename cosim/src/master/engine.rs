//! The scheduler. Nothing here allocates, hashes or compares text while stepping.

use std::time::Instant;

use super::control::Control;
use super::direct::Steps;
use super::iterate::Effort;
use super::meter::Meter;
use super::patched_slave::SharedPatches;
use super::plan::{Node, Plan, Route};
use super::slave::Slave;
use super::trend::{Ramp, Trend};
use crate::error::Result;
use crate::time::Time;

pub(super) struct Engine {
    pub(super) plan: Plan,
    /// The plan once more, as stepping reads it.
    pub(super) steps: Steps,
    /// Those of which variables are recorded that nobody else needs.
    reading: Vec<usize>,
    pub(super) slaves: Vec<Box<dyn Slave>>,
    pub(super) values: Vec<f64>,
    pub(super) inputs: Vec<f64>,
    /// When each component's present step ends, and how long it is.
    pub(super) ends: Vec<Time>,
    pub(super) lengths: Vec<Time>,
    /// How many steps each component made.
    pub(super) made: Vec<u64>,
    pub(super) start: Time,
    /// Per loop of the plan.
    pub(super) efforts: Vec<Effort>,
    /// Per trend and per ramp of the plan.
    pub(super) trends: Vec<Trend>,
    pub(super) ramps: Vec<Ramp>,
    /// Of the components that were manipulated.
    pub(super) patches: Vec<Option<SharedPatches>>,
    pub(super) meter: Meter,
    /// The error control, if steps have one.
    pub(super) control: Option<Control>,
    /// A component discarded the step being made, and came as far as this.
    pub(super) discarded: Option<Time>,
    pub(super) warnings: Vec<String>,
}

impl Engine {
    pub(super) fn new(plan: Plan, slaves: Vec<Box<dyn Slave>>, start: Time) -> Self {
        let those = |which: &dyn Fn(&Node) -> bool| -> Vec<usize> {
            (0..plan.nodes.len()).filter(|&c| which(&plan.nodes[c])).collect()
        };
        Self {
            steps: Steps::new(&plan, &slaves),
            reading: those(&|node| !node.recorded.is_empty()),
            values: vec![0.0; plan.values],
            inputs: vec![0.0; plan.inputs],
            ends: plan.nodes.iter().map(|node| start + node.step).collect(),
            lengths: plan.nodes.iter().map(|node| node.step).collect(),
            made: vec![0; plan.nodes.len()],
            efforts: vec![Effort::default(); plan.loops.len()],
            trends: vec![Trend::default(); plan.trends.len()],
            ramps: vec![Ramp::default(); plan.ramps.len()],
            patches: vec![None; plan.nodes.len()],
            meter: Meter::new(plan.nodes.len()),
            control: None,
            discarded: None,
            plan,
            slaves,
            start,
            warnings: Vec::new(),
        }
    }

    /// The messages of every slave, by position.
    pub(super) fn messages(&mut self) -> Vec<Vec<String>> {
        self.slaves.iter_mut().map(|slave| slave.messages()).collect()
    }

    /// Initializes all components with values that agree along all connections.
    pub(super) fn initialize(&mut self, stop: Time) -> Result<()> {
        for &c in &self.plan.sequence {
            self.slaves[c].enter_initialization(self.start, stop)?;
        }
        self.get_all()?;
        self.settle()?;
        for &c in &self.plan.sequence {
            self.slaves[c].exit_initialization()?;
        }
        self.get_all()?;
        for node in &self.plan.nodes {
            copy(&node.held, &self.values, &mut self.inputs);
        }
        self.begin_trends()
    }

    /// Passes values on until none changes in any bit.
    fn settle(&mut self) -> Result<()> {
        if !self.plan.loops.is_empty() {
            return self.settle_with_loops();
        }
        let mut before = vec![0; self.values.len()];
        for _ in 0..=self.plan.nodes.len() {
            before.iter_mut().zip(&self.values).for_each(|(b, v)| *b = v.to_bits());
            for &c in &self.plan.sequence {
                let node = &self.plan.nodes[c];
                copy(&node.held, &self.values, &mut self.inputs);
                copy(&node.fresh, &self.values, &mut self.inputs);
                exchange(node, &mut *self.slaves[c], &self.inputs, &mut self.values)?;
            }
            if before.iter().zip(&self.values).all(|(b, v)| *b == v.to_bits()) {
                return Ok(());
            }
        }
        self.warnings.push(
            "the initial values still changed after the last pass: an algebraic loop does not \
             settle; the run begins with the values of that pass"
                .to_owned(),
        );
        Ok(())
    }

    /// In the order of the system everything fresh is final after one pass; a second one brings
    /// the held inputs, on which no output depends directly.
    fn settle_with_loops(&mut self) -> Result<()> {
        for _ in 0..2 {
            let mut place = 0;
            while let Some(&c) = self.plan.sequence.get(place) {
                let node = &self.plan.nodes[c];
                if let Some(found) = node.member_of {
                    self.solve_initially(found)?;
                    place += self.plan.loops[found].members.len();
                    continue;
                }
                copy(&node.held, &self.values, &mut self.inputs);
                copy(&node.fresh, &self.values, &mut self.inputs);
                exchange(node, &mut *self.slaves[c], &self.inputs, &mut self.values)?;
                place += 1;
            }
        }
        Ok(())
    }

    fn get_all(&mut self) -> Result<()> {
        for &c in &self.plan.sequence {
            let node = &self.plan.nodes[c];
            self.slaves[c].get(&mut self.values[node.output_slots.clone()])?;
        }
        Ok(())
    }

    /// Makes every step that ends at or before `limit`.
    pub(super) fn run_until(&mut self, limit: Time) -> Result<()> {
        if self.control.is_some() {
            return self.run_controlled(limit);
        }
        let mut next = self.ends.iter().min().copied();
        while let Some(now) = next.filter(|&now| now <= limit) {
            next = self.instant(now)?;
        }
        Ok(())
    }

    /// Makes the steps that end now; when the next ones end.
    pub(super) fn instant(&mut self, now: Time) -> Result<Option<Time>> {
        self.meter.instant();
        if self.meter.timing || !self.plan.loops.is_empty() {
            self.step_all(now)?;
        } else {
            self.step_plain(now)?;
        }
        if !self.ramps.is_empty() {
            self.follow(now)?;
        }
        self.hold(now);
        for (end, length) in self.ends.iter_mut().zip(&self.lengths) {
            if *end == now {
                *end = now + *length;
            }
        }
        Ok(self.ends.iter().min().copied())
    }

    /// Every step that ends now, with loops and the clock.
    fn step_all(&mut self, now: Time) -> Result<()> {
        let mut place = 0;
        while let Some(&c) = self.plan.sequence.get(place) {
            // The members of a loop follow one another in the sequence.
            if let Some(found) = self.plan.nodes[c].member_of {
                self.step_loop(found, now)?;
                place += self.plan.loops[found].members.len();
                continue;
            }
            if self.ends[c] == now {
                self.step_one(c, now)?;
            }
            place += 1;
        }
        Ok(())
    }

    /// Makes the step of one component that ends now.
    pub(super) fn step_one(&mut self, c: usize, now: Time) -> Result<()> {
        if self.meter.timing {
            return self.step_timed(c, now);
        }
        self.step_untimed(c, now)
    }

    #[cold]
    fn step_timed(&mut self, c: usize, now: Time) -> Result<()> {
        let begun = Instant::now();
        self.step_untimed(c, now)?;
        self.meter.timed(c, begun.elapsed());
        Ok(())
    }

    pub(super) fn step_untimed(&mut self, c: usize, now: Time) -> Result<()> {
        let (node, length) = (&self.plan.nodes[c], self.lengths[c]);
        let slave = &mut *self.slaves[c];
        self.made[c] += 1;
        copy(&node.fresh, &self.values, &mut self.inputs);
        if node.ramped {
            return self.step_ramped(c, now);
        }
        let inputs = &self.inputs[node.input_slots.clone()];
        let outputs = &mut self.values[node.output_slots.clone()];
        let reached = slave.advance(inputs, now - length, length, outputs)?;
        if reached == now { Ok(()) } else { self.stopped_short(reached) }
    }

    /// The same with inputs that move.
    #[cold]
    fn step_ramped(&mut self, c: usize, now: Time) -> Result<()> {
        self.set_ramps(c, now)?;
        let (node, slave, length) = (&self.plan.nodes[c], &mut self.slaves[c], self.lengths[c]);
        let reached = slave.step(now - length, length)?;
        if reached != now {
            return self.stopped_short(reached);
        }
        slave.get(&mut self.values[node.output_slots.clone()])
    }

    /// The component discarded its step: nobody looks at its outputs, for the step is taken back.
    #[cold]
    fn stopped_short(&mut self, reached: Time) -> Result<()> {
        self.discarded = Some(self.discarded.map_or(reached, |so_far| so_far.min(reached)));
        Ok(())
    }

    /// Tells all slaves the present instant, which direct steps do not.
    pub(super) fn come_to(&mut self, now: Time) {
        self.slaves.iter_mut().for_each(|slave| slave.came_to(now));
    }

    /// The recorded values of the present instant.
    pub(super) fn sample(&mut self, now: Time, row: &mut [f64]) -> Result<()> {
        for &c in &self.reading {
            self.slaves[c].came_to(now);
            let slots = self.plan.nodes[c].recorded_slots.clone();
            self.slaves[c].read(&mut self.values[slots])?;
        }
        for (value, &slot) in row.iter_mut().zip(&self.plan.columns) {
            *value = self.values[slot];
        }
        Ok(())
    }
}

#[inline]
pub(super) fn copy(routes: &[Route], values: &[f64], inputs: &mut [f64]) {
    for route in routes {
        inputs[route.to] = values[route.from];
    }
}

pub(super) fn exchange(
    node: &Node,
    slave: &mut dyn Slave,
    inputs: &[f64],
    values: &mut [f64],
) -> Result<()> {
    if !node.input_slots.is_empty() {
        slave.set(&inputs[node.input_slots.clone()])?;
    }
    slave.get(&mut values[node.output_slots.clone()])
}
