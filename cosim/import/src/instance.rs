//! The safe handle of one `fmi2Component`.
//!
//! It permits only the calls that FMI allows in the current [`Phase`], turns statuses into errors,
//! and frees the instance when dropped.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use fmu_standard::{Call, Phase};

use super::callbacks::{Callbacks, Known};
use super::description::InterfaceType;
use super::fmu::Fmu;
use super::guard::{self, Float};
use super::library::{Binary, Component, FmuState, Functions, Hot, Own};
use super::status::{self, RawStatus};
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::{Step, Time};

mod access;
mod create;
mod derivatives;
mod direct;
mod exchange;
mod followed;
mod relayed;
mod state;
mod step;
pub use direct::{Direct, DirectSteps, Unusual};
pub use exchange::NextEvent;
use followed::{Followed, nothing};
pub use state::Place;

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
    phase: Phase,
    hot: Hot,
    kind: InterfaceType,
    /// Its steps are this fraction of nanoseconds from that start; it gets their seconds unrounded.
    grid: Option<(Time, Step)>,
    /// Its usual step.
    usual: Option<Step>,
    /// The relative tolerance that it gets in co-simulation.
    tolerance: Option<f64>,
    name: String,
    /// Saved states of the FMU and of this handle, by slot.
    saved: [Option<(FmuState, Phase)>; Place::COUNT],
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
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Sets the experiment's start and stop and enters initialization mode.
    pub fn enter_initialization(&mut self, start: Time, stop: Time) -> Result<()> {
        self.set_up(start, stop)?;
        self.enter()
    }

    /// The relative tolerance for its own steps, instead of the one that it suggests.
    pub fn set_tolerance(&mut self, tolerance: f64) {
        self.tolerance = Some(tolerance);
    }

    /// Sets the experiment's start and stop, and in co-simulation the tolerance.
    pub fn set_up(&mut self, start: Time, stop: Time) -> Result<()> {
        self.require(Call::SetupExperiment)?;
        self.time = start;
        let known = stop < Time::NEVER;
        let stop = if known { self.end_of_last_step(start, stop) } else { 0.0 };
        let start = start.seconds();
        // In model exchange, the importer controls errors.
        let steps = self.kind == InterfaceType::CoSimulation;
        let tolerance = self.tolerance.or(self.fmu.description().experiment.tolerance);
        let tolerance = tolerance.filter(|tolerance| steps && *tolerance > 0.0);
        let (defined, tolerance) = (tolerance.is_some(), tolerance.unwrap_or(0.0));
        let arguments =
            |_: &Followed| format!("{defined}, {tolerance:?}, {start:?}, {known}, {stop:?}");
        self.call(Call::SetupExperiment, arguments, |f, c| {
            // SAFETY: `c` is alive and the state allows the call.
            unsafe {
                let defined = defined.into();
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
        self.require(Call::EnterInitializationMode)?;
        self.call(Call::EnterInitializationMode, nothing, |f, c| {
            // SAFETY: as above.
            unsafe { (f.enter_initialization)(c) }
        })?;
        self.check_process(Call::EnterInitializationMode.name());
        self.phase = Phase::Initialization;
        Ok(())
    }

    /// Leaves initialization mode.
    pub fn exit_initialization(&mut self) -> Result<()> {
        self.require(Call::ExitInitializationMode)?;
        self.call(Call::ExitInitializationMode, nothing, |f, c| {
            // SAFETY: `c` is alive and the state allows the call.
            unsafe { (f.exit_initialization)(c) }
        })?;
        self.check_process(Call::ExitInitializationMode.name());
        self.phase = match self.kind {
            InterfaceType::CoSimulation => Phase::Step,
            InterfaceType::ModelExchange => Phase::Event,
        };
        Ok(())
    }

    /// Resets the instance to its state after instantiation.
    pub fn reset(&mut self) -> Result<()> {
        self.require(Call::Reset)?;
        self.call(Call::Reset, nothing, |f, c| {
            // SAFETY: `c` is alive and the state allows the call.
            unsafe { (f.reset)(c) }
        })?;
        self.check_process(Call::Reset.name());
        self.phase = Phase::Instantiated;
        Ok(())
    }

    /// What the FMU has logged since the last call; only the newest messages are kept. Empty if
    /// they were shown immediately ([`Logging`](super::Logging)).
    pub fn messages(&self) -> Vec<String> {
        if self.log.is_live() { Vec::new() } else { self.log.take() }
    }

    /// Does something that may fail without ending the run: returns the failure, unless it was
    /// fatal.
    pub fn attempt<T>(&mut self, act: impl FnOnce(&mut Self) -> Result<T>) -> Result<Result<T>> {
        let state = self.phase;
        match act(self) {
            Err(error) if self.phase == Phase::Fatal => Err(error),
            Err(error) => {
                self.phase = state;
                Ok(Err(error))
            }
            done => Ok(done),
        }
    }

    #[inline(always)]
    fn require(&self, function: Call) -> Result<()> {
        if self.phase.allows(function) { Ok(()) } else { Err(self.refused(function)) }
    }

    #[cold]
    fn refused(&self, function: Call) -> Error {
        let place = self.phase.place(function, self.kind);
        let what = format!("{} of '{}' is not allowed {place}", function.name(), self.name);
        Error::new(Code::Fmu, what)
    }

    /// Makes a call. The arguments are formatted only for followers of the calls.
    #[inline(always)]
    fn call(
        &mut self,
        function: Call,
        arguments: impl FnOnce(&Followed) -> String,
        call: impl FnOnce(&Functions, Component) -> RawStatus,
    ) -> Result<()> {
        self.invoke::<false>(function, arguments, call)
    }

    /// Makes a call whose results are shown by [`Self::show`].
    #[inline(always)]
    fn get(
        &mut self,
        function: Call,
        arguments: impl FnOnce(&Followed) -> String,
        call: impl FnOnce(&Functions, Component) -> RawStatus,
    ) -> Result<()> {
        self.invoke::<true>(function, arguments, call)
    }

    #[inline(always)]
    fn invoke<const RESULTS: bool>(
        &mut self,
        function: Call,
        arguments: impl FnOnce(&Followed) -> String,
        call: impl FnOnce(&Functions, Component) -> RawStatus,
    ) -> Result<()> {
        let float = Float::now();
        let status = match self.followed {
            None => call(&self.functions, self.component),
            Some(_) => self.followed_call::<RESULTS>(function, arguments, call),
        };
        float.check(&self.log, function.name());
        if status == status::OK || status == status::WARNING {
            return Ok(());
        }
        Err(self.failed(function, status))
    }

    /// Undoes what the FMU changed in the process, and reports it.
    pub fn check_process(&self, function: &str) {
        guard::check(&self.log, function);
    }

    /// A separate function, so that the usual path stays short.
    #[cold]
    #[inline(never)]
    fn followed_call<const RESULTS: bool>(
        &self,
        function: Call,
        arguments: impl FnOnce(&Followed) -> String,
        call: impl FnOnce(&Functions, Component) -> RawStatus,
    ) -> RawStatus {
        let Some(followed) = &self.followed else {
            return call(&self.functions, self.component);
        };
        followed.begin(function.name(), self.time, arguments);
        let status = call(&self.functions, self.component);
        let well = status == status::OK || status == status::WARNING;
        followed.end(function.name(), status, RESULTS && well);
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
    fn failed(&mut self, function: Call, status: RawStatus) -> Error {
        self.phase = match status {
            status::FATAL => Phase::Fatal,
            // Nothing was called.
            status::MISSING => self.phase,
            status::DISCARD if function == Call::DoStep => Phase::Failed,
            _ => Phase::Error,
        };
        let function = function.name();
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
        if self.phase == Phase::Fatal || Arc::strong_count(&self.kept) > 1 {
            self.fmu.abandoned.store(true, Ordering::Release);
            std::mem::forget(self.callbacks.take());
            self.log.stay();
            return;
        }
        let follow = |function: Call, call: &mut dyn FnMut()| {
            let function = function.name();
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
            follow(Call::FreeFmuState, &mut || {
                // SAFETY: `saved` is a state of this live instance.
                unsafe { (functions.free_state)(self.component, &mut saved) };
            });
        }
        if self.phase.is_running() {
            follow(Call::Terminate, &mut || {
                // SAFETY: the state allows it; the status would have no effect any more.
                unsafe { (functions.terminate)(self.component) };
            });
        }
        follow(Call::FreeInstance, &mut || {
            // SAFETY: the component is alive and not used afterwards.
            unsafe { (functions.free_instance)(self.component) };
        });
        self.check_process(Call::FreeInstance.name());
        // A thread that the FMU has left behind may still call them.
        if self.fmu.binary(self.kind).is_ok_and(Binary::may_run) {
            std::mem::forget(self.callbacks.take());
        }
        self.fmu.taken.store(false, Ordering::Release);
    }
}

#[cold]
#[inline(never)]
fn show_results(followed: &Followed, results: impl FnOnce(&Followed) -> String) {
    followed.results(results);
}
