//! The state of an FMU as a whole: kept, set back, turned into bytes (FMI 2.0.5, 2.1.8).

use std::ptr;

use super::{Instance, RUNNING, State};
use crate::error::{Code, Error, Result};
use crate::fmi::description::Interface;
use crate::fmi::library::{Component, FmuState};
use crate::fmi::status::RawStatus;
use crate::time::Time;

const RESTORABLE: &[State] =
    &[State::Ready, State::EventMode, State::ContinuousTime, State::Failed];

/// Where a state is kept: those who go back do so independently of each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The iteration that solves an algebraic loop.
    Iteration,
    /// The repetition of a discarded step.
    Retry,
    /// The beginning of a step whose error is controlled.
    Control,
    /// The middle of such a step.
    Middle,
    /// A snapshot.
    Snapshot,
}

impl Place {
    /// How many there are.
    pub const COUNT: usize = 5;
}

impl Instance {
    /// Saves the FMU's whole state for [`Instance::restore`], in place of one saved there before.
    pub fn save(&mut self, place: Place) -> Result<()> {
        self.require("fmi2GetFMUstate", RUNNING)?;
        self.declares("save its state", "canGetAndSetFMUstate", |i| i.get_and_set_state)?;
        let slot = place as usize;
        let mut saved = self.saved[slot].take().map_or(ptr::null_mut(), |(saved, _)| saved);
        let result = self.call("fmi2GetFMUstate", |f, c| {
            // SAFETY: `saved` is NULL or a state of this instance, which is then overwritten.
            unsafe { (f.get_state)(c, &mut saved) }
        });
        self.saved[slot] = (!saved.is_null()).then_some((saved, self.state));
        result
    }

    /// Sets the FMU back to the state saved there, which was that of the instant `time`.
    pub fn restore(&mut self, place: Place, time: Time) -> Result<()> {
        self.require("fmi2SetFMUstate", RESTORABLE)?;
        let Some((saved, state)) = self.saved[place as usize] else {
            return Err(Error::new(Code::Fmu, format!("'{}' has no saved state", self.name)));
        };
        self.call("fmi2SetFMUstate", |f, c| {
            // SAFETY: `saved` is a state of this instance.
            unsafe { (f.set_state)(c, saved) }
        })?;
        self.state = state;
        self.time = time;
        Ok(())
    }

    /// The FMU's whole state as bytes, for another instance of the same FMU in another process.
    pub fn serialize(&mut self) -> Result<Vec<u8>> {
        self.serializable()?;
        self.save(Place::Snapshot)?;
        let Some((saved, _)) = self.saved[Place::Snapshot as usize] else {
            return Err(self.without("fmi2GetFMUstate"));
        };
        let size_of = self.optional.serialized_size;
        let mut size = 0;
        self.call_optional("fmi2SerializedFMUstateSize", size_of, |function, c| {
            // SAFETY: `saved` is a state of this instance; `size` lives during the call.
            unsafe { function(c, saved, &mut size) }
        })?;
        let mut bytes = vec![0; size];
        let serialize = self.optional.serialize;
        self.call_optional("fmi2SerializeFMUstate", serialize, |function, c| {
            // SAFETY: as above; the array has that length.
            unsafe { function(c, saved, bytes.as_mut_ptr(), bytes.len()) }
        })?;
        Ok(bytes)
    }

    /// Sets the state that [`Instance::serialize`] gave, which was that of the instant `time`. The
    /// instance has left its initialization, and is in the state that the other one was in.
    pub fn deserialize(&mut self, bytes: &[u8], time: Time) -> Result<()> {
        self.require("fmi2DeSerializeFMUstate", RUNNING)?;
        self.serializable()?;
        let mut saved: FmuState = ptr::null_mut();
        let deserialize = self.optional.deserialize;
        let result = self.call_optional("fmi2DeSerializeFMUstate", deserialize, |function, c| {
            // SAFETY: the array has that length; `saved` is NULL, a new state is put there.
            unsafe { function(c, bytes.as_ptr(), bytes.len(), &mut saved) }
        });
        if saved.is_null() {
            return result.and(Err(self.without("fmi2DeSerializeFMUstate")));
        }
        if let Some((mut old, _)) =
            self.saved[Place::Snapshot as usize].replace((saved, self.state))
        {
            // SAFETY: `old` is a state of this living instance.
            unsafe { (self.functions.free_state)(self.component, &mut old) };
        }
        result?;
        self.restore(Place::Snapshot, time)
    }

    fn serializable(&self) -> Result<()> {
        self.declares("be part of a snapshot", "canSerializeFMUstate", |i| i.serialize_state)
    }

    /// An error that names the flag when the FMU does not declare it.
    fn declares(&self, what: &str, flag: &str, has: impl Fn(&Interface) -> bool) -> Result<()> {
        if has(self.fmu.interface(self.kind)?) {
            return Ok(());
        }
        Err(Error::new(Code::State, format!("'{}' cannot {what}", self.name))
            .at(self.fmu.path())
            .why(format!("its modelDescription.xml does not declare {flag}")))
    }

    #[cold]
    fn without(&self, function: &str) -> Error {
        Error::new(Code::State, format!("{function} of '{}' gave no state", self.name))
            .at(self.fmu.path())
            .why("the pointer to the state is NULL")
    }

    /// Calls a function that the library may lack.
    pub(super) fn call_optional<F: Copy>(
        &mut self,
        name: &'static str,
        function: Option<F>,
        call: impl FnOnce(F, Component) -> RawStatus,
    ) -> Result<()> {
        let Some(function) = function else {
            return Err(Error::new(Code::Library, format!("the library lacks {name}"))
                .at(self.fmu.path())
                .why("the flags of its modelDescription.xml promise it"));
        };
        self.call(name, |_, c| call(function, c))
    }
}
