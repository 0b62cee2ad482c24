//! A system that another program steps: the inside of an exported FMU.
//!
//! The host decides when and how far to step, sets inputs and parameters, and reads. All steps that
//! end in (t, t + h] are made, whatever h is; between their ends, outputs hold. An input is passed
//! on when the next steps are made, and only if it changed: so every step sees the inputs as they
//! were set before the call that makes it, and an unchanged input costs nothing. No component
//! represents the inputs in the plan: nothing else drives a free input, so a connection would only
//! repeat the value at every step.
//!
//! The inner FMUs are created when initialization begins, with all start values at once, as in a
//! run of the system; a reset has nothing to undo.

mod interface;
mod scenario;
mod state;
mod table;

use std::fs;
use std::path::Path;
use std::sync::Arc;

use crate::master::Engine;
use crate::scenario::Scenario;
use crate::system::{Component, Input, Overrides, System};
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::Time;
pub use cosim_import::Basic;
use cosim_import::{Logging, Mailbox, Message, Value};
pub use interface::{End, Exposed, FILE, Interface, MARK, Role, Running};
pub use state::Kept;
use table::{Known, Read, Table};

/// Maximum number of instants at which the system steps in one call of the host.
const MOST_INSTANTS: u64 = 1_000_000;

/// A system and its progress.
pub struct Hosted {
    guid: String,
    system: System,
    table: Table,
    /// Start values set by the host, per component.
    given: Vec<Vec<(usize, Value)>>,
    mailbox: Arc<Mailbox>,
    engine: Option<Engine>,
    stage: Stage,
    start: Time,
    stop: Time,
    /// Of the host.
    tolerance: Option<f64>,
    time: Time,
    /// Components with variables that only the host reads and that have not been read since the
    /// last step.
    unread: Vec<bool>,
    /// What was set and has not been passed on yet.
    pending: Vec<(Basic, u32)>,
    /// Initialization: values must be passed on until they settle.
    unsettled: bool,
    /// Faults and changes in the system, and until when they have been applied.
    scenario: Option<Scenario>,
    acted: Option<Time>,
}

/// The phase of its life cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) enum Stage {
    /// Start values are collected.
    Before,
    /// The components are in initialization mode.
    Initializing,
    /// Steps are made.
    Running,
}

impl Hosted {
    /// The system in the resources of an exported FMU; `debug`: requests debug messages from its
    /// FMUs.
    pub fn open(resources: &Path, debug: bool) -> Result<Self> {
        let file = resources.join(FILE);
        let unread = |why: String| {
            Error::new(Code::File, "the resources of the FMU cannot be read")
                .at(&file)
                .why(why)
                .help("unpack the FMU again, or export it again")
        };
        let bytes = fs::read(&file).map_err(|e| unread(e.to_string()))?;
        let interface = Interface::read(&bytes).map_err(unread)?;
        let mailbox = Arc::new(Mailbox::default());
        let logging = Logging { debug, mailbox: Some(mailbox.clone()), ..Logging::default() };
        let overrides = overrides(&interface)?;
        let system = System::load_unpacked(&resources.join(&interface.system), &overrides)?;
        for component in system.components() {
            component.fmu().map_or(Ok(()), |fmu| fmu.load(component.interface))?;
        }
        let (system, table) = Table::new(system.logging_to(logging), &interface)?;
        let components = system.components().len();
        Ok(Self {
            guid: interface.guid,
            table,
            given: vec![Vec::new(); components],
            mailbox,
            engine: None,
            stage: Stage::Before,
            start: Time::ZERO,
            stop: Time::NEVER,
            tolerance: None,
            time: Time::ZERO,
            unread: vec![true; components],
            pending: Vec::new(),
            unsettled: false,
            scenario: interface.scenario,
            acted: None,
            system,
        })
    }

    /// The GUID of the FMU.
    pub fn guid(&self) -> &str {
        &self.guid
    }

    /// Messages of the inner FMUs since the last call.
    #[inline]
    pub fn messages(&self) -> Vec<Message> {
        self.mailbox.take()
    }

