//! The safe handle of one `fmi2Component`.
//!
//! It permits only the calls that FMI 2.0.5 (3.2.3 and 4.2.4, state machines) allows in the current
//! [`State`], turns statuses into errors, and frees the instance when dropped.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use super::callbacks::{Callbacks, Known};
use super::description::InterfaceType;
use super::fmu::Fmu;
use super::guard::{self, Float};
use super::library::{Component, FmuState, Functions, Hot, Own};
use super::status::{self, RawStatus};
use crate::error::{Code, Error, Result};
use crate::time::{Step, Time};

mod access;
mod create;
mod derivatives;
mod direct;
mod exchange;
mod followed;
mod relayed;
mod state;
mod step;
pub(crate) use direct::{Direct, DirectSteps, Unusual};
pub use exchange::NextEvent;
use followed::{Followed, nothing};
pub use state::Place;

/// State of an instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// After instantiation or reset: start values may be set.
    Instantiated,
    /// In initialization mode: inputs may be set and outputs read.
    Initialization,
    /// Co-simulation: between communication points.
    Ready,
    /// Model exchange: at an event.
    EventMode,
    /// Model exchange: the importer integrates.
    ContinuousTime,
    /// A step was refused: values may be read, nothing else.
    Failed,
    /// The FMU reported a fatal error: not even freeing is allowed.
    Fatal,
}

/// Initialized, and without an error.
const RUNNING: &[State] = &[State::Ready, State::EventMode, State::ContinuousTime];
/// An instance of an FMU. The fields that every step uses come first and fit into a cache line,
/// which matters for systems of hundreds of small FMUs.
#[repr(C)]
pub struct Instance {
    /// Not NULL once it is created.
    component: Component,
    /// Followers of the calls.
    followed: Option<Box<Followed>>,
    time: Time,
    /// The length of the last step, also in seconds.
    step: (Time, f64),
    state: State,
    hot: Hot,
    kind: InterfaceType,
    /// Its steps are this fraction of nanoseconds from that start; it gets their seconds unrounded.
    grid: Option<(Time, Step)>,
    /// Its usual step.
    usual: Option<Step>,
    name: String,
    /// Saved states of the FMU and of this handle, by slot.
    saved: [Option<(FmuState, State)>; Place::COUNT],
    /// The FMU holds pointers to both of these, so they must not move.
    callbacks: Option<Box<Callbacks>>,
    log: Known,
    /// Pointers into the library, which `fmu` keeps mapped.
    functions: Functions,
    own: Own,
    /// Shared with callers that bypass this handle.
    kept: Arc<()>,
    fmu: Arc<Fmu>,
}

impl Instance {
    /// The name of the instance.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The FMU.
    pub fn fmu(&self) -> &Arc<Fmu> {
        &self.fmu
    }

    /// The current state.
    pub fn state(&self) -> State {
        self.state
    }

    /// Sets the experiment's start and stop and enters initialization mode.
    pub fn enter_initialization(&mut self, start: Time, stop: Time) -> Result<()> {
        self.set_up(start, stop)?;
        self.enter()
    }

    /// Sets the experiment's start and stop, and in co-simulation the tolerance that the FMU
    /// suggests.
    pub fn set_up(&mut self, start: Time, stop: Time) -> Result<()> {
        self.require("fmi2SetupExperiment", &[State::Instantiated])?;
        self.time = start;
        let known = stop < Time::NEVER;
        let stop = if known { self.end_of_last_step(start, stop) } else { 0.0 };
        let start = start.seconds();
        // In model exchange, the importer controls errors.
        let steps = self.kind == InterfaceType::CoSimulation;
        let tolerance = self.fmu.description().experiment.tolerance;
        let tolerance = tolerance.filter(|tolerance| steps && *tolerance > 0.0);
        let (suggested, tolerance) = (tolerance.is_some(), tolerance.unwrap_or(0.0));
        let arguments =
            |_: &Followed| format!("{suggested}, {tolerance:?}, {start:?}, {known}, {stop:?}");
        self.call("fmi2SetupExperiment", arguments, |f, c| {
            // SAFETY: `c` is alive and the state allows the call.
            unsafe {
                let defined = suggested.into();
                (f.setup_experiment)(c, defined, tolerance, start, known.into(), stop)
            }
        })
    }

