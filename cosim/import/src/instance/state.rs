//! The complete state of an FMU: saved, restored, serialized (FMI 2.0.5, 2.1.8).

use std::ptr;

use fmu_standard::Call;

use super::{Followed, Instance, nothing};
use crate::description::Interface;
use crate::library::FmuState;
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::Time;

/// Slots for saved states: features that go back do so independently of each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The iteration that solves an algebraic loop.
    Iteration,
    /// The repetition of a discarded step.
    Retry,
    /// The start of a step under error control.
    Control,
    /// A snapshot.
    Snapshot,
}

impl Place {
    /// The number of slots.
    pub const COUNT: usize = 4;
}

impl Instance {
    /// Saves the FMU's complete state for [`Instance::restore`], replacing the one saved there
    /// before.
    pub fn save(&mut self, place: Place) -> Result<()> {
        self.require(Call::GetFmuState)?;
        self.keep(place)
    }

    fn keep(&mut self, place: Place) -> Result<()> {
        self.declares("save its state", "canGetAndSetFMUstate", |i| i.get_and_set_state)?;
        let slot = place as usize;
        let mut saved = self.saved[slot].take().map_or(ptr::null_mut(), |(saved, _)| saved);
        let result = self.call(Call::GetFmuState, nothing, |f, c| {
            // SAFETY: `saved` is NULL or a state of this instance, which is then overwritten.
            unsafe { (f.get_state)(c, &mut saved) }
        });
        self.saved[slot] = (!saved.is_null()).then_some((saved, self.phase));
        if result.is_ok() && saved.is_null() {
            return Err(self.without(Call::GetFmuState));
        }
        result
    }

    /// Restores the FMU's state saved there, which was that of the instant `time`.
    pub fn restore(&mut self, place: Place, time: Time) -> Result<()> {
        self.require(Call::SetFmuState)?;
        let Some((saved, state)) = self.saved[place as usize] else {
            return Err(Error::new(Code::Fmu, format!("'{}' has no saved state", self.name)));
        };
        self.call(
            Call::SetFmuState,
            |_| format!("the state of t = {time}"),
            |f, c| {
                // SAFETY: `saved` is a state of this instance.
                unsafe { (f.set_state)(c, saved) }
            },
        )?;
        self.phase = state;
        self.time = time;
        Ok(())
    }

    /// Serializes the FMU's complete state, for another instance of the same FMU in another
    /// process.
    pub fn serialize(&mut self) -> Result<Vec<u8>> {
        self.require(Call::GetFmuState)?;
        self.serialized()
    }

    /// The same, whatever the current state of the instance.
    pub(super) fn serialized(&mut self) -> Result<Vec<u8>> {
        self.serializable()?;
        self.keep(Place::Snapshot)?;
        let Some((saved, _)) = self.saved[Place::Snapshot as usize] else {
            return Err(self.without(Call::GetFmuState));
        };
        let mut size = 0;
        self.get(Call::SerializedFmuStateSize, nothing, |f, c| {
            // SAFETY: `saved` is a state of this instance; `size` lives during the call.
            unsafe { (f.serialized_size)(c, saved, &mut size) }
        })?;
        self.show(|_| size.to_string());
        let mut bytes = vec![0; size];
        self.call(Call::SerializeFmuState, nothing, |f, c| {
            // SAFETY: as above; the array has that length.
            unsafe { (f.serialize)(c, saved, bytes.as_mut_ptr(), bytes.len()) }
        })?;
        Ok(bytes)
    }

    /// Restores the state from [`Instance::serialize`], which was that of the instant `time`. The
    /// instance must have left initialization, and be in the same state as the other one was.
    pub fn deserialize(&mut self, bytes: &[u8], time: Time) -> Result<()> {
        if !self.phase.is_running() {
            return Err(self.refused(Call::DeSerializeFmuState));
        }
        self.serializable()?;
        let mut saved: FmuState = ptr::null_mut();
        let shown = |_: &Followed| format!("{} bytes", bytes.len());
        let result = self.call(Call::DeSerializeFmuState, shown, |f, c| {
            // SAFETY: the array has that length; `saved` is NULL, a new state is put there.
            unsafe { (f.deserialize)(c, bytes.as_ptr(), bytes.len(), &mut saved) }
        });
        if saved.is_null() {
            return result.and(Err(self.without(Call::DeSerializeFmuState)));
        }
        if let Some((mut old, _)) =
            self.saved[Place::Snapshot as usize].replace((saved, self.phase))
        {
            // SAFETY: `old` is a state of this live instance.
            unsafe { (self.functions.free_state)(self.component, &mut old) };
        }
        result?;
        self.restore(Place::Snapshot, time)
    }

    fn serializable(&self) -> Result<()> {
        self.declares("be part of a snapshot", "canSerializeFMUstate", |i| i.serialize_state)
    }

    /// An error that names the flag if the FMU does not declare it.
    fn declares(&self, what: &str, flag: &str, has: impl Fn(&Interface) -> bool) -> Result<()> {
        if has(self.fmu.interface(self.kind)?) {
            return Ok(());
        }
        Err(Error::new(Code::State, format!("'{}' cannot {what}", self.name))
            .at(self.fmu.path())
            .why(format!("its modelDescription.xml does not declare {flag}")))
    }

    #[cold]
    pub(super) fn without(&self, function: Call) -> Error {
        Error::new(Code::State, format!("{} of '{}' gave no state", function.name(), self.name))
            .at(self.fmu.path())
            .why("the pointer to the state is NULL")
    }
}
