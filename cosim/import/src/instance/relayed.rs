//! Calls relayed from another process: as they arrive, with exactly their arguments. The caller is
//! responsible for making only legal calls.

use std::ffi::{CString, c_char};
use std::ptr;

use fmu_standard::{Call, Phase};

use super::{Followed, Instance, followed, nothing};
use crate::Basic;
use crate::callbacks::text;
use crate::calls::{Ask, Given, Values};
use crate::library::{Component, FmuState, Functions};
use crate::status::{self, RawStatus};
use crate::{Kind, library::Bool};
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::Time;

impl Instance {
    /// Makes a call.
    pub fn relay(&mut self, ask: &Ask) -> Result<Given> {
        if self.phase == Phase::Fatal {
            return Err(self.refused(ask.function()));
        }
        let given = match ask {
            Ask::Debug(on, categories) => self.relay_debug(*on, categories),
            Ask::SetUp(tolerance, start, stop) => self.relay_setup(*tolerance, *start, *stop),
            // SAFETY: the component is alive, here and below.
            Ask::Enter => self.plainly(ask, |f, c| unsafe { (f.enter_initialization)(c) }),
            // SAFETY: as above.
            Ask::Exit => self.plainly(ask, |f, c| unsafe { (f.exit_initialization)(c) }),
            // SAFETY: as above.
            Ask::Reset => self.plainly(ask, |f, c| unsafe { (f.reset)(c) }),
            Ask::Set(references, values) => self.relay_set(references, values),
            Ask::Get(basic, references) => self.relay_get(*basic, references),
            Ask::Step(t, h) => self.relay_step(*t, *h),
            Ask::Save => self.serialized().map(Given::State),
            Ask::Restore(bytes) => self.relay_restore(bytes),
            Ask::Derivative(unknowns, knowns, along) => self.relay_slope(unknowns, knowns, along),
        }?;
        self.phase = match ask {
            Ask::Enter => Phase::Initialization,
            Ask::Exit | Ask::Restore(_) => Phase::Step,
            Ask::Reset => Phase::Instantiated,
            _ => self.phase,
        };
        Ok(given)
    }

    fn plainly(
        &mut self,
        ask: &Ask,
        call: impl FnOnce(&Functions, Component) -> RawStatus,
    ) -> Result<Given> {
        self.call(ask.function(), nothing, call).map(|()| Given::Done)
    }

    fn relay_debug(&mut self, on: bool, categories: &[String]) -> Result<Given> {
        let texts = self.texts(categories)?;
        let pointers: Vec<*const c_char> = texts.iter().map(|text| text.as_ptr()).collect();
        let shown = |_: &Followed| format!("{on}, {categories:?}");
        self.call(Call::SetDebugLogging, shown, |f, c| {
            // SAFETY: `c` is alive; the strings live during the call.
            unsafe { (f.set_debug_logging)(c, on.into(), pointers.len(), pointers.as_ptr()) }
        })?;
        Ok(Given::Done)
    }

    fn relay_setup(
        &mut self,
        tolerance: Option<f64>,
        start: f64,
        stop: Option<f64>,
    ) -> Result<Given> {
        self.time = near(start, self.time);
        let shown = |_: &Followed| format!("{tolerance:?}, {start:?}, {stop:?}");
        self.call(Call::SetupExperiment, shown, |f, c| {
            let flag = |value: Option<f64>| Bool::from(value.is_some());
            let (tolerant, stops) = (flag(tolerance), flag(stop));
            let (tolerance, stop) = (tolerance.unwrap_or_default(), stop.unwrap_or_default());
            // SAFETY: `c` is alive.
            unsafe { (f.setup_experiment)(c, tolerant, tolerance, start, stops, stop) }
        })?;
        Ok(Given::Done)
    }

    fn relay_set(&mut self, references: &[u32], values: &Values) -> Result<Given> {
        if references.len() != values.len() {
            let what = format!("{} references, {} values", references.len(), values.len());
            return Err(Error::new(Code::Protocol, what));
        }
        let (n, r) = (references.len(), references.as_ptr());
        // SAFETY (of all calls below): `c` is alive; both arrays have that length.
        match values {
            Values::Real(values) => {
                let shown = |f: &Followed| f.pairs(&Kind::Real, references, values);
                // SAFETY: as above.
                self.call(Call::SetReal, shown, |f, c| unsafe {
                    (f.set_real)(c, r, n, values.as_ptr())
                })
            }
            Values::Integer(values) => {
                let shown = |f: &Followed| f.pairs(&Kind::Integer, references, values);
                // SAFETY: as above.
                self.call(Call::SetInteger, shown, |f, c| unsafe {
                    (f.set_integer)(c, r, n, values.as_ptr())
                })
            }
            Values::Boolean(values) => {
                let values: Vec<Bool> = values.iter().map(|&value| value.into()).collect();
                let shown = |f: &Followed| f.pairs(&Kind::Boolean, references, &values);
                // SAFETY: as above.
                self.call(Call::SetBoolean, shown, |f, c| unsafe {
                    (f.set_boolean)(c, r, n, values.as_ptr())
                })
            }
            Values::String(values) => {
                let texts = self.texts(values)?;
                let pointers: Vec<*const c_char> = texts.iter().map(|text| text.as_ptr()).collect();
                let shown = |f: &Followed| f.pairs(&Kind::String, references, values);
                // SAFETY: as above; the strings live during the call.
                self.call(Call::SetString, shown, |f, c| unsafe {
                    (f.set_string)(c, r, n, pointers.as_ptr())
                })
            }
        }?;
        Ok(Given::Done)
    }