    /// Steps begin and end at multiples of `step` after `start`, to the nearest nanosecond; the FMU
    /// gets their seconds without that rounding.
    pub fn steps_by(&mut self, start: Time, step: Step) {
        self.grid = (!step.is_whole()).then_some((start, step));
        self.usual = Some(step);
    }

    /// Enters initialization mode, after [`Instance::set_up`].
    pub fn enter(&mut self) -> Result<()> {
        self.require("fmi2EnterInitializationMode", &[State::Instantiated])?;
        self.call("fmi2EnterInitializationMode", nothing, |f, c| {
            // SAFETY: as above.
            unsafe { (f.enter_initialization)(c) }
        })?;
        self.check_process("fmi2EnterInitializationMode");
        self.state = State::Initialization;
        Ok(())
    }

    /// Leaves initialization mode.
    pub fn exit_initialization(&mut self) -> Result<()> {
        self.require("fmi2ExitInitializationMode", &[State::Initialization])?;
        self.call("fmi2ExitInitializationMode", nothing, |f, c| {
            // SAFETY: `c` is alive and the state allows the call.
            unsafe { (f.exit_initialization)(c) }
        })?;
        self.check_process("fmi2ExitInitializationMode");
        self.state = match self.kind {
            InterfaceType::CoSimulation => State::Ready,
            InterfaceType::ModelExchange => State::EventMode,
        };
        Ok(())
    }

    /// Resets the instance to its state after instantiation.
    pub fn reset(&mut self) -> Result<()> {
        self.require("fmi2Reset", RUNNING)?;
        self.call("fmi2Reset", nothing, |f, c| {
            // SAFETY: `c` is alive and the state allows the call.
            unsafe { (f.reset)(c) }
        })?;
        self.check_process("fmi2Reset");
        self.state = State::Instantiated;
        Ok(())
    }

    /// What the FMU has logged since the last call; only the newest messages are kept. Empty if
    /// they were shown immediately ([`Logging`](super::Logging)).
    pub fn messages(&self) -> Vec<String> {
        if self.log.is_live() { Vec::new() } else { self.log.take() }
    }

    /// Does something that may fail without ending the run: returns the failure, unless it was
    /// fatal.
    pub(crate) fn attempt<T>(
        &mut self,
        act: impl FnOnce(&mut Self) -> Result<T>,
    ) -> Result<Result<T>> {
        let state = self.state;
        match act(self) {
            Err(error) if self.state == State::Fatal => Err(error),
            Err(error) => {
                self.state = state;
                Ok(Err(error))
            }
            done => Ok(done),
        }
    }

    #[inline(always)]
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

    /// Makes a call. The arguments are formatted only for followers of the calls.
    #[inline(always)]
    fn call(
        &mut self,
        function: &'static str,
        arguments: impl FnOnce(&Followed) -> String,
        call: impl FnOnce(&Functions, Component) -> RawStatus,
    ) -> Result<()> {
        self.invoke::<false>(function, arguments, call)
    }

    /// Makes a call whose results are shown by [`Self::show`].
    #[inline(always)]
    fn get(
        &mut self,
        function: &'static str,
        arguments: impl FnOnce(&Followed) -> String,
        call: impl FnOnce(&Functions, Component) -> RawStatus,
    ) -> Result<()> {
        self.invoke::<true>(function, arguments, call)
    }

