//! The scheduler. Nothing here allocates, hashes or compares text while stepping.

use std::time::Instant;

use super::Made;
use super::control::Control;
use super::direct::Steps;
use super::iterate::Effort;
use super::meter::Meter;
use super::patched_slave::SharedPatches;
use super::plan::{Node, Plan, Route};
use super::slave::Slave;
use super::trend::{Ramp, Trend};
use cosim_base::error::Result;
use cosim_base::time::{Step, Time};
use cosim_import::Scalar;

/// Steps components as planned, and passes on their values.
pub struct Engine {
    /// Which component steps when.
    pub plan: Plan,
    /// The plan in the form used for stepping.
    pub(super) steps: Steps,
    /// Recorded variables that are not used otherwise.
    reading: Vec<usize>,
    /// Where the current sequence of steps ends: recorded variables are read there.
    pub(super) limit: Time,
    pub(crate) slaves: Vec<Box<dyn Slave>>,
    /// What components have put out, by the slots of the plan.
    pub values: Vec<Scalar>,
    pub(super) inputs: Vec<Scalar>,
    /// For each component.
    pub(super) paces: Vec<Pace>,
    /// When the first of the current steps ends.
    pub(super) next: Time,
    pub(super) start: Time,
    /// Components whose step is not an integer number of nanoseconds.
    uneven: Vec<(usize, Step)>,
    /// For each loop of the plan.
    pub(super) efforts: Vec<Effort>,
    /// For each trend and each ramp of the plan.
    pub(super) trends: Vec<Trend>,
    pub(super) ramps: Vec<Ramp>,
    /// For each component that was manipulated.
    pub(super) patches: Vec<Option<SharedPatches>>,
    pub(super) meter: Meter,
    watch: Watch,
    /// The error control, if steps are controlled.
    pub(super) control: Option<Control>,
    /// A component discarded the current step, and reached this instant.
    pub(super) discarded: Option<Time>,
    pub(super) warnings: Vec<String>,
}

/// When the process is checked (`cosim_import::guard`): after each of the first steps, which
/// identifies the component that changed it, and then at intervals.
const WATCHED_FIRST: usize = 64;
const WATCHED_EVERY: usize = 4096;

#[derive(Default)]
struct Watch {
    first: usize,
    since: usize,
    /// The component to check next.
    turn: usize,
}

/// The time of a component.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pace {
    /// When its current step ends, and how long it is.
    pub end: Time,
    pub length: Time,
    /// How many steps it has made.
    pub made: u64,
    /// The instant at which a step read the Reals that are only recorded.
    pub read_at: Time,
}

impl Pace {
    fn new(start: Time, step: Step) -> Self {
        let length = step.rounded();
        Self { end: start + length, length, made: 0, read_at: Time::NEVER }
    }
}

impl Engine {
    /// At the start time.
    pub fn new(plan: Plan, made: Vec<Made>, start: Time) -> Self {
        let those = |which: &dyn Fn(&Node) -> bool| -> Vec<usize> {
            (0..plan.nodes.len()).filter(|&c| which(&plan.nodes[c])).collect()
        };
        let (slaves, patches): (Vec<_>, _) = made.into_iter().unzip();
        Self {
            steps: Steps::new(&plan, &slaves),
            limit: start,
            reading: those(&|node| !node.recorded.is_empty()),
            values: vec![Scalar::default(); plan.values],
            inputs: vec![Scalar::default(); plan.inputs],
            next: plan
                .nodes
                .iter()
                .map(|node| start + node.step.rounded())
                .min()
                .unwrap_or(Time::NEVER),
            uneven: (plan.nodes.iter().map(|node| node.step).enumerate())
                .filter(|(_, step)| !step.is_whole())
                .collect(),
            paces: plan.nodes.iter().map(|node| Pace::new(start, node.step)).collect(),
            efforts: vec![Effort::default(); plan.loops.len()],
            trends: vec![Trend::default(); plan.trends.len()],
            ramps: vec![Ramp::default(); plan.ramps.len()],
            patches,
            meter: Meter::new(plan.nodes.len()),
            watch: Watch::default(),
            control: None,
            discarded: None,
            plan,
            slaves,
            start,
            warnings: Vec::new(),
        }
    }

    /// Initializes all components with values that are consistent along all connections.
    pub(crate) fn initialize(&mut self, stop: Time) -> Result<()> {
        self.enter(stop)?;
        self.settle()?;
        self.exit()?;
        self.begin()
    }

    /// Enters initialization mode.
    pub fn enter(&mut self, stop: Time) -> Result<()> {
        for &c in &self.plan.sequence {
            self.slaves[c].enter_initialization(self.start, stop)?;
            self.warnings.extend(self.slaves[c].warnings());
        }
        self.get_all()
    }

