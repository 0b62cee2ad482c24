//! The step of co-simulation, also when the FMU makes it in the background.
//!
//! An FMU that declares canRunAsynchronuously may return `fmi2Pending`: it is asked by
//! `fmi2GetStatus` until it is done (FMI 2.0.5, 4.2.3). One that does not declare it is refused,
//! and not touched again: its thread may still run.

use std::time::Duration;

use super::{Followed, Instance, State};
use crate::error::Result;
use crate::fmi::library::{Own, Stepping};
use crate::fmi::status;
use crate::time::Time;

/// `fmi2DoStepStatus` of `fmi2StatusKind`.
const DO_STEP_STATUS: i32 = 0;
/// Between two questions; short at first, for most steps are.
const FIRST_PAUSE: Duration = Duration::from_micros(20);
const LONGEST_PAUSE: Duration = Duration::from_millis(5);

impl Instance {
    /// Advances from `start` by `step`.
    pub fn do_step(&mut self, start: Time, step: Time) -> Result<()> {
        self.require("fmi2DoStep", &[State::Ready])?;
        let Own::Stepping(stepping) = &self.own else {
            return Err(self.refused("fmi2DoStep"));
        };
        let do_step = stepping.do_step;
        self.time = start;
        let (from, length) = (start.seconds(), step.seconds());
        let shown = |_: &Followed| format!("{from:?}, {length:?}, true");
        let mut pending = false;
        self.call("fmi2DoStep", shown, |_, c| {
            // SAFETY: `c` is alive and the state allows the call.
            let status = unsafe { do_step(c, from, length, 1) };
            pending = status == status::PENDING;
            if pending { status::OK } else { status }
        })?;
        if pending {
            self.wait()?;
        }
        self.time = start + step;
        Ok(())
    }

    #[cold]
    fn wait(&mut self) -> Result<()> {
        let declared = self.fmu.interface(self.kind)?.asynchronous;
        let Own::Stepping(Stepping { get_status, .. }) = self.own else {
            return Err(self.refused("fmi2GetStatus"));
        };
        if !declared {
            let error = self.failed("fmi2DoStep", status::PENDING);
            self.state = State::Fatal;
            return Err(error.help("the FMU does not declare canRunAsynchronuously"));
        }
        let mut pause = FIRST_PAUSE;
        loop {
            std::thread::sleep(pause);
            let mut found = status::PENDING;
            let component = self.component;
            // SAFETY: the component is alive and asked for its step; `found` lives during the call.
            let status = unsafe { get_status(component, DO_STEP_STATUS, &mut found) };
            if status != status::OK {
                let error = self.failed("fmi2GetStatus", status);
                self.state = State::Fatal;
                return Err(error);
            }
            if found != status::PENDING {
                return self.call("fmi2GetStatus", |_| "fmi2DoStepStatus".to_owned(), |_, _| found);
            }
            pause = (2 * pause).min(LONGEST_PAUSE);
        }
    }
}