    #[inline(always)]
    fn invoke<const RESULTS: bool>(
        &mut self,
        function: &'static str,
        arguments: impl FnOnce(&Followed) -> String,
        call: impl FnOnce(&Functions, Component) -> RawStatus,
    ) -> Result<()> {
        let float = Float::now();
        let status = match self.followed {
            None => call(&self.functions, self.component),
            Some(_) => self.followed_call::<RESULTS>(function, arguments, call),
        };
        float.check(&self.log, function);
        if status == status::OK || status == status::WARNING {
            return Ok(());
        }
        Err(self.failed(function, status))
    }

    /// Undoes what the FMU changed in the process, and reports it.
    pub(crate) fn check_process(&self, function: &str) {
        guard::check(&self.log, function);
    }

    /// A separate function, so that the usual path stays short.
    #[cold]
    #[inline(never)]
    fn followed_call<const RESULTS: bool>(
        &self,
        function: &'static str,
        arguments: impl FnOnce(&Followed) -> String,
        call: impl FnOnce(&Functions, Component) -> RawStatus,
    ) -> RawStatus {
        let Some(followed) = &self.followed else {
            return call(&self.functions, self.component);
        };
        followed.begin(function, self.time, arguments);
        let status = call(&self.functions, self.component);
        let well = status == status::OK || status == status::WARNING;
        followed.end(function, status, RESULTS && well);
        status
    }

    /// Shows the results of a call to its followers.
    #[inline(always)]
    fn show(&self, results: impl FnOnce(&Followed) -> String) {
        if let Some(followed) = &self.followed {
            show_results(followed, results);
        }
    }

    #[cold]
    fn failed(&mut self, function: &'static str, status: RawStatus) -> Error {
        self.state = match status {
            status::FATAL => State::Fatal,
            // Nothing was called.
            status::MISSING => self.state,
            _ => State::Failed,
        };
        let what = format!("{function} of '{}' failed at t = {}", self.name, self.time);
        let error = Error::new(Code::Fmu, what).at(self.fmu.path()).log(self.log.take());
        let error = error.returned(status);
        match status {
            status::MISSING => error.why(format!("the library of the FMU has no {function}")),
            _ => error.why(format!("the FMU returned {}", status::name(status))),
        }
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        let functions = &self.functions;
        if self.component.is_null() {
            self.fmu.taken.store(false, Ordering::Release);
            return;
        }
        // FMI allows no call at all after a fatal error: the instance is leaked, with everything
        // its code may still use. The same applies if another thread could still call it.
        if self.state == State::Fatal || Arc::strong_count(&self.kept) > 1 {
            self.fmu.abandoned.store(true, Ordering::Release);
            std::mem::forget(self.callbacks.take());
            self.log.stay();
            return;
        }
        let follow = |function, call: &mut dyn FnMut()| {
            let float = Float::now();
            if let Some(followed) = &self.followed {
                followed.begin(function, self.time, nothing);
            }
            call();
            float.check(&self.log, function);
            if let Some(followed) = &self.followed {
                followed.end(function, status::OK, false);
            }
        };
        for &(mut saved, _) in self.saved.iter().flatten() {
            follow("fmi2FreeFMUstate", &mut || {
                // SAFETY: `saved` is a state of this live instance.
                unsafe { (functions.free_state)(self.component, &mut saved) };
            });
        }
        if RUNNING.contains(&self.state) {
            follow("fmi2Terminate", &mut || {
                // SAFETY: the state allows it; the status would have no effect any more.
                unsafe { (functions.terminate)(self.component) };
            });
        }
        follow("fmi2FreeInstance", &mut || {
            // SAFETY: the component is alive and not used afterwards.
            unsafe { (functions.free_instance)(self.component) };
        });
        self.check_process("fmi2FreeInstance");
        self.fmu.taken.store(false, Ordering::Release);
    }
}

#[cold]
#[inline(never)]
fn show_results(followed: &Followed, results: impl FnOnce(&Followed) -> String) {
    followed.results(results);
}
