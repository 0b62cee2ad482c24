//! The step of co-simulation, and how far it got (FMI 2.0.5, 4.2.2 and 4.2.3).
//!
//! An FMU that declares canRunAsynchronuously may return `fmi2Pending` and continue in the
//! background: it is polled with `fmi2GetStatus` until it is done. An FMU that does not declare it
//! is refused and not touched again, because its thread may still run.

use std::time::Duration;

use fmu_standard::{Call, Phase, StatusKind};

use super::{Followed, Instance};
use crate::guard::Float;
use crate::library::{Component, Functions, Own, Stepping};
use crate::status::{self, RawStatus};
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::{Step, Time};

/// Interval between polls of an FMU in the background; short at first, because most steps are
/// short.
const FIRST_PAUSE: Duration = Duration::from_micros(20);
const LONGEST_PAUSE: Duration = Duration::from_millis(5);

/// Start and length of a step in seconds.
#[cold]
fn unrounded((origin, grid): (Time, Step), begin: Time, end: Time) -> (f64, f64) {
    let from = grid.seconds_at(origin, begin);
    let whole = grid.divides(begin - origin) && grid.after(begin - origin) == end - origin;
    (from, if whole { grid.seconds() } else { grid.seconds_at(origin, end) - from })
}

impl Instance {
    /// `stop` in seconds as the FMU computes it by adding the length of the last step to its start.
    /// Rounding may make that greater, and some FMUs refuse every step that ends after the stop
    /// time.
    pub(super) fn end_of_last_step(&self, start: Time, stop: Time) -> f64 {
        let duration = stop - start;
        let Some(usual) = self.usual.filter(|_| duration > Time::ZERO) else {
            return stop.seconds();
        };
        let steps = usual.count(duration) - i64::from(usual.divides(duration));
        let begin = start + usual.multiple(steps);
        let (from, length) = match self.grid {
            None => (begin.seconds(), (stop - begin).seconds()),
            Some(grid) => unrounded(grid, begin, stop),
        };
        stop.seconds().max(from + length)
    }

    /// Advances from `start` by `step`; an incomplete step is an error.
    pub fn do_step(&mut self, start: Time, step: Time) -> Result<()> {
        match self.try_step(start, step)? {
            reached if reached == start + step => Ok(()),
            reached => Err(self.discarded(reached)),
        }
    }

    /// Advances from `start` by `step`; returns the instant reached. If that is before the end of
    /// the step, the FMU discarded the rest, and only a saved state may be restored.
    #[inline(always)]
    pub fn try_step(&mut self, start: Time, step: Time) -> Result<Time> {
        self.require(Call::DoStep)?;
        let Some(do_step) = self.hot.do_step else {
            return Err(self.refused(Call::DoStep));
        };
        self.time = start;
        if step != self.step.0 {
            // Saves a division per step; most steps have the same length.
            self.step = (step, step.seconds());
        }
        let (from, length) = match self.grid {
            None => (start.seconds(), self.step.1),
            Some(grid) => unrounded(grid, start, start + step),
        };
        let call = |_: &Functions, c: Component| {
            // SAFETY: `c` is alive and the state allows the call.
            unsafe { do_step(c, from, length, 1) }
        };
        let float = Float::now();
        let status = match self.followed {
            None => call(&self.functions, self.component),
            Some(_) => {
                let shown = |_: &Followed| format!("{from:?}, {length:?}, true");
                self.followed_call::<false>(Call::DoStep, shown, call)
            }
        };
        float.check(&self.log, Call::DoStep.name());
        self.stepped(start, step, status)
    }

    /// The result of a step that returned `status`.
    #[inline(always)]
    pub(super) fn stepped(
        &mut self,
        start: Time,
        step: Time,
        mut status: RawStatus,
    ) -> Result<Time> {
        if status == status::PENDING {
            status = self.wait()?;
        }
        match status {
            status::OK | status::WARNING => {
                self.time = start + step;
                Ok(self.time)
            }
            status::DISCARD => self.reached(start, step),
            failed => Err(self.failed(Call::DoStep, failed)),
        }
    }

