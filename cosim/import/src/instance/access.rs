//! Sets and reads variables of an instance.

use std::ffi::{CString, c_char};

use fmu_standard::Call;

use super::{Followed, Instance, followed};
use crate::callbacks::text;
use crate::{Kind, Value, Variable};
use cosim_base::error::{Code, Error, Result};

impl Instance {
    /// Sets Real variables.
    #[inline(always)]
    pub fn set_real(&mut self, references: &[u32], values: &[f64]) -> Result<()> {
        self.check(Call::SetReal, references.len(), values.len())?;
        let shown = |f: &Followed| f.pairs(&Kind::Real, references, values);
        let set_real = self.hot.set_real;
        self.call(Call::SetReal, shown, |_, c| {
            // SAFETY: `c` is alive; both arrays have that length.
            unsafe { set_real(c, references.as_ptr(), references.len(), values.as_ptr()) }
        })
    }

    /// Reads Real variables.
    #[inline(always)]
    pub fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Result<()> {
        self.check(Call::GetReal, references.len(), values.len())?;
        let shown = |f: &Followed| f.names(&Kind::Real, references);
        let get_real = self.hot.get_real;
        self.get(Call::GetReal, shown, |_, c| {
            // SAFETY: `c` is alive; both arrays have that length.
            unsafe { get_real(c, references.as_ptr(), references.len(), values.as_mut_ptr()) }
        })?;
        self.show(|_| followed::values(values));
        Ok(())
    }

    /// Sets Integer and Enumeration variables.
    pub fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Result<()> {
        self.check(Call::SetInteger, references.len(), values.len())?;
        let shown = |f: &Followed| f.pairs(&Kind::Integer, references, values);
        self.call(Call::SetInteger, shown, |f, c| {
            // SAFETY: `c` is alive; both arrays have that length.
            unsafe { (f.set_integer)(c, references.as_ptr(), references.len(), values.as_ptr()) }
        })
    }

    /// Reads Integer and Enumeration variables.
    pub fn get_integer(&mut self, references: &[u32], values: &mut [i32]) -> Result<()> {
        self.check(Call::GetInteger, references.len(), values.len())?;
        let shown = |f: &Followed| f.names(&Kind::Integer, references);
        self.get(Call::GetInteger, shown, |f, c| {
            // SAFETY: `c` is alive; both arrays have that length.
            unsafe {
                (f.get_integer)(c, references.as_ptr(), references.len(), values.as_mut_ptr())
            }
        })?;
        self.show(|_| followed::values(values));
        Ok(())
    }

    /// Sets Boolean variables, in FMI's form: 0 or 1.
    pub fn set_boolean(&mut self, references: &[u32], values: &[i32]) -> Result<()> {
        self.check(Call::SetBoolean, references.len(), values.len())?;
        let shown = |f: &Followed| f.pairs(&Kind::Boolean, references, values);
        self.call(Call::SetBoolean, shown, |f, c| {
            // SAFETY: `c` is alive; both arrays have that length.
            unsafe { (f.set_boolean)(c, references.as_ptr(), references.len(), values.as_ptr()) }
        })
    }

    /// Reads Boolean variables, in FMI's form: 0 or 1.
    pub fn get_boolean(&mut self, references: &[u32], values: &mut [i32]) -> Result<()> {
        self.check(Call::GetBoolean, references.len(), values.len())?;
        let shown = |f: &Followed| f.names(&Kind::Boolean, references);
        self.get(Call::GetBoolean, shown, |f, c| {
            // SAFETY: `c` is alive; both arrays have that length.
            unsafe {
                (f.get_boolean)(c, references.as_ptr(), references.len(), values.as_mut_ptr())
            }
        })?;
        self.show(|_| followed::values(values));
        Ok(())
    }

    /// Sets one String variable.
    pub fn set_string(&mut self, reference: u32, value: &str) -> Result<()> {
        self.check(Call::SetString, 1, 1)?;
        let text = CString::new(value).map_err(|e| {
            Error::new(Code::Parameter, format!("a String of '{}' contains NUL", self.name)).why(e)
        })?;
        let pointer: *const c_char = text.as_ptr();
        let shown = |f: &Followed| f.pairs(&Kind::String, &[reference], &[value]);
        self.call(Call::SetString, shown, |f, c| {
            // SAFETY: `c` is alive; one reference and one C string that lives during the call.
            unsafe { (f.set_string)(c, &reference, 1, &pointer) }
        })
    }

    /// Sets a variable of any type; the value must be of that type.
    pub fn set_value(&mut self, variable: &Variable, value: &Value) -> Result<()> {
        let reference = [variable.value_reference];
        let result = match (&variable.kind, value) {
            (Kind::Real, Value::Real(value)) => self.set_real(&reference, &[*value]),
            (Kind::Integer | Kind::Enumeration(_), Value::Integer(value)) => {
                self.set_integer(&reference, &[*value])
            }
            (Kind::Boolean, Value::Boolean(value)) => {
                self.set_boolean(&reference, &[i32::from(*value)])
            }
            (Kind::String, Value::String(value)) => self.set_string(reference[0], value),
            (kind, value) => {
                return Err(Error::new(
                    Code::Parameter,
                    format!("'{}.{}' = {value}", self.name, variable.name),
                )
                .why(format!("the variable is of the type {}", kind.name())));
            }
        };
        result.map_err(|e| e.help(format!("the value was {} = {value}", variable.name)))
    }

    /// Reads one String variable.
    pub fn get_string(&mut self, reference: u32) -> Result<String> {
        self.check(Call::GetString, 1, 1)?;
        let mut pointer: *const c_char = std::ptr::null();
        let shown = |f: &Followed| f.names(&Kind::String, &[reference]);
        self.get(Call::GetString, shown, |f, c| {
            // SAFETY: `c` is alive; one reference and space for one pointer.
            unsafe { (f.get_string)(c, &reference, 1, &mut pointer) }
        })?;
        // The string lives until the next call.
        let value = text(pointer);
        self.show(|_| format!("{value:?}"));
        Ok(value)
    }

    /// Reads a variable of any type.
    pub fn get_value(&mut self, variable: &Variable) -> Result<Value> {
        let reference = [variable.value_reference];
        let (mut real, mut integer) = ([0.0], [0]);
        match variable.kind {
            Kind::Real => self.get_real(&reference, &mut real).map(|()| Value::Real(real[0])),
            Kind::Integer | Kind::Enumeration(_) => {
                self.get_integer(&reference, &mut integer).map(|()| Value::Integer(integer[0]))
            }
            Kind::Boolean => {
                self.get_boolean(&reference, &mut integer).map(|()| Value::Boolean(integer[0] != 0))
            }
            Kind::String => self.get_string(reference[0]).map(Value::String),
        }
    }

    #[inline(always)]
    pub(super) fn check(&self, function: Call, references: usize, values: usize) -> Result<()> {
        if references != values {
            let what = format!("{}: {references} references, {values} values", function.name());
            return Err(Error::new(Code::Fmu, what));
        }
        match function {
            // Some FMUs declare discrete variables as continuous: the caller decides on an event.
            Call::SetInteger | Call::SetBoolean | Call::SetString => self.require(Call::SetReal),
            _ => self.require(function),
        }
    }
}
