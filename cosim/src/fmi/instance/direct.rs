//! The calls of a plain co-simulation step without the handle around them.
//!
//! [`Instance`] checks before each call whether the state allows it, and after it what came of it.
//! Between initialization and the first call that does not go well the answer is always the same;
//! a master that steps hundreds of small FMUs need not touch the handles to get it.

use super::Instance;
use crate::error::Result;
use crate::fmi::library::{Component, Hot};
use crate::fmi::status::{self, RawStatus};
use crate::time::Time;

type SetReal = unsafe extern "C" fn(Component, *const u32, usize, *const f64) -> RawStatus;
type GetReal = unsafe extern "C" fn(Component, *const u32, usize, *mut f64) -> RawStatus;
type DoStep = unsafe extern "C" fn(Component, f64, f64, i32) -> RawStatus;

/// What a plain step needs of an instance.
pub(crate) struct Direct {
    component: Component,
    set_real: SetReal,
    do_step: DoStep,
    get_real: GetReal,
}

/// A call that did not go well: nothing more was called.
pub struct Unusual {
    call: Call,
    status: RawStatus,
}

enum Call {
    Set,
    Step,
    Get,
}

/// Well, or with a warning, which the FMU has logged.
#[inline(always)]
fn check(call: Call, status: RawStatus) -> Result<(), Unusual> {
    match status {
        status::OK | status::WARNING => Ok(()),
        _ => Err(Unusual { call, status }),
    }
}

impl Direct {
    /// Sets Reals, steps from `start` by `length` (in seconds), reads Reals. Empty arrays are left
    /// alone.
    ///
    /// # Safety
    ///
    /// The instance is alive and in the state `Ready`; there is a value for each reference.
    #[inline(always)]
    pub(crate) unsafe fn advance(
        &self,
        (set, inputs): (&[u32], &[f64]),
        (start, length): (f64, f64),
        (get, outputs): (&[u32], &mut [f64]),
    ) -> Result<(), Unusual> {
        let c = self.component;
        if !set.is_empty() {
            // SAFETY: as promised, here and below; the arrays live during the calls.
            let status = unsafe { (self.set_real)(c, set.as_ptr(), set.len(), inputs.as_ptr()) };
            check(Call::Set, status)?;
        }
        // SAFETY: as above.
        check(Call::Step, unsafe { (self.do_step)(c, start, length, 1) })?;
        if !get.is_empty() {
            // SAFETY: as above.
            let status =
                unsafe { (self.get_real)(c, get.as_ptr(), get.len(), outputs.as_mut_ptr()) };
            check(Call::Get, status)?;
        }
        Ok(())
    }
}

impl Instance {
    /// The bare calls of its steps. There are none when somebody follows the calls, when a step
    /// may go on in the background, and in model exchange.
    pub(crate) fn direct(&self) -> Option<Direct> {
        let Hot { set_real, get_real, do_step } = self.hot;
        let asynchronous = self.fmu.interface(self.kind).is_ok_and(|own| own.asynchronous);
        if self.followed.is_some() || asynchronous {
            return None;
        }
        Some(Direct { component: self.component, set_real, do_step: do_step?, get_real })
    }

    /// Direct calls have brought the instance to this instant: errors tell it.
    pub(crate) fn came_to(&mut self, now: Time) {
        self.time = now;
    }

    /// What a direct step from `start` by `step` came to after an unusual call: the instant
    /// reached if the FMU discarded it, else the error.
    #[cold]
    pub(crate) fn conclude(&mut self, found: Unusual, start: Time, step: Time) -> Result<Time> {
        self.time = start;
        match found.call {
            Call::Set => Err(self.failed("fmi2SetReal", found.status)),
            Call::Step => self.stepped(start, step, found.status),
            Call::Get => {
                self.time = start + step;
                Err(self.failed("fmi2GetReal", found.status))
            }
        }
    }
}