    /// Waits for a step that the FMU makes in the background.
    #[cold]
    pub(super) fn wait(&mut self) -> Result<RawStatus> {
        if !self.fmu.interface(self.kind)?.asynchronous {
            let error = self.failed(Call::DoStep, status::PENDING);
            self.phase = Phase::Fatal;
            return Err(error.help("the FMU does not declare canRunAsynchronuously"));
        }
        let get_status = self.stepping(Call::GetStatus)?.get_status;
        let mut pause = FIRST_PAUSE;
        loop {
            std::thread::sleep(pause);
            let mut found = status::PENDING;
            // SAFETY: the component is alive and only polled for its step; `found` lives during the
            // call.
            let status =
                unsafe { get_status(self.component, StatusKind::DoStepStatus as i32, &mut found) };
            if status != status::OK {
                let error = self.failed(Call::GetStatus, status);
                self.phase = Phase::Fatal;
                return Err(error);
            }
            if found != status::PENDING {
                if let Some(followed) = &self.followed {
                    followed.begin(Call::GetStatus.name(), self.time, |_| {
                        "fmi2DoStepStatus".to_owned()
                    });
                    followed.end(Call::GetStatus.name(), found, false);
                }
                return Ok(found);
            }
            pause = (2 * pause).min(LONGEST_PAUSE);
        }
    }

    #[inline]
    pub(super) fn stepping(&self, function: Call) -> Result<&Stepping> {
        match &self.own {
            Own::Stepping(stepping) => Ok(stepping),
            Own::Exchange(_) => Err(self.refused(function)),
        }
    }

    /// How far a discarded step got; an FMU that does not report it made no progress.
    #[cold]
    pub(super) fn reached(&mut self, start: Time, step: Time) -> Result<Time> {
        self.phase = Phase::Failed;
        let said = self.real_status(StatusKind::LastSuccessfulTime);
        let reached = said.and_then(|t| Time::try_from_seconds(t).ok());
        if self.boolean_status(StatusKind::Terminated) {
            self.time = reached.filter(|t| *t >= start && *t <= start + step).unwrap_or(start);
            return Err(self.ended("the FMU discarded a step with the status fmi2Terminated"));
        }
        // An FMU that reached the end has no reason to discard the step: it made no progress.
        Ok(reached.filter(|t| *t > start && *t < start + step).unwrap_or(start))
    }

    /// The FMU requests the end of the run at the current time.
    #[cold]
    pub(super) fn ended(&mut self, why: &str) -> Error {
        Error::new(Code::Ended, format!("'{}' ended the run at t = {}", self.name, self.time))
            .at(self.fmu.path())
            .why(why)
    }

    /// The error for a discarded step that is not repeated.
    #[cold]
    pub fn discarded(&mut self, reached: Time) -> Error {
        let error = self.failed(Call::DoStep, status::DISCARD);
        match reached > self.time {
            true => error.why(format!("the FMU discarded the step; it reached {reached}")),
            false => error.why("the FMU discarded the step and made no progress"),
        }
    }

    fn real_status(&self, kind: StatusKind) -> Option<f64> {
        let (function, mut value) =
            (self.stepping(Call::GetRealStatus).ok()?.real_status, f64::NAN);
        // SAFETY: the component is alive, the state allows the call, `value` lives during it.
        let status = unsafe { function(self.component, kind as i32, &mut value) };
        (status == status::OK && value.is_finite()).then_some(value)
    }

    fn boolean_status(&self, kind: StatusKind) -> bool {
        let Ok(stepping) = self.stepping(Call::GetBooleanStatus) else {
            return false;
        };
        let (function, mut value) = (stepping.boolean_status, 0);
        // SAFETY: the component is alive, the state allows the call, `value` lives during it.
        let status = unsafe { function(self.component, kind as i32, &mut value) };
        status == status::OK && value != 0
    }
}
