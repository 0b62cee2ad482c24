//! The calls of plain co-simulation steps without the handles around them.
//!
//! [`Instance`] checks before each call whether the state allows it, and after it whether it
//! succeeded. Between initialization and the first failure the answer is always the same; a master
//! that steps hundreds of small FMUs need not access the handles for it. It keeps [`DirectSteps`]:
//! one cache line per instance with the calls and everything else the master needs for the step.
//!
//! Their calls are safe: they are created from initialized instances, they end with the first
//! failure, and no instance is freed while they exist.

use std::sync::Arc;

use fmu_standard::{Call, Phase};

use super::Instance;
use crate::Scalar;
use crate::guard::Float;
use crate::library::{Component, Hot};
use crate::status::{self, RawStatus};
use cosim_base::error::Result;
use cosim_base::time::Time;

type SetReal = unsafe extern "C" fn(Component, *const u32, usize, *const f64) -> RawStatus;
type GetReal = unsafe extern "C" fn(Component, *const u32, usize, *mut f64) -> RawStatus;
type DoStep = unsafe extern "C" fn(Component, f64, f64, i32) -> RawStatus;

/// What a plain step needs from an instance.
struct Calls {
    component: Component,
    set_real: SetReal,
    do_step: DoStep,
    get_real: GetReal,
}

/// The calls of an instance, which keep it alive.
pub struct Direct {
    calls: Calls,
    kept: Arc<()>,
}

/// The steps of many instances in order, each with data of the master.
pub struct DirectSteps<T> {
    lines: Vec<Line<T>>,
    /// The value references of all lines: for each first those that are set, then those that are
    /// read.
    references: Vec<u32>,
    /// No instance of a line is freed while this exists.
    kept: Vec<Arc<()>>,
}

/// A cache line, if `T` is at most 24 bytes long.
#[repr(C, align(64))]
struct Line<T> {
    /// `None`: the step is not made directly.
    calls: Option<Calls>,
    /// Where its references begin; there are as many as are set and read.
    references: u32,
    sets: u16,
    reads: u16,
    own: T,
}

/// The step of an instance.
pub struct DirectStep<'a> {
    calls: &'a mut Option<Calls>,
    /// The references to set, followed by those to read.
    references: &'a [u32],
    sets: usize,
}

/// A call that did not succeed: nothing else was called.
pub struct Unusual {
    call: Call,
    status: RawStatus,
}

impl<T> Default for DirectSteps<T> {
    fn default() -> Self {
        Self { lines: Vec::new(), references: Vec::new(), kept: Vec::new() }
    }
}

impl<T> DirectSteps<T> {
    /// Adds a step that sets Reals and then reads some, or a step that is not made directly; a step
    /// with more Reals than can be counted is also not made directly.
    pub fn push(&mut self, direct: Option<Direct>, sets: &[u32], reads: &[&[u32]], own: T) {
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

    /// From now on, this step is not made directly.
    pub fn leave(&mut self, place: usize) {
        if let Some(line) = self.lines.get_mut(place) {
            line.calls = None;
        }
    }

    /// The steps from that position on, up to the first that is not made directly.
    #[inline(always)]
    pub fn from(&mut self, place: usize) -> impl Iterator<Item = (&T, DirectStep<'_>)> {
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
    pub fn sets(&self) -> usize {
        self.sets
    }

    /// How many Reals it reads.
    #[inline(always)]
    pub fn reads(&self) -> usize {
        self.references.len() - self.sets
    }

    /// Sets the inputs, all Reals, steps from `start` by `length` (in seconds), reads the outputs. `inputs`
    /// must have as many as it sets; the last outputs may be omitted. Nothing is called for empty
    /// arrays.
    #[inline(always)]
    pub fn advance(
        self,
        inputs: &[Scalar],
        (start, length): (f64, f64),
        outputs: &mut [Scalar],
    ) -> Result<(), Unusual> {
        let Some(Calls { component, set_real, do_step, get_real }) = *self.calls else {
            return Ok(());
        };
        let (set, read) = self.references.split_at(inputs.len());
        let read = &read[..outputs.len()];
        if !set.is_empty() {
            let values = Scalar::reals(inputs).as_ptr();
            // SAFETY: the instance is kept alive and was initialized, here and below; the arrays
            // have the same length and live during the calls.
            let status = unsafe { set_real(component, set.as_ptr(), set.len(), values) };
            if is_unusual(status) {
                return Err(self.end(Call::SetReal, status));
            }
        }
        // SAFETY: as above.
        let status = unsafe { do_step(component, start, length, 1) };
        if is_unusual(status) {
            return Err(self.end(Call::DoStep, status));
        }
        if !read.is_empty() {
            let values = Scalar::reals_mut(outputs).as_mut_ptr();
            // SAFETY: as above.
            let status = unsafe { get_real(component, read.as_ptr(), read.len(), values) };
            if is_unusual(status) {
                return Err(self.end(Call::GetReal, status));
            }
        }
        Ok(())
    }

    /// A discarded step may be followed by other calls, other failures may not.
    #[cold]
    fn end(self, call: Call, status: RawStatus) -> Unusual {
        if status != status::DISCARD {
            *self.calls = None;
        }
        Unusual { call, status }
    }
}

/// Not OK, and not just a warning, which the FMU has logged.
#[inline(always)]
fn is_unusual(status: RawStatus) -> bool {
    !matches!(status, status::OK | status::WARNING)
}

impl Instance {
    /// The bare calls of its steps, once it is initialized. `None` if the calls are followed, if a
    /// step may continue in the background or is a fraction of nanoseconds, and in model exchange.
    pub fn direct(&self) -> Option<Direct> {
        let Hot { set_real, get_real, do_step } = self.hot;
        let asynchronous = self.fmu.interface(self.kind).is_ok_and(|own| own.asynchronous);
        let special = self.followed.is_some() || asynchronous || self.grid.is_some();
        if self.phase != Phase::Step || special {
            return None;
        }
        let calls = Calls { component: self.component, set_real, do_step: do_step?, get_real };
        Some(Direct { calls, kept: self.kept.clone() })
    }

    /// Undoes what a direct step changed in the floating-point environment, which was `before`.
    #[cold]
    pub fn changed_float(&self, before: Float) {
        before.changed(&self.log, "a step");
    }

    /// Direct calls have brought the instance to this instant, for error messages.
    pub fn came_to(&mut self, now: Time) {
        self.time = now;
    }

    /// The result of a direct step from `start` by `step` after an unusual status: the instant
    /// reached if the FMU discarded the step, otherwise the error.
    #[cold]
    pub fn conclude(&mut self, found: Unusual, start: Time, step: Time) -> Result<Time> {
        self.time = start;
        match found.call {
            Call::DoStep => self.stepped(start, step, found.status),
            call => {
                if call == Call::GetReal {
                    self.time = start + step;
                }
                Err(self.failed(call, found.status))
            }
        }
    }
}
