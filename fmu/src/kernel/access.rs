//! Getting and setting values: what may be read and written when (FMI 2.0.4, section 2.2.7).
//!
//! Everything can be read at any time. Parameters and inputs can be set until initialization ends,
//! then only inputs and tunable parameters. A set either takes all its values or none.

use std::ffi::{CStr, CString};
use std::ops::Range;

use fmu_standard::{Basic, Call, Phase, Status};

use super::call::accepts;
use super::instance::{Instance, new_edition};
use super::status::Trouble;
use super::table::{Group, Variable};
use super::values::{all_finite, gather};

/// The exponent of a Real; all ones if it is not finite.
const EXPONENT: u64 = 0x7FF << 52;

impl Instance {
    /// `GetReal` of values that need no computing; `None` if it is not so simple.
    ///
    /// No code of a component runs here, and nothing is computed in floating point.
    #[inline]
    pub fn get_fresh(&self, references: &[u32], into: &mut [f64]) -> Option<()> {
        if !accepts(self.run.phase, Call::GetReal) {
            return None;
        }
        let fresh = self.values.reals.get(..self.fresh_reals())?;
        gather(fresh, references, into)
    }

    /// How many of the Reals, counted from the first, are up to date.
    #[inline]
    fn fresh_reals(&self) -> usize {
        let stale = self.run.stale;
        if stale.component | stale.initial | stale.outputs {
            0
        } else if stale.derivatives {
            self.table.layout().derivatives.start
        } else {
            self.values.reals.len()
        }
    }

    /// `GetReal`
    pub fn get_real(&mut self, references: &[u32], into: &mut [f64]) -> Status {
        self.call(Call::GetReal, |me| {
            me.up_to_date(references)?;
            for (reference, place) in references.iter().zip(into) {
                match me.values.reals.get(*reference as usize) {
                    Some(value) => *place = *value,
                    None => return Err(me.unknown(Basic::Real, *reference)),
                }
            }
            Ok(())
        })
    }

    /// `GetInteger`, enumerations included
    pub fn get_integer(&mut self, references: &[u32], into: &mut [i32]) -> Status {
        self.call(Call::GetInteger, |me| {
            me.up_to_date(&[])?;
            for (reference, place) in references.iter().zip(into) {
                let value = me.values.integers.get(*reference as usize);
                *place = *value.ok_or_else(|| me.unknown(Basic::Integer, *reference))?;
            }
            Ok(())
        })
    }

    /// `GetBoolean`: passes each value to `give` with its index.
    pub fn get_boolean(&mut self, references: &[u32], mut give: impl FnMut(usize, bool)) -> Status {
        self.call(Call::GetBoolean, |me| {
            me.up_to_date(&[])?;
            for (index, reference) in references.iter().enumerate() {
                let value = me.values.booleans.get(*reference as usize);
                give(index, *value.ok_or_else(|| me.unknown(Basic::Boolean, *reference))?);
            }
            Ok(())
        })
    }

    /// `GetString`: passes each string to `give` with its index.
    pub fn get_string(&mut self, references: &[u32], mut give: impl FnMut(usize, &CStr)) -> Status {
        self.call(Call::GetString, |me| {
            me.up_to_date(&[])?;
            for (index, reference) in references.iter().enumerate() {
                let value = me.values.strings.get(*reference as usize);
                give(index, value.ok_or_else(|| me.unknown(Basic::String, *reference))?);
            }
            Ok(())
        })
    }

    /// `SetReal` of inputs during the simulation; `None` if it is not so simple.
    ///
    /// No code of a component runs here, and nothing is computed in floating point.
    #[inline]
    pub fn set_inputs(&mut self, references: &[u32], values: &[f64]) -> Option<()> {
        if !matches!(self.run.phase, Phase::Event | Phase::Continuous | Phase::Step) {
            return None;
        }
        let place = self.table.layout().inputs.clone();
        let first = place.start;
        let inputs = self.values.reals.get_mut(place)?;
        let index = |reference: u32| (reference as usize).wrapping_sub(first);
        // All or none, so this takes two passes.
        let (mut largest, mut changed) = (0, 0);
        for (reference, value) in references.iter().zip(values) {
            let before = inputs.get(index(*reference))?;
            changed |= before.to_bits() ^ value.to_bits();
            largest = largest.max(value.to_bits() & EXPONENT);
        }
        if largest == EXPONENT {
            return None;
        }
        // Setting a value to what it already is leaves outputs and derivatives unchanged.
        if changed != 0 {
            for (reference, value) in references.iter().zip(values) {
                if let Some(place) = inputs.get_mut(index(*reference)) {
                    *place = *value;
                }
            }
            self.run.stale.outputs = true;
            self.run.stale.derivatives = true;
        }
        Some(())
    }