    /// Passes values on until none changes in any bit. If loops are solved, everything fresh is
    /// final after one pass; a second one passes on the held inputs, on which no output depends
    /// directly.
    pub(crate) fn settle(&mut self) -> Result<()> {
        let mut before = Vec::with_capacity(self.values.len());
        for _ in 0..passes(&self.plan) {
            before.clone_from(&self.values);
            self.with_sequence(|engine, sequence| engine.pass(sequence))?;
            if before == self.values {
                return Ok(());
            }
        }
        if self.plan.loops.is_empty() {
            self.warnings.push(UNSETTLED.to_owned());
        }
        Ok(())
    }

    /// One exchange of values in initialization mode.
    pub fn pass(&mut self, members: &[usize]) -> Result<()> {
        let mut place = 0;
        while let Some(&c) = members.get(place) {
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
        Ok(())
    }

    /// Leaves initialization mode.
    pub fn exit(&mut self) -> Result<()> {
        for &c in &self.plan.sequence {
            self.slaves[c].exit_initialization()?;
            self.warnings.extend(self.slaves[c].warnings());
        }
        self.get_all()
    }

    /// Begins the first step of every component.
    pub fn begin(&mut self) -> Result<()> {
        for node in &self.plan.nodes {
            copy(&node.held, &self.values, &mut self.inputs);
        }
        self.steps = Steps::new(&self.plan, &self.slaves);
        self.begin_trends()
    }

    fn get_all(&mut self) -> Result<()> {
        for &c in &self.plan.sequence {
            let node = &self.plan.nodes[c];
            self.slaves[c].get(&mut self.values[node.output_slots.clone()])?;
        }
        Ok(())
    }

    /// Lends the stepping order without a copy.
    #[inline]
    fn with_sequence<T>(&mut self, act: impl FnOnce(&mut Self, &[usize]) -> T) -> T {
        let sequence = std::mem::take(&mut self.plan.sequence);
        let result = act(self, &sequence);
        self.plan.sequence = sequence;
        result
    }

    /// Whether the current step of a component ends now.
    #[inline]
    pub fn due(&self, component: usize, now: Time) -> bool {
        self.paces[component].end == now
    }

    /// The maximum number of instants until `limit` at which steps end, if the error control does
    /// not add more.
    pub(crate) fn instants_until(&self, limit: Time) -> u64 {
        let (rest, shortest) = (
            limit.ns().saturating_sub(self.next.ns()).max(0),
            self.plan.nodes.iter().map(|node| node.step.rounded().ns()).min().unwrap_or(i64::MAX),
        );
        rest.unsigned_abs() / shortest.max(1).unsigned_abs()
    }

    /// Makes every step that ends at or before `limit`.
    pub(crate) fn run_until(&mut self, limit: Time) -> Result<()> {
        if self.control.is_some() {
            return self.run_controlled(limit);
        }
        self.limit = limit;
        while self.next <= limit {
            self.instant(self.next)?;
        }
        Ok(())
    }

    /// Makes the steps that end now.
    pub(super) fn instant(&mut self, now: Time) -> Result<()> {
        self.meter.instant();
        self.watch(self.plan.nodes.len());
        if self.meter.timing || !self.plan.loops.is_empty() {
            self.with_sequence(|engine, sequence| engine.step_members(sequence, now))?;
        } else {
            self.step_plain(now)?;
        }
        self.begin_steps(now)
    }

    /// The first half of an instant: every step of `members` that ends now, in order.
    pub fn end_steps(&mut self, members: &[usize], now: Time) -> Result<()> {
        self.meter.instant();
        self.watch(members.len());
        self.step_members(members, now)
    }

    /// The second half: components that ended a step begin the next one, with the values held
    /// during it.
    #[inline]
    pub fn begin_steps(&mut self, now: Time) -> Result<()> {
        if !self.ramps.is_empty() {
            self.follow(now)?;
        }
        self.hold(now);
        if !self.uneven.is_empty() {
            self.measure(now);
        }
        self.next = Time::NEVER;
        for pace in &mut self.paces {
            if pace.end == now {
                pace.end = now + pace.length;
            }
            self.next = self.next.min(pace.end);
        }
        Ok(())
    }

    /// The lengths of the steps that begin now, if they differ from step to step.
    #[cold]
    fn measure(&mut self, now: Time) {
        for &(component, step) in &self.uneven {
            let pace = &mut self.paces[component];
            if pace.end == now {
                pace.length = step.after(now - self.start) - now + self.start;
            }
        }
    }

    /// Sets when the current step of a component ends.
    pub(super) fn ends_at(&mut self, component: usize, end: Time) {
        let (step, pace) = (self.plan.nodes[component].step, &mut self.paces[component]);
        let before = step.multiple(step.count(end - self.start) - 1);
        (pace.end, pace.length) = (end, end - self.start - before);
    }

    /// Ends the run: components that can make a shorter step from the end of their last one.
    pub(crate) fn conclude(&mut self, now: Time) -> Result<()> {
        if self.control.is_some() {
            return Ok(());
        }
        self.shorten(now);
        self.limit = now;
        self.instant(now)
    }

    /// Makes steps that would end later end now.
    pub fn shorten(&mut self, now: Time) {
        for (pace, node) in self.paces.iter_mut().zip(&self.plan.nodes) {
            let begun = pace.end - pace.length;
            if node.variable && pace.end > now && begun < now {
                (pace.length, pace.end) = (now - begun, now);
            }
        }
    }

    /// Every step of `members` that ends now, with loops and timing.
    #[inline(never)]
    fn step_members(&mut self, members: &[usize], now: Time) -> Result<()> {
        let mut place = 0;
        while let Some(&c) = members.get(place) {
            // The members of a loop are adjacent in the sequence.
            if let Some(found) = self.plan.nodes[c].member_of {
                self.step_loop(found, now)?;
                place += self.plan.loops[found].members.len();
                continue;
            }
            if self.due(c, now) {
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
        if self.watch.first < WATCHED_FIRST {
            self.watch.first += 1;
            self.slaves[c].check_process("a step");
        }
        Ok(())
    }

    /// Occasionally checks whether the process has been changed; the cost per step is too small to
    /// measure. The component that is named was involved, others may have been.
    #[inline]
    fn watch(&mut self, steps: usize) {
        self.watch.since += steps;
        if self.watch.since >= WATCHED_EVERY {
            self.watch.since = 0;
            self.watch_now();
        }
    }

    #[cold]
    fn watch_now(&mut self) {
        self.watch.turn = (self.watch.turn + 1) % self.slaves.len().max(1);
        let alone = self.slaves.len() == 1;
        if let Some(slave) = self.slaves.get_mut(self.watch.turn) {
            slave.check_process(if alone {
                "a step"
            } else {
                "a step of this or another component"
            });
        }
    }

    pub(super) fn step_untimed(&mut self, c: usize, now: Time) -> Result<()> {
        let (node, pace) = (&self.plan.nodes[c], &mut self.paces[c]);
        let (slave, length) = (&mut *self.slaves[c], pace.length);
        pace.made += 1;
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
        let (node, slave) = (&self.plan.nodes[c], &mut self.slaves[c]);
        let length = self.paces[c].length;
        let reached = slave.step(now - length, length)?;
        if reached != now {
            return self.stopped_short(reached);
        }
        slave.get(&mut self.values[node.output_slots.clone()])
    }

    /// The component discarded its step: its outputs are not read, because the step is rolled back.
    #[cold]
    fn stopped_short(&mut self, reached: Time) -> Result<()> {
        self.discarded = Some(self.discarded.map_or(reached, |so_far| so_far.min(reached)));
        Ok(())
    }

    /// Warnings so far.
    pub(crate) fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }

    /// Sets the current instant in all slaves, which direct steps do not do.
    pub(crate) fn come_to(&mut self, now: Time) {
        self.slaves.iter_mut().for_each(|slave| slave.came_to(now));
    }

    /// Reads the variables that are only recorded, if no step has read them.
    pub fn read_recorded(&mut self, now: Time) -> Result<()> {
        for place in 0..self.reading.len() {
            let component = self.reading[place];
            if !self.has_read(component, now) || self.steps.reads_partly(component) {
                self.read_of(component, now)?;
            }
        }
        Ok(())
    }

    /// Whether the Reals among those of a component were read by its step that ends now.
    #[inline]
    pub(crate) fn has_read(&self, component: usize, now: Time) -> bool {
        self.paces[component].read_at == now
    }

    /// Reads those of one component.
    pub(crate) fn read_of(&mut self, component: usize, now: Time) -> Result<()> {
        self.slaves[component].came_to(now);
        let slots = self.plan.nodes[component].recorded_slots.clone();
        self.slaves[component].read(&mut self.values[slots])
    }
}

/// The warning if initial values do not settle.
pub const UNSETTLED: &str = "the initial values still changed after the last pass: an \
     algebraic loop does not settle; the run begins with the values of that pass";

/// The maximum number of passes in initialization mode.
pub fn passes(plan: &Plan) -> usize {
    if plan.loops.is_empty() { plan.nodes.len() + 1 } else { 2 }
}

#[inline]
pub(super) fn copy(routes: &[Route], values: &[Scalar], inputs: &mut [Scalar]) {
    for route in routes {
        inputs[route.to] = values[route.from];
    }
}

pub(super) fn exchange(
    node: &Node,
    slave: &mut dyn Slave,
    inputs: &[Scalar],
    values: &mut [Scalar],
) -> Result<()> {
    if !node.input_slots.is_empty() {
        slave.set(&inputs[node.input_slots.clone()])?;
    }
    slave.get(&mut values[node.output_slots.clone()])
}
