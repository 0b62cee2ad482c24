//! The steps of an instant, laid out for sequential memory access.
//!
//! The cost of a system of hundreds of small FMUs is the cost of its cache lines. Here everything
//! that a plain step uses is in a few arrays in stepping order: a line per component with the calls
//! of its FMU (`cosim_import::DirectSteps`) and its positions, value references and routes one after
//! another, and the engine's own flat arrays. A step then consists of: copying the fresh inputs,
//! `fmi2SetReal`, `fmi2DoStep`, and `fmi2GetReal`, which at recorded instants also reads the Reals
//! that are only recorded.
//!
//! Plain components are co-simulation FMUs whose connected variables are Reals, without
//! conversions, manipulations, moving inputs, followed calls, retries or error control. All others
//! have an empty line and step through [`Slave`]; so do plain ones at instants that are timed, and
//! after their first call that does not succeed.

use std::ops::Range;

use super::engine::{Engine, copy};
use super::plan::{Node, Plan, Route};
use super::slave::{DirectCalls, Slave};
use cosim_base::error::Result;
use cosim_base::time::Time;
use cosim_import::DirectSteps;
use cosim_import::guard::Steady;

/// The steps of all components in order, and the inputs that are held.
pub(super) struct Steps {
    direct: DirectSteps<Places>,
    /// The fresh inputs of all steps, one step after another.
    routes: Vec<Route>,
    held: Vec<Held>,
    /// For each component: of the variables that are only recorded, Reals are read in the step,
    /// others are not.
    partly: Vec<bool>,
    /// What each step must leave as it was.
    float: Steady,
}

/// The positions of a component's values in the engine's arrays; small, so that they and its calls
/// fit into a cache line.
#[derive(Default)]
struct Places {
    component: u32,
    inputs: u32,
    /// Variables that are only recorded come after the outputs.
    outputs: u32,
    recorded: u16,
    route_count: u16,
    routes: u32,
}

/// An input that gets its value when a step of its component begins.
struct Held {
    component: usize,
    route: Route,
}

#[inline(always)]
fn range(start: u32, count: usize) -> Range<usize> {
    start as usize..start as usize + count
}

impl Places {
    /// `None` if the numbers are too large.
    fn new(component: usize, node: &Node, routes: usize, recorded: usize) -> Option<Self> {
        let start = |number: usize| u32::try_from(number).ok();
        let count = |number: usize| u16::try_from(number).ok();
        Some(Self {
            component: start(component)?,
            inputs: start(node.input_slots.start)?,
            outputs: start(node.output_slots.start)?,
            recorded: count(recorded)?,
            route_count: count(node.fresh.len())?,
            routes: start(routes)?,
        })
    }
}

impl Steps {
    /// For slaves that are initialized; otherwise all steps are made by the slaves.
    pub(super) fn new(plan: &Plan, slaves: &[Box<dyn Slave>]) -> Self {
        let mut steps = Self {
            direct: DirectSteps::default(),
            routes: Vec::new(),
            held: Vec::new(),
            partly: vec![false; plan.nodes.len()],
            float: Steady::now(),
        };
        for &c in &plan.sequence {
            steps.push(c, &plan.nodes[c], &*slaves[c]);
        }
        for (component, node) in plan.nodes.iter().enumerate() {
            steps.held.extend(node.held.iter().map(|&route| Held { component, route }));
        }
        steps
    }

    fn push(&mut self, c: usize, node: &Node, slave: &dyn Slave) {
        let direct = if node.ramped { None } else { slave.direct() };
        let recorded = direct.as_ref().map_or(0, |direct| direct.recorded.len());
        let places = Places::new(c, node, self.routes.len(), recorded);
        let (Some(DirectCalls { calls, inputs, outputs, recorded }), Some(places)) =
            (direct, places)
        else {
            return self.direct.push(None, &[], &[], Places::default());
        };
        debug_assert_eq!((inputs.len(), outputs.len()), (node.inputs.len(), node.outputs.len()));
        self.partly[c] = recorded.len() < node.recorded.len();
        self.direct.push(Some(calls), inputs, &[outputs, recorded], places);
        self.routes.extend_from_slice(&node.fresh);
    }

    /// Whether a step reads only some of the variables of a component that are only recorded.
    #[inline]
    pub(super) fn reads_partly(&self, component: usize) -> bool {
        self.partly[component]
    }

    /// From now on, this component steps through its slave.
    pub(super) fn leave(&mut self, component: usize, plan: &Plan) {
        if let Some(place) = plan.sequence.iter().position(|&c| c == component) {
            self.direct.leave(place);
        }
    }
}

impl Engine {
    /// Makes the steps that end now.
    pub(super) fn step_plain(&mut self, now: Time) -> Result<()> {
        let mut place = 0;
        loop {
            place = self.step_directly(place, now)?;
            let Some(&c) = self.plan.sequence.get(place) else {
                return Ok(());
            };
            if self.due(c, now) {
                self.step_untimed(c, now)?;
            }
            place += 1;
        }
    }

    /// Makes the steps from a position of the sequence on, up to the first that needs its slave;
    /// returns its position.
    #[inline(always)]
    fn step_directly(&mut self, first: usize, now: Time) -> Result<usize> {
        let recording = now == self.limit;
        // Instants in seconds, for components with the same step.
        let (mut length, mut seconds) = (Time::ZERO, (0.0, 0.0));
        let mut place = first;
        for (places, step) in self.steps.direct.from(first) {
            place += 1;
            let c = places.component as usize;
            let pace = &mut self.paces[c];
            if pace.end != now {
                continue;
            }
            if pace.length != length {
                length = pace.length;
                seconds = ((now - length).seconds(), length.seconds());
            }
            pace.made += 1;
            let routes = range(places.routes, usize::from(places.route_count));
            copy(&self.steps.routes[routes], &self.values, &mut self.inputs);
            let mut reads = step.reads();
            if !recording {
                reads -= usize::from(places.recorded);
            } else if places.recorded > 0 {
                pace.read_at = now;
            }
            let own = &self.inputs[range(places.inputs, step.sets())];
            let results = &mut self.values[range(places.outputs, reads)];
            let advanced = step.advance(own, seconds, results);
            if self.steps.float.is_changed() {
                set_back(&mut *self.slaves[c], &self.steps.float);
            }
            if let Err(found) = advanced {
                self.slaves[c].conclude(found, now - length, length)?;
            }
        }
        Ok(place)
    }

    /// Gives the components whose next step begins now their held inputs.
    pub(super) fn hold(&mut self, now: Time) {
        for held in &self.steps.held {
            if self.due(held.component, now) {
                self.inputs[held.route.to] = self.values[held.route.from];
            }
        }
    }
}

/// A separate function, so that the usual path stays short.
#[cold]
#[inline(never)]
fn set_back(slave: &mut dyn Slave, float: &Steady) {
    slave.changed_float(float.before());
}