    /// `SetReal`
    pub fn set_real(&mut self, references: &[u32], values: &[f64]) -> Status {
        self.call(Call::SetReal, |me| {
            let inputs = me.table.layout().inputs.clone();
            let first = if me.is_starting() { 0 } else { inputs.start };
            let settable = first..inputs.end;
            let tunable = |reference: &u32| {
                me.table.find(Basic::Real, *reference).is_some_and(Variable::is_settable_later)
            };
            let outside =
                |reference: &u32| !settable.contains(&(*reference as usize)) && !tunable(reference);
            let any = me.table.takes_any_input()
                && references.iter().all(|reference| inputs.contains(&(*reference as usize)));
            if references.iter().any(outside) || !(any || all_finite(values)) {
                return Err(me.cannot_set_reals(&settable, references, values));
            }
            if references.iter().any(|reference| !inputs.contains(&(*reference as usize))) {
                me.check_bounds(Basic::Real, references, values)?;
            }
            assign(&mut me.values.reals, references, values);
            me.changed(references, |explicit| &mut explicit.reals)
        })
    }

    /// `SetInteger`, enumerations included
    pub fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Status {
        if self.changes_nothing(Basic::Integer, references, values, &self.values.integers) {
            return Status::Ok;
        }
        self.call(Call::SetInteger, |me| {
            me.check_settable(Basic::Integer, references)?;
            me.check_bounds(Basic::Integer, references, values)?;
            assign(&mut me.values.integers, references, values);
            me.changed(references, |explicit| &mut explicit.integers)
        })
    }

    /// `SetBoolean`
    pub fn set_boolean(&mut self, references: &[u32], values: &[bool]) -> Status {
        if self.changes_nothing(Basic::Boolean, references, values, &self.values.booleans) {
            return Status::Ok;
        }
        self.call(Call::SetBoolean, |me| {
            me.check_settable(Basic::Boolean, references)?;
            assign(&mut me.values.booleans, references, values);
            me.changed(references, |explicit| &mut explicit.booleans)
        })
    }

    /// `SetString`; `None` stands for NULL.
    pub fn set_string(&mut self, references: &[u32], values: &[Option<CString>]) -> Status {
        self.call(Call::SetString, |me| {
            me.check_settable(Basic::String, references)?;
            let mut texts = Vec::with_capacity(values.len());
            for (reference, value) in references.iter().zip(values) {
                let wrong = match value {
                    Some(text) if text.to_str().is_ok() => {
                        texts.push(text.clone());
                        continue;
                    }
                    Some(_) => "the text is not UTF-8",
                    None => "the text is NULL",
                };
                let name = me.name(Basic::String, *reference);
                return Err(Trouble::error(format_args!("{name}: {wrong}")));
            }
            assign(&mut me.values.strings, references, &texts);
            me.changed(references, |explicit| &mut explicit.strings)
        })
    }

    fn is_starting(&self) -> bool {
        matches!(self.run.phase, Phase::Instantiated | Phase::Initialization)
    }

    /// Computes stale values before they are read.
    #[inline]
    fn up_to_date(&mut self, reals: &[u32]) -> Result<(), Trouble> {
        if self.run.stale.any() { self.bring_up_to_date(reals) } else { Ok(()) }
    }

    fn bring_up_to_date(&mut self, reals: &[u32]) -> Result<(), Trouble> {
        if self.run.stale.component | self.run.stale.initial | self.run.stale.outputs {
            match self.refresh() {
                // Only half of the parameters may be set by now: keep the older values.
                Err(_) if self.run.phase == Phase::Instantiated => return Ok(()),
                done => done?,
            }
        }
        let derivatives = &self.table.layout().derivatives;
        if reals.iter().any(|reference| derivatives.contains(&(*reference as usize))) {
            self.refresh_derivatives()
        } else {
            Ok(())
        }
    }

    /// Records what was set and what depends on it.
    #[inline]
    fn changed(
        &mut self,
        references: &[u32],
        list: impl FnOnce(&mut super::values::Explicit) -> &mut Box<[bool]>,
    ) -> Result<(), Trouble> {
        self.run.stale.outputs = true;
        self.run.stale.derivatives = true;
        self.run.stale.initial |= self.is_starting();
        let explicit = list(&mut self.explicit);
        for reference in references {
            if let Some(set) = explicit.get_mut(*reference as usize) {
                *set = true;
                self.run.stale.component = true;
                self.edition = new_edition();
            }
        }
        // A tunable one acts at once: steps and derivatives use the component as it is.
        match self.run.stale.component && !self.is_starting() {
            true => self.refresh(),
            false => Ok(()),
        }
    }

