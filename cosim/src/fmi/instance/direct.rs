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
use crate::fmi::guard::Float;
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
    /// Those of all lines: of each first what is set, then what is read.
    references: Vec<u32>,
    /// No instance of a line is freed as long as this is there.
    kept: Vec<Arc<()>>,
}

/// A cache line, if `T` is no longer than 24 bytes.
#[repr(C, align(64))]
struct Line<T> {
    /// None: the step is not made directly.
    calls: Option<Calls>,
    /// Where its references begin; there are as many as are set and read.
    references: u32,
    sets: u16,
    reads: u16,
    own: T,
}

/// The step of an instance.
pub(crate) struct DirectStep<'a> {
    calls: &'a mut Option<Calls>,
    /// What is set, then what is read.
    references: &'a [u32],
    sets: usize,
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

impl<T> Default for DirectSteps<T> {
    fn default() -> Self {
        Self { lines: Vec::new(), references: Vec::new(), kept: Vec::new() }
    }
}

impl<T> DirectSteps<T> {
    /// Adds a step that sets Reals and then reads some, or one that is not made directly, which is
    /// also what becomes of one with more of them than can be counted.
    pub(crate) fn push(&mut self, direct: Option<Direct>, sets: &[u32], reads: &[&[u32]], own: T) {
        let mut line = Line { calls: None, references: 0, sets: 0, reads: 0, own };
        if let Some(direct) = direct {
            let reads = reads.concat();
            let place = u32::try_from(self.references.len());
            let counts = (u16::try_from(sets.len()), u16::try_from(reads.len()));
            if let (Ok(references), (Ok(set), Ok(read))) = (place, counts) {
                self.kept.push(direct.kept);
                self.references.extend(sets.iter().chain(&reads));
                (line.calls, line.references) = (Some(direct.calls), references);
                (line.sets, line.reads) = (set, read);
            }
        }
        self.lines.push(line);
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
        let lines = self.lines.get_mut(place..).unwrap_or_default();
        lines.iter_mut().map_while(move |Line { calls, references: first, sets, reads, own }| {
            calls.as_ref()?;
            let count = (usize::from(*sets), usize::from(*reads));
            let references = &references[*first as usize..][..count.0 + count.1];
            Some((&*own, DirectStep { calls, references, sets: count.0 }))
        })
    }
}

impl DirectStep<'_> {
    /// How many Reals it sets.
    #[inline(always)]
    pub(crate) fn sets(&self) -> usize {
        self.sets
    }

    /// How many Reals it reads.
    #[inline(always)]
    pub(crate) fn reads(&self) -> usize {
        self.references.len() - self.sets
    }

    /// Sets the inputs, steps from `start` by `length` (in seconds), reads the outputs. The inputs
    /// are as many as it sets; of the outputs the last may be left out. Empty arrays are left
    /// alone.
    #[inline(always)]
    pub(crate) fn advance(
        self,
        inputs: &[f64],
        (start, length): (f64, f64),
        outputs: &mut [f64],
    ) -> Result<(), Unusual> {
        let Some(Calls { component, set_real, do_step, get_real }) = *self.calls else {
            return Ok(());
        };
        let (set, read) = self.references.split_at(inputs.len());
        let read = &read[..outputs.len()];
        if !set.is_empty() {
            // SAFETY: the instance is kept and was initialized, here and below; the arrays have one
            // length and live during the calls.
            let status = unsafe { set_real(component, set.as_ptr(), set.len(), inputs.as_ptr()) };
            if is_unusual(status) {
                return Err(self.end(Call::Set, status));
            }
        }
        // SAFETY: as above.
        let status = unsafe { do_step(component, start, length, 1) };
        if is_unusual(status) {
            return Err(self.end(Call::Step, status));
        }
        if !read.is_empty() {
            // SAFETY: as above.
            let status =
                unsafe { get_real(component, read.as_ptr(), read.len(), outputs.as_mut_ptr()) };
            if is_unusual(status) {
                return Err(self.end(Call::Get, status));
            }
        }
        Ok(())
    }

    /// A discarded step may be followed by others, nothing else may.
    #[cold]
    fn end(self, call: Call, status: RawStatus) -> Unusual {
        if status != status::DISCARD {
            *self.calls = None;
        }
        Unusual { call, status }
    }
}

/// Neither well nor with a warning, which the FMU has logged.
#[inline(always)]
fn is_unusual(status: RawStatus) -> bool {
    !matches!(status, status::OK | status::WARNING)
}

impl Instance {
    /// The bare calls of its steps, once it is initialized. There are none when somebody follows
    /// the calls, when a step may go on in the background or is a fraction of nanoseconds, and in
    /// model exchange.
    pub(crate) fn direct(&self) -> Option<Direct> {
        let Hot { set_real, get_real, do_step } = self.hot;
        let asynchronous = self.fmu.interface(self.kind).is_ok_and(|own| own.asynchronous);
        let special = self.followed.is_some() || asynchronous || self.grid.is_some();
        if self.state != State::Ready || special {
            return None;
        }
        let calls = Calls { component: self.component, set_real, do_step: do_step?, get_real };
        Some(Direct { calls, kept: self.kept.clone() })
    }

    /// Sets back what a direct step changed of the floating-point environment, which was `before`.
    #[cold]
    pub(crate) fn changed_float(&self, before: Float) {
        before.changed(&self.log, "a step");
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