    /// Switches debug messages of the FMUs on or off, for existing and future instances.
    pub fn debug(&mut self, on: bool) -> Result<()> {
        self.system.debug(on);
        let mut slaves = self.engine.iter_mut().flat_map(|engine| &mut engine.slaves);
        slaves.try_for_each(|slave| slave.debug(on))
    }

    /// Back to the start: nothing is set.
    pub fn reset(&mut self) {
        self.engine = None;
        self.stage = Stage::Before;
        self.table.reset();
        self.given.iter_mut().for_each(Vec::clear);
        self.pending.clear();
    }

    /// Creates the components and enters initialization mode. A `tolerance` of the host replaces
    /// what the FMUs suggest and what was set when the system was exported.
    pub fn enter(&mut self, start: Time, stop: Time, tolerance: Option<f64>) -> Result<()> {
        // An FMU that allows one instance is freed before it is created again.
        self.engine = None;
        (self.start, self.stop, self.time) = (start, stop, start);
        self.tolerance = tolerance.filter(|tolerance| *tolerance > 0.0 && *tolerance < 1.0);
        let mut making = self.system.making();
        if let Some(tolerance) = self.tolerance {
            (making.solver.tolerance, making.tolerance) = (tolerance, Some(tolerance));
        }
        let given = |(component, given): (&Component, &Vec<(usize, Value)>)| {
            let start_values = [&component.start_values[..], given].concat();
            Component { start_values, ..component.clone() }
        };
        let components: Vec<Component> =
            self.system.components().iter().zip(&self.given).map(given).collect();
        let mut engine = self.system.engine_of(&components, start, &making)?;
        engine.enter(stop)?;
        self.engine = Some(engine);
        (self.stage, self.unsettled) = (Stage::Initializing, true);
        self.pending.clear();
        self.unread.fill(true);
        Ok(())
    }

    /// Leaves initialization mode; returns warnings.
    pub fn exit(&mut self) -> Result<Vec<String>> {
        self.settle()?;
        let mut odd = Vec::new();
        if let Some(engine) = &mut self.engine {
            engine.exit()?;
            engine.begin()?;
            odd = engine.take_warnings();
        }
        self.begin_scenario(None)?;
        self.stage = Stage::Running;
        self.unread.fill(true);
        Ok(odd)
    }

    /// Makes every step that ends at or before `end`.
    pub fn advance(&mut self, end: Time) -> Result<()> {
        if let Some(engine) = &self.engine {
            bounded(engine, end)?;
        }
        self.pass_on()?;
        self.act_before(end)?;
        if let Some(engine) = &mut self.engine {
            engine.run_until(end)?;
        }
        self.time = end;
        self.unread.fill(true);
        Ok(())
    }

    /// Reals that are directly available while steps are made; `None` if some are not.
    #[inline]
    pub fn at_hand(&self, references: &[u32], into: &mut [f64]) -> Option<()> {
        let engine = self.engine.as_ref().filter(|_| self.stage == Stage::Running)?;
        for (reference, place) in references.iter().zip(into) {
            let slot = self.table.slot(*reference)?;
            if slot.read_with.is_some_and(|step| !engine.has_read(step as usize, self.time)) {
                return None;
            }
            *place = engine.values.get(slot.place as usize)?.as_real();
        }
        Some(())
    }

    /// A number: a Real, an Integer, a Boolean as 0 or 1.
    #[inline]
    pub fn number(&mut self, basic: Basic, reference: u32) -> Result<f64> {
        if self.stage == Stage::Initializing {
            self.settle()?;
        }
        let Self { table, engine, unread, time, .. } = self;
        let known = table.known(basic, reference)?;
        let Some(engine) = engine else {
            return Ok(known.value.number());
        };
        match known.read {
            Read::Slot(slot) => Ok(known.outward(engine.values[slot].number(basic))),
            Read::Recorded(slot, component) => {
                if unread[component] {
                    engine.read_of(component, *time)?;
                    unread[component] = false;
                }
                Ok(known.outward(engine.values[slot].number(basic)))
            }
            Read::Asked => {
                let port = known.ends[0].port;
                Ok(engine.slaves[port.component].look(port.variable)?.number())
            }
            Read::Own => Ok(known.value.number()),
        }
    }