    /// Whether inputs are set to their present values in continuous-time mode. FMI allows setting
    /// discrete ones only at events, where FMPy changes them; but FMPy also sets them in between.
    fn changes_nothing<T: PartialEq>(
        &self,
        kind: Basic,
        references: &[u32],
        values: &[T],
        all: &[T],
    ) -> bool {
        let is_input = |reference: u32| {
            self.table.find(kind, reference).is_some_and(|v| v.group == Group::Input)
        };
        self.run.phase == Phase::Continuous
            && !references.is_empty()
            && references.iter().zip(values).all(|(reference, value)| {
                is_input(*reference) && all.get(*reference as usize) == Some(value)
            })
    }

    /// Whether variables other than Reals can be set now.
    fn check_settable(&self, kind: Basic, references: &[u32]) -> Result<(), Trouble> {
        for reference in references {
            match self.table.find(kind, *reference) {
                None => return Err(self.unknown(kind, *reference)),
                Some(variable) if variable.is_settable_later() => {}
                Some(variable) if self.is_starting() && variable.group == Group::Parameter => {}
                Some(variable) => return Err(self.not_settable(variable)),
            }
        }
        Ok(())
    }

    /// Parameters must be within their declared bounds, enumerations among their items.
    fn check_bounds<T: Copy + Into<f64>>(
        &self,
        kind: Basic,
        references: &[u32],
        values: &[T],
    ) -> Result<(), Trouble> {
        use crate::author::Start;
        for (reference, value) in references.iter().zip(values) {
            let value: f64 = (*value).into();
            let Some(variable) = self.table.find(kind, *reference) else {
                continue;
            };
            let items = matches!(variable.start, Start::Enumeration { .. });
            if variable.group != Group::Parameter && !items {
                continue;
            }
            let (min, max) = match &variable.start {
                Start::Enumeration { items, .. } => (1.0, items.len() as f64),
                _ => (variable.min.unwrap_or(f64::MIN), variable.max.unwrap_or(f64::MAX)),
            };
            if !(min..=max).contains(&value) {
                return Err(Trouble::error(format_args!(
                    "{} = {value} is not within {min:?} and {max:?}",
                    variable.name
                )));
            }
        }
        Ok(())
    }

    /// Why the first of the rejected values cannot be set.
    #[cold]
    fn cannot_set_reals(
        &self,
        settable: &Range<usize>,
        references: &[u32],
        values: &[f64],
    ) -> Trouble {
        let bad = |(reference, value): &(&u32, &f64)| {
            !settable.contains(&(**reference as usize)) || !value.is_finite()
        };
        let Some((reference, value)) = references.iter().zip(values).find(bad) else {
            return Trouble::error("a value cannot be set");
        };
        match self.table.find(Basic::Real, *reference) {
            None => self.unknown(Basic::Real, *reference),
            Some(variable) if !settable.contains(&(*reference as usize)) => {
                self.not_settable(variable)
            }
            Some(variable) => {
                self.doubtful(format_args!("{} = {value} is not finite", variable.name))
            }
        }
    }

    fn not_settable(&self, variable: &Variable) -> Trouble {
        let why = match variable.group {
            Group::Parameter => "is fixed once initialization is over; reset to change it",
            Group::Input => "is an input",
            Group::Output | Group::State | Group::Derivative => "is calculated",
            Group::Time => "is the independent variable",
        };
        Trouble::error(format_args!("{} cannot be set: it {why}", variable.name))
    }

    #[cold]
    fn unknown(&self, kind: Basic, reference: u32) -> Trouble {
        let n = match kind {
            Basic::Real => self.values.reals.len(),
            Basic::Integer => self.values.integers.len(),
            Basic::Boolean => self.values.booleans.len(),
            Basic::String => self.values.strings.len(),
        };
        Trouble::error(match n.checked_sub(1) {
            Some(last) => {
                format!("no {kind:?} has value reference {reference}; the last is {last}")
            }
            None => format!("no {kind:?} has value reference {reference}; there are none"),
        })
    }

    fn name(&self, kind: Basic, reference: u32) -> &str {
        self.table.find(kind, reference).map_or("?", |variable| variable.name.as_str())
    }
}

fn assign<T: Clone>(all: &mut [T], references: &[u32], values: &[T]) {
    for (reference, value) in references.iter().zip(values) {
        if let Some(place) = all.get_mut(*reference as usize) {
            place.clone_from(value);
        }
    }
}