    fn relay_get(&mut self, basic: Basic, references: &[u32]) -> Result<Given> {
        let (n, r) = (references.len(), references.as_ptr());
        // SAFETY (of all calls below): `c` is alive; both arrays have that length.
        let values = match basic {
            Basic::Real => {
                let mut values = vec![0.0; n];
                let shown = |f: &Followed| f.names(&Kind::Real, references);
                // SAFETY: as above.
                self.get(Call::GetReal, shown, |f, c| unsafe {
                    (f.get_real)(c, r, n, values.as_mut_ptr())
                })?;
                self.show(|_| followed::values(&values));
                Values::Real(values)
            }
            Basic::Integer => {
                let mut values = vec![0; n];
                let shown = |f: &Followed| f.names(&Kind::Integer, references);
                // SAFETY: as above.
                self.get(Call::GetInteger, shown, |f, c| unsafe {
                    (f.get_integer)(c, r, n, values.as_mut_ptr())
                })?;
                self.show(|_| followed::values(&values));
                Values::Integer(values)
            }
            Basic::Boolean => {
                let mut values: Vec<Bool> = vec![0; n];
                let shown = |f: &Followed| f.names(&Kind::Boolean, references);
                // SAFETY: as above.
                self.get(Call::GetBoolean, shown, |f, c| unsafe {
                    (f.get_boolean)(c, r, n, values.as_mut_ptr())
                })?;
                self.show(|_| followed::values(&values));
                Values::Boolean(values.iter().map(|&value| value != 0).collect())
            }
            Basic::String => {
                let mut pointers: Vec<*const c_char> = vec![ptr::null(); n];
                let shown = |f: &Followed| f.names(&Kind::String, references);
                // SAFETY: as above.
                self.get(Call::GetString, shown, |f, c| unsafe {
                    (f.get_string)(c, r, n, pointers.as_mut_ptr())
                })?;
                // The strings live until the next call.
                let values: Vec<String> = pointers.into_iter().map(text).collect();
                self.show(|_| followed::values(&values));
                Values::String(values)
            }
        };
        Ok(Given::Values(values))
    }

    fn relay_step(&mut self, t: f64, h: f64) -> Result<Given> {
        let do_step = self.stepping(Call::DoStep)?.do_step;
        self.time = near(t, self.time);
        let mut came = status::OK;
        let shown = |_: &Followed| format!("{t:?}, {h:?}, false");
        self.call(Call::DoStep, shown, |_, c| {
            // SAFETY: `c` is alive. An earlier state may be restored later: the caller may go back.
            came = unsafe { do_step(c, t, h, 0) };
            if matches!(came, status::PENDING | status::DISCARD) { status::OK } else { came }
        })?;
        if came == status::PENDING {
            came = self.wait()?;
        }
        if came == status::DISCARD {
            // The FMU reports it itself if it wants the run to end.
            self.reached(self.time, near(h, Time::ZERO))?;
            return Err(self.failed(Call::DoStep, came));
        }
        if came != status::OK && came != status::WARNING {
            return Err(self.failed(Call::DoStep, came));
        }
        self.time = near(t + h, self.time);
        Ok(Given::Done)
    }

    fn relay_restore(&mut self, bytes: &[u8]) -> Result<Given> {
        let mut saved: FmuState = ptr::null_mut();
        let shown = |_: &Followed| format!("{} bytes", bytes.len());
        let mut result = self.call(Call::DeSerializeFmuState, shown, |f, c| {
            // SAFETY: the array has that length; `saved` is NULL, a new state is put there.
            unsafe { (f.deserialize)(c, bytes.as_ptr(), bytes.len(), &mut saved) }
        });
        if saved.is_null() {
            return result.and(Err(self.without(Call::DeSerializeFmuState)));
        }
        if result.is_ok() {
            // SAFETY: `saved` is a state of this live instance, here and below.
            let set = |f: &Functions, c: Component| unsafe { (f.set_state)(c, saved) };
            result = self.call(Call::SetFmuState, nothing, set);
        }
        if self.phase != Phase::Fatal {
            // SAFETY: as above.
            unsafe { (self.functions.free_state)(self.component, &mut saved) };
        }
        result.map(|()| Given::Done)
    }

    fn relay_slope(&mut self, unknowns: &[u32], knowns: &[u32], along: &[f64]) -> Result<Given> {
        if knowns.len() != along.len() {
            let what = format!("{} knowns, {} values", knowns.len(), along.len());
            return Err(Error::new(Code::Protocol, what));
        }
        let mut values = vec![0.0; unknowns.len()];
        self.get(Call::GetDirectionalDerivative, nothing, |f, c| {
            let (unknown, n) = (unknowns.as_ptr(), unknowns.len());
            let (known, m) = (knowns.as_ptr(), knowns.len());
            let (along, into) = (along.as_ptr(), values.as_mut_ptr());
            // SAFETY: `c` is alive; each pair of arrays has its length.
            unsafe { (f.directional)(c, unknown, n, known, m, along, into) }
        })?;
        Ok(Given::Values(Values::Real(values)))
    }

    fn texts(&self, texts: &[String]) -> Result<Vec<CString>> {
        let text = |text: &String| {
            CString::new(text.as_str()).map_err(|e| {
                Error::new(Code::Parameter, format!("a String of '{}' contains NUL", self.name))
                    .why(e)
            })
        };
        texts.iter().map(text).collect()
    }
}

/// The instant for messages; an invalid time leaves the last one.
fn near(seconds: f64, last: Time) -> Time {
    Time::try_from_seconds(seconds).unwrap_or(last)
}
