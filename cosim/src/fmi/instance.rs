//! The safe handle of one `fmi2Component`.
//!
//! It permits only the calls that FMI 2.0.5 (3.2.3 and 4.2.4, state machines) allows in the
//! present [`State`], turns statuses into errors, and frees the instance when dropped.

use std::ffi::CString;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use super::callbacks::Callbacks;
use super::description::InterfaceType;
use super::fmu::Fmu;
use super::library::{Component, FmuState, Functions, Optional, Own};
use super::log::Log;
use super::status::{self, RawStatus};
use crate::error::{Code, Error, Result};
use crate::time::Time;

mod access;
mod derivatives;
mod exchange;
mod state;
mod step;
pub use exchange::NextEvent;
pub use state::Place;
pub use step::Step;

/// State of an instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// After instantiation or reset: start values may be given.
    Instantiated,
    /// In initialization mode: inputs may be set, outputs read.
    Initialization,
    /// Co-simulation: between communication points.
    Ready,
    /// Model exchange: at an event.
    EventMode,
    /// Model exchange: the importer integrates.
    ContinuousTime,
    /// A step was refused: values may be read, nothing more.
    Failed,
    /// The FMU said that it is beyond use: not even freeing is allowed.
    Fatal,
}

/// After the initialization, and well.
const RUNNING: &[State] = &[State::Ready, State::EventMode, State::ContinuousTime];

/// An instance of an FMU.
pub struct Instance {
    /// Not NULL.
    component: Component,
    name: String,
    state: State,
    time: Time,
    /// Saved states of the FMU, and of this handle, by their place.
    saved: [Option<(FmuState, State)>; Place::COUNT],
    /// The FMU holds pointers to both of these: boxed, so that they stay where they are.
    _callbacks: Box<Callbacks>,
    log: Box<Log>,
    kind: InterfaceType,
    /// Pointers into the library, which `fmu` keeps mapped.
    functions: Functions,
    own: Own,
    optional: Optional,
    fmu: Arc<Fmu>,
}

impl Instance {
    /// Instantiates `fmu` for co-simulation under `name`; `logging` asks it for debug messages.
    pub fn new(fmu: Arc<Fmu>, name: &str, logging: bool) -> Result<Self> {
        Self::of(fmu, InterfaceType::CoSimulation, name, logging)
    }

    /// Instantiates `fmu` for that interface type.
    pub fn of(fmu: Arc<Fmu>, kind: InterfaceType, name: &str, logging: bool) -> Result<Self> {
        let once = fmu.interface(kind)?.once_per_process;
        let binary = fmu.binary(kind)?;
        let (functions, own, optional) = (binary.functions, binary.own, binary.optional);
        if once && fmu.taken.swap(true, Ordering::AcqRel) {
            return Err(Error::new(Code::Fmu, format!("'{name}' cannot be instantiated"))
                .at(fmu.path())
                .why("the FMU allows one instance per process, and there is one already"));
        }
        let text = |text: &str| CString::new(text.replace('\0', "")).unwrap_or_default();
        let (c_name, guid) = (text(name), text(&fmu.description().guid));
        let resources = text(&fmu.resource_uri());
        let log = Box::<Log>::default();
        let callbacks = Box::new(Callbacks::new(&log));
        let fmi_type = match kind {
            InterfaceType::ModelExchange => 0,
            InterfaceType::CoSimulation => 1,
        };
        // SAFETY: the strings live during the call, callbacks and log as long as the instance.
        let component = unsafe {
            (functions.instantiate)(
                c_name.as_ptr(),
                fmi_type,
                guid.as_ptr(),
                resources.as_ptr(),
                &*callbacks,
                0,
                i32::from(logging),
            )
        };
        if component.is_null() {
            fmu.taken.store(false, Ordering::Release);
            return Err(Error::new(Code::Fmu, format!("'{name}' cannot be instantiated"))
                .at(fmu.path())
                .why("fmi2Instantiate returned NULL")
                .log(log.take()));
        }
        let (name, state, time) = (name.to_owned(), State::Instantiated, Time::ZERO);
        Ok(Self {
            component,
            name,
            state,
            time,
            saved: Default::default(),
            _callbacks: callbacks,
            log,
            kind,
            functions,
            own,
            optional,
            fmu,
        })
    }

