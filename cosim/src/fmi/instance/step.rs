//! The step of co-simulation, and how far it came (FMI 2.0.5, 4.2.2 and 4.2.3).

use super::{Instance, State};
use crate::error::{Code, Error, Result};
use crate::fmi::library::Own;
use crate::fmi::status;
use crate::time::Time;

/// `fmi2StatusKind`.
const LAST_SUCCESSFUL_TIME: i32 = 2;
const TERMINATED: i32 = 3;

/// What became of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// It was made as a whole.
    Done,
    /// The FMU made only a part of it, up to this instant, and discarded the rest. A saved state
    /// may be set back, nothing else.
    Discarded(Time),
}

impl Instance {
    /// Advances from `start` by `step`; a step that is not made as a whole is an error.
    pub fn do_step(&mut self, start: Time, step: Time) -> Result<()> {
        match self.try_step(start, step)? {
            Step::Done => Ok(()),
            Step::Discarded(reached) => Err(self.discarded(reached)),
        }
    }

    /// Advances from `start` by `step`, or tells that the FMU discarded the step.
    #[inline]
    pub fn try_step(&mut self, start: Time, step: Time) -> Result<Step> {
        self.require("fmi2DoStep", &[State::Ready])?;
        let Own::Stepping(stepping) = self.own else {
            return Err(self.refused("fmi2DoStep"));
        };
        self.time = start;
        let (from, length) = (start.seconds(), step.seconds());
        // SAFETY: the component is alive and the state allows the call.
        match unsafe { (stepping.do_step)(self.component, from, length, 1) } {
            status::OK | status::WARNING => {
                self.time = start + step;
                Ok(Step::Done)
            }
            status::DISCARD => self.reached(start, step),
            failed => Err(self.failed("fmi2DoStep", failed)),
        }
    }

    /// How far a discarded step came; an FMU that does not say so came nowhere.
    #[cold]
    fn reached(&mut self, start: Time, step: Time) -> Result<Step> {
        self.state = State::Failed;
        if self.boolean_status(TERMINATED) {
            let what = format!("'{}' ended the run at t = {}", self.name, self.time);
            return Err(Error::new(Code::Fmu, what)
                .at(self.fmu.path())
                .why("the FMU discarded a step with the status fmi2Terminated")
                .log(self.log.take()));
        }
        let said = self.real_status(LAST_SUCCESSFUL_TIME);
        let reached = said.and_then(|t| Time::from_seconds(t, "the last successful time").ok());
        Ok(Step::Discarded(reached.map_or(start, |t| t.clamp(start, start + step))))
    }

    /// The error for a discarded step that nobody repeats.
    #[cold]
    pub fn discarded(&mut self, reached: Time) -> Error {
        let mut error = self.failed("fmi2DoStep", status::DISCARD);
        if reached > self.time {
            error = error.why(format!("the FMU discarded the step; it came as far as {reached}"));
        }
        error
    }

    fn real_status(&self, kind: i32) -> Option<f64> {
        let (function, mut value) = (self.optional.real_status?, f64::NAN);
        // SAFETY: the component is alive, the state allows the call, `value` lives during it.
        let status = unsafe { function(self.component, kind, &mut value) };
        (status == status::OK && value.is_finite()).then_some(value)
    }

    fn boolean_status(&self, kind: i32) -> bool {
        let Some(function) = self.optional.boolean_status else {
            return false;
        };
        let mut value = 0;
        // SAFETY: the component is alive, the state allows the call, `value` lives during it.
        let status = unsafe { function(self.component, kind, &mut value) };
        status == status::OK && value != 0
    }
}
