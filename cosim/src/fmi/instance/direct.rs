//! The calls of plain co-simulation steps without the handles around them.
//!
//! [`Instance`] checks before each call whether the state allows it, and after it what came of it.
//! Between initialization and the first call that does not go well the answer is always the same;
//! a master that steps hundreds of small FMUs need not touch the handles to get it. It keeps
//! [`DirectSteps`]: one cache line per instance with the calls and what else the master needs for
//! the step.
//!
//! Their calls are safe: they are made of instances that are initialized, they end with the first
//! that fails, and while they are there no instance is freed.

use std::sync::Arc;

use super::{Instance, State};
use crate::error::Result;
use crate::fmi::library::{Component, Hot};
use crate::fmi::status::{self, RawStatus};
use crate::time::Time;

type SetReal = unsafe extern "C" fn(Component, *const u32, usize, *const f64) -> RawStatus;
type GetReal = unsafe extern "C" fn(Component, *const u32, usize, *mut f64) -> RawStatus;
type DoStep = unsafe extern "C" fn(Component, f64, f64, i32) -> RawStatus;

/// What a plain step needs of an instance.
struct Calls {
    component: Component,
    set_real: SetReal,
    do_step: DoStep,
    get_real: GetReal,
}

/// The calls of an instance, which keep it.
pub(crate) struct Direct {
    calls: Calls,
    kept: Arc<()>,
}

/// The steps of many instances in an order, each with something of the master's.
pub(crate) struct DirectSteps<T> {
    lines: Vec<Line<T>>,
    /// Value references of each line, first of what is set.
    references: Vec<u32>,
    /// No instance of a line is freed as long as this is there.
    kept: Vec<Arc<()>>,
}

/// A cache line, if `T` is no longer than 28 bytes.
#[repr(C, align(64))]
struct Line<T> {
    /// None: the step is not made directly.
    calls: Option<Calls>,
    references: u32,
    own: T,
}

/// The step of an instance.
pub(crate) struct DirectStep<'a> {
    calls: &'a mut Option<Calls>,
    references: &'a [u32],
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

impl<T> Default for DirectSteps<T> {
    fn default() -> Self {
        Self { lines: Vec::new(), references: Vec::new(), kept: Vec::new() }
    }
}

impl<T> DirectSteps<T> {
    /// Adds a step that sets and gets Reals of these references, or one that is not made directly.
    pub(crate) fn push(&mut self, direct: Option<(Direct, &[&[u32]])>, own: T) {
        let place = u32::try_from(self.references.len());
        let (calls, references) = match (direct, place) {
            (Some((direct, references)), Ok(place)) => {
                self.kept.push(direct.kept);
                self.references.extend(references.iter().copied().flatten());
                (Some(direct.calls), place)
            }
            _ => (None, 0),
        };
        self.lines.push(Line { calls, references, own });
    }

    /// From now on this step is not made directly.
    pub(crate) fn leave(&mut self, place: usize) {
        if let Some(line) = self.lines.get_mut(place) {
            line.calls = None;
        }
    }

    /// The steps from that place on, up to the first that is not made directly.
    #[inline(always)]
    pub(crate) fn from(&mut self, place: usize) -> impl Iterator<Item = (&T, DirectStep<'_>)> {
        let references = &self.references;
        self.lines.iter_mut().skip(place).map_while(|line| {
            let calls = &mut line.calls;
            calls.as_ref()?;
            let references = references.get(line.references as usize..)?;
            Some((&line.own, DirectStep { calls, references }))
        })
    }
}

impl DirectStep<'_> {
    /// Sets the inputs, steps from `start` by `length` (in seconds), reads the outputs. There are
    /// as many as there are references; of the outputs the last may be left out. Empty arrays are
    /// left alone.
    #[inline(always)]
    pub(crate) fn advance(
        self,
        inputs: &[f64],
        (start, length): (f64, f64),
        outputs: &mut [f64],
    ) -> Result<(), Unusual> {
        let Some(Calls { component: c, set_real, do_step, get_real }) = *self.calls else {
            return Ok(());
        };
        let (set, get) = self.references.split_at(inputs.len());
        let get = &get[..outputs.len()];
        let mut done = || {
            if !set.is_empty() {
                // SAFETY: the instance is kept and was initialized, here and below; the arrays have
                // one length and live during the calls.
                let status = unsafe { set_real(c, set.as_ptr(), set.len(), inputs.as_ptr()) };
                check(Call::Set, status)?;
            }
            // SAFETY: as above.
            check(Call::Step, unsafe { do_step(c, start, length, 1) })?;
            if !get.is_empty() {
                // SAFETY: as above.
                let status = unsafe { get_real(c, get.as_ptr(), get.len(), outputs.as_mut_ptr()) };
                check(Call::Get, status)?;
            }
            Ok(())
        };
        done().inspect_err(|unusual: &Unusual| {
            // A discarded step may be followed by others, nothing else may.
            if unusual.status != status::DISCARD {
                *self.calls = None;
            }
        })
    }
}

impl Instance {
    /// The bare calls of its steps, once it is initialized. There are none when somebody follows
    /// the calls, when a step may go on in the background, and in model exchange.
    pub(crate) fn direct(&self) -> Option<Direct> {
        let Hot { set_real, get_real, do_step } = self.hot;
        let asynchronous = self.fmu.interface(self.kind).is_ok_and(|own| own.asynchronous);
        if self.state != State::Ready || self.followed.is_some() || asynchronous {
            return None;
        }
        let calls = Calls { component: self.component, set_real, do_step: do_step?, get_real };
        Some(Direct { calls, kept: self.kept.clone() })
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