    /// The instance's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The FMU.
    pub fn fmu(&self) -> &Arc<Fmu> {
        &self.fmu
    }

    /// The present state.
    pub fn state(&self) -> State {
        self.state
    }

    /// Sets the experiment's start and stop and enters initialization mode.
    pub fn enter_initialization(&mut self, start: Time, stop: Time) -> Result<()> {
        self.require("fmi2SetupExperiment", &[State::Instantiated])?;
        self.time = start;
        let (start, stop) = (start.seconds(), stop.seconds());
        self.call("fmi2SetupExperiment", |f, c| {
            // SAFETY: `c` is alive and the state allows the call.
            unsafe { (f.setup_experiment)(c, 0, 0.0, start, 1, stop) }
        })?;
        self.call("fmi2EnterInitializationMode", |f, c| {
            // SAFETY: as above.
            unsafe { (f.enter_initialization)(c) }
        })?;
        self.state = State::Initialization;
        Ok(())
    }

    /// Leaves initialization mode.
    pub fn exit_initialization(&mut self) -> Result<()> {
        self.require("fmi2ExitInitializationMode", &[State::Initialization])?;
        self.call("fmi2ExitInitializationMode", |f, c| {
            // SAFETY: `c` is alive and the state allows the call.
            unsafe { (f.exit_initialization)(c) }
        })?;
        self.state = match self.kind {
            InterfaceType::CoSimulation => State::Ready,
            InterfaceType::ModelExchange => State::EventMode,
        };
        Ok(())
    }

    /// What the FMU logged since this was asked last; only the newest messages are kept.
    pub fn messages(&self) -> Vec<String> {
        self.log.take()
    }

    fn require(&self, function: &'static str, allowed: &[State]) -> Result<()> {
        if allowed.contains(&self.state) {
            return Ok(());
        }
        Err(self.refused(function))
    }

    #[cold]
    fn refused(&self, function: &'static str) -> Error {
        Error::new(Code::Fmu, format!("{function} of '{}' is not allowed now", self.name))
            .why(format!("the instance is in the state {:?}", self.state))
    }

    #[inline]
    fn call(
        &mut self,
        function: &'static str,
        call: impl FnOnce(&Functions, Component) -> RawStatus,
    ) -> Result<()> {
        let status = call(&self.functions, self.component);
        if status == status::OK || status == status::WARNING {
            return Ok(());
        }
        Err(self.failed(function, status))
    }

    #[cold]
    fn failed(&mut self, function: &'static str, status: RawStatus) -> Error {
        self.state = if status == status::FATAL { State::Fatal } else { State::Failed };
        let what = format!("{function} of '{}' failed at t = {}", self.name, self.time);
        Error::new(Code::Fmu, what)
            .at(self.fmu.path())
            .why(format!("the FMU returned {}", status::name(status)))
            .log(self.log.take())
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        let functions = &self.functions;
        // FMI allows no call at all after a fatal error: the instance is leaked.
        if self.state == State::Fatal {
            return;
        }
        for (mut saved, _) in self.saved.iter_mut().filter_map(Option::take) {
            // SAFETY: `saved` is a state of this living instance.
            unsafe { (functions.free_state)(self.component, &mut saved) };
        }
        if RUNNING.contains(&self.state) {
            // SAFETY: the state allows it; a status would change nothing any more.
            unsafe { (functions.terminate)(self.component) };
        }
        // SAFETY: the component is alive and not used afterwards.
        unsafe { (functions.free_instance)(self.component) };
        self.fmu.taken.store(false, Ordering::Release);
    }
}
