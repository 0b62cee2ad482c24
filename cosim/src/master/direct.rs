//! The steps of an instant, laid out as memory is read.
//!
//! A system of hundreds of small FMUs costs what its cache lines cost. Here all that a plain step
//! touches stands in a few arrays in the order of stepping: a record of one cache line per
//! component, value references and routes one after the other, and the engine's own flat arrays.
//! A step is then: copy the fresh inputs, `fmi2SetReal`, `fmi2DoStep`, `fmi2GetReal`.
//!
//! Plain are co-simulation FMUs whose connected variables are Reals, without conversions,
//! manipulations, moving inputs, followed calls, retries or error control. All others have an
//! empty record and step through [`Slave`]; so do plain ones at instants that are timed, and at
//! their first call that does not go well.

use std::ops::Range;

use super::engine::{Engine, copy};
use super::plan::{Plan, Route};
use super::slave::{DirectCalls, Slave};
use crate::error::Result;
use crate::fmi::Direct;
use crate::time::Time;

/// The steps of all components in their order, and the inputs that are held.
#[derive(Default)]
pub(super) struct Steps {
    records: Vec<Record>,
    /// Of each component its inputs', then its outputs'.
    references: Vec<u32>,
    routes: Vec<Route>,
    held: Vec<Held>,
}

/// One component's step.
#[repr(C, align(64))]
struct Record {
    /// None: by its slave.
    calls: Option<Direct>,
    component: u32,
    references: u32,
    inputs: Slots,
    outputs: Slots,
    routes: Slots,
}

/// Places in an array: half the size of a `Range<usize>`, so that a record fits its line.
#[derive(Clone, Copy, Default)]
struct Slots {
    start: u32,
    count: u32,
}

/// An input that gets its value when a step of its component begins.
struct Held {
    component: usize,
    route: Route,
}

impl Slots {
    /// None where the numbers are too great.
    fn new(range: &Range<usize>) -> Option<Self> {
        Some(Self { start: narrow(range.start)?, count: narrow(range.len())? })
    }

    #[inline(always)]
    fn range(self) -> Range<usize> {
        self.start as usize..self.start as usize + self.count as usize
    }
}

fn narrow(number: usize) -> Option<u32> {
    u32::try_from(number).ok()
}

impl Steps {
    pub(super) fn new(plan: &Plan, slaves: &[Box<dyn Slave>]) -> Self {
        let mut steps = Self::default();
        for &c in &plan.sequence {
            let record = steps.record(plan, &*slaves[c], c);
            steps.records.push(record.unwrap_or(Record::by_slave()));
        }
        for (component, node) in plan.nodes.iter().enumerate() {
            steps.held.extend(node.held.iter().map(|&route| Held { component, route }));
        }
        steps
    }

    fn record(&mut self, plan: &Plan, slave: &dyn Slave, c: usize) -> Option<Record> {
        let node = &plan.nodes[c];
        if node.ramped {
            return None;
        }
        let DirectCalls { calls, inputs, outputs } = slave.direct()?;
        let routes = self.routes.len()..self.routes.len() + node.fresh.len();
        let record = Record {
            calls: Some(calls),
            component: narrow(c)?,
            references: narrow(self.references.len())?,
            inputs: Slots::new(&node.input_slots)?,
            outputs: Slots::new(&node.output_slots)?,
            routes: Slots::new(&routes)?,
        };
        debug_assert_eq!((inputs.len(), outputs.len()), (node.inputs.len(), node.outputs.len()));
        self.references.extend(inputs.iter().chain(outputs));
        self.routes.extend_from_slice(&node.fresh);
        Some(record)
    }

    /// From now on this component steps by its slave.
    pub(super) fn leave(&mut self, component: usize, plan: &Plan) {
        for (record, _) in
            self.records.iter_mut().zip(&plan.sequence).filter(|(_, c)| **c == component)
        {
            record.calls = None;
        }
    }
}

impl Record {
    fn by_slave() -> Self {
        let none = Slots::default();
        let (inputs, outputs, routes) = (none, none, none);
        Self { calls: None, component: 0, references: 0, inputs, outputs, routes }
    }
}

impl Engine {
    /// Makes the steps that end now.
    pub(super) fn step_plain(&mut self, now: Time) -> Result<()> {
        let mut place = self.step_directly(0, now)?;
        while let Some(&c) = self.plan.sequence.get(place) {
            if self.ends[c] == now {
                self.step_untimed(c, now)?;
            }
            place = self.step_directly(place + 1, now)?;
        }
        Ok(())
    }

    /// Makes those from a place of the sequence on, up to the first that needs its slave: where
    /// that is.
    fn step_directly(&mut self, first: usize, now: Time) -> Result<usize> {
        let Self { steps, values, inputs, .. } = self;
        // Instants in seconds, for components with the same step.
        let (mut length, mut seconds) = (Time::ZERO, (0.0, 0.0));
        for (place, record) in steps.records.iter().enumerate().skip(first) {
            let Some(calls) = &record.calls else {
                return Ok(place);
            };
            let c = record.component as usize;
            if self.ends[c] != now {
                continue;
            }
            if self.lengths[c] != length {
                length = self.lengths[c];
                seconds = ((now - length).seconds(), length.seconds());
            }
            self.made[c] += 1;
            copy(&steps.routes[record.routes.range()], values, inputs);
            let own = &inputs[record.inputs.range()];
            let results = &mut values[record.outputs.range()];
            let (set, get) = steps.references[record.references as usize..].split_at(own.len());
            let get = &get[..results.len()];
            // SAFETY: the record is made of a slave of this engine, which keeps the instance alive;
            // after its initialization it stays `Ready` until a call fails, which ends the run. The
            // arrays are as long as their references, see the two lines above.
            let done = unsafe { calls.advance((set, own), seconds, (get, results)) };
            if let Err(found) = done {
                self.slaves[c].conclude(found, now - length, length)?;
            }
        }
        Ok(steps.records.len())
    }

    /// Gives the components whose next step begins now their held inputs.
    pub(super) fn hold(&mut self, now: Time) {
        for held in &self.steps.held {
            if self.ends[held.component] == now {
                self.inputs[held.route.to] = self.values[held.route.from];
            }
        }
    }
}
