//! Saving and restoring the whole state of an instance.

use std::ptr;

use super::{Followed, Instance, RESTORABLE, RUNNING, nothing};
use crate::error::{Code, Error, Result};
use crate::time::Time;

impl Instance {
    /// Saves the FMU's whole state for [`Instance::restore`], in place of one saved before.
    pub fn save(&mut self) -> Result<()> {
        self.require("fmi2GetFMUstate", RUNNING)?;
        if !self.saves_state {
            return Err(self
                .unsaved()
                .why("its modelDescription.xml does not declare canGetAndSetFMUstate"));
        }
        let mut saved = self.saved.take().map_or(ptr::null_mut(), |(saved, _)| saved);
        let result = self.call("fmi2GetFMUstate", nothing, |f, c| {
            // SAFETY: `saved` is NULL or a state of this instance, which is then overwritten.
            unsafe { (f.get_state)(c, &mut saved) }
        });
        self.saved = (!saved.is_null()).then_some((saved, self.state));
        match result {
            Ok(()) if saved.is_null() => Err(self.unsaved().why(
                "fmi2GetFMUstate returned OK and no state, though canGetAndSetFMUstate is declared",
            )),
            Err(e) => Err(e.help("the FMU declares canGetAndSetFMUstate and does not keep it")),
            Ok(()) => Ok(()),
        }
    }

    /// Sets the FMU back to the state saved last, which was that of the instant `time`.
    pub fn restore(&mut self, time: Time) -> Result<()> {
        self.require("fmi2SetFMUstate", RESTORABLE)?;
        let Some((saved, state)) = self.saved else {
            return Err(Error::new(Code::Fmu, format!("'{}' has no saved state", self.name)));
        };
        let shown = |_: &Followed| format!("the state of t = {time}");
        self.call("fmi2SetFMUstate", shown, |f, c| {
            // SAFETY: `saved` is a state of this instance.
            unsafe { (f.set_state)(c, saved) }
        })?;
        self.state = state;
        self.time = time;
        Ok(())
    }

    fn unsaved(&self) -> Error {
        Error::new(Code::Fmu, format!("'{}' cannot save its state", self.name)).at(self.fmu.path())
    }
}