    /// A String.
    pub fn text(&mut self, reference: u32) -> Result<String> {
        if self.stage == Stage::Initializing {
            self.settle()?;
        }
        let known = self.table.known(Basic::String, reference)?;
        let value = match (&mut self.engine, known.read) {
            (Some(engine), Read::Slot(slot) | Read::Recorded(slot, _)) => {
                return Ok(engine.values[slot].as_text().to_string());
            }
            (Some(engine), Read::Asked) => {
                let port = known.ends[0].port;
                engine.slaves[port.component].look(port.variable)?
            }
            (Some(_), Read::Own) | (None, _) => known.value.clone(),
        };
        match value {
            Value::String(text) => Ok(text),
            other => Ok(other.to_string()),
        }
    }

    /// Whether the variable can be set now; the error says why not.
    pub fn settable(&self, basic: Basic, reference: u32) -> Result<()> {
        self.table.known(basic, reference)?.settable(self.stage)
    }

    /// Sets a variable that is [`Hosted::settable`] to a value of its type.
    pub fn set(&mut self, basic: Basic, reference: u32, value: Value) -> Result<()> {
        let known = self.table.known_mut(basic, reference)?;
        if self.stage == Stage::Running {
            if !same(&known.value, &value) {
                known.value = value;
                self.pending.push((basic, reference));
            }
            return Ok(());
        }
        known.value = value;
        for end in &known.ends {
            let value = end.inward(&known.value)?;
            let given = &mut self.given[end.port.component];
            given.retain(|(variable, _)| *variable != end.port.variable);
            given.push((end.port.variable, value));
        }
        if self.stage == Stage::Initializing {
            self.pending.push((basic, reference));
        }
        Ok(())
    }

    /// Initialization: settles all values, if something has been set since.
    fn settle(&mut self) -> Result<()> {
        if !self.unsettled && self.pending.is_empty() {
            return Ok(());
        }
        self.pass_on()?;
        if let Some(engine) = &mut self.engine {
            engine.settle()?;
        }
        self.unsettled = false;
        self.unread.fill(true);
        Ok(())
    }

    /// Passes what was set to the components.
    #[inline]
    fn pass_on(&mut self) -> Result<()> {
        if self.pending.is_empty() { Ok(()) } else { self.pass_all_on() }
    }

    fn pass_all_on(&mut self) -> Result<()> {
        let Some(engine) = &mut self.engine else {
            return Ok(());
        };
        for (basic, reference) in std::mem::take(&mut self.pending) {
            let known: &Known = self.table.known(basic, reference)?;
            for end in &known.ends {
                engine.give(end.port, &end.inward(&known.value)?, self.time)?;
            }
        }
        Ok(())
    }
}

/// Refuses a step that would take more than [`MOST_INSTANTS`].
fn bounded(engine: &Engine, end: Time) -> Result<()> {
    let instants = engine.instants_until(end);
    if instants <= MOST_INSTANTS {
        return Ok(());
    }
    Err(Error::new(
        Code::Step,
        format!("a step to {end} needs {instants} steps of the system at once"),
    )
    .why(format!("one call makes no more than {MOST_INSTANTS}, so that it returns in time"))
    .help("use shorter communication steps"))
}

/// Settings of the run that the description of the system does not contain.
fn overrides(interface: &Interface) -> Result<Overrides> {
    let running = &interface.running;
    let algorithm = running.algorithm.parse();
    let algorithm = algorithm.map_err(|why: String| Error::new(Code::File, why))?;
    let mut overrides = Overrides::new()
        .execution_tools(true)
        .algorithm(algorithm)
        .solver(running.solver)
        .retries(running.retries);
    if let Some(tolerance) = running.tolerance {
        overrides = overrides.tolerance(tolerance);
    }
    if let Some(tolerance) = running.step_control {
        overrides = overrides.step_control(tolerance);
    }
    let linear = running.linear.iter();
    Ok(linear.fold(overrides, |overrides, name| overrides.input(name, Input::Linear)))
}

/// Whether two values have the same bits.
fn same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Real(a), Value::Real(b)) => a.to_bits() == b.to_bits(),
        _ => a == b,
    }
}
