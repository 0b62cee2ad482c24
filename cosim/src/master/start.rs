//! Start values: given where some tool expects them, and read back.
//!
//! FMI 2.0 allows to set them from the instantiation to the end of initialization mode. There are
//! FMUs that need them before `fmi2SetupExperiment`, FMUs whose `fmi2SetupExperiment` or
//! `fmi2EnterInitializationMode` goes back to their defaults, and FMUs that refuse them in one of
//! these modes. So they are set before and after the former, and those that are still not taken once
//! more in initialization mode. What is refused there too is an error.

use crate::error::{Error, Result};
use crate::fmi::{Instance, Kind, Value};
use crate::time::Time;

/// At most so many values are named in a warning.
const NAMED: usize = 5;
/// What an FMU computes with single precision is taken.
const ROUNDING: f64 = 1e-6;

/// The start values of one instance.
pub(super) struct StartValues {
    values: Vec<(usize, Value)>,
    /// What the FMU said when it did not take them yet.
    refused: Option<Error>,
}

impl StartValues {
    /// Gives them to an instance that was just made. One that refuses them is asked again later.
    pub(super) fn new(instance: &mut Instance, values: &[(usize, Value)]) -> Result<Self> {
        let mut made = Self { values: values.to_vec(), refused: None };
        made.again(instance)?;
        Ok(made)
    }

    /// The same after a reset.
    pub(super) fn again(&mut self, instance: &mut Instance) -> Result<()> {
        self.refused = instance.attempt(|instance| give(instance, &self.values))?.err();
        Ok(())
    }

    /// Gives them and enters initialization mode; a warning if some were not taken.
    pub(super) fn enter(
        &mut self,
        instance: &mut Instance,
        start: Time,
        stop: Time,
    ) -> Result<Option<String>> {
        let values = &self.values;
        // An FMU that comes no further failed where it refused a value first.
        let mut refused = self.refused.take();
        instance.set_up(start, stop).map_err(|error| refused.take().unwrap_or(error))?;
        refused = match instance.attempt(|instance| give(instance, values))? {
            Ok(()) => None,
            Err(error) => refused.or(Some(error)),
        };
        instance.enter().map_err(|error| refused.take().unwrap_or(error))?;
        let given = last_of_each(instance, values);
        if refused.is_none() && lost(instance, &given)?.is_empty() {
            return Ok(None);
        }
        // All of them in their order, for one may act on another.
        let last = instance.attempt(|instance| give(instance, values))?;
        if let (Err(_), Some(refused)) = (last, refused) {
            return Err(refused);
        }
        let lost = lost(instance, &given)?;
        Ok((!lost.is_empty()).then(|| words(instance, &lost)))
    }
}

fn give(instance: &mut Instance, values: &[(usize, Value)]) -> Result<()> {
    let fmu = instance.fmu().clone();
    values.iter().try_for_each(|(variable, value)| {
        instance.set_value(&fmu.description().variables[*variable], value)
    })
}

/// Of several names of one variable the last value counts.
fn last_of_each<'v>(instance: &Instance, values: &'v [(usize, Value)]) -> Vec<&'v (usize, Value)> {
    let fmu = instance.fmu();
    let key = |variable: usize| {
        let described = &fmu.description().variables[variable];
        let basic = match described.kind {
            Kind::Enumeration(_) => Kind::Integer.name(),
            ref kind => kind.name(),
        };
        (basic, described.value_reference)
    };
    let later = |place: usize, wanted| values[place..].iter().any(|(v, _)| key(*v) == wanted);
    let each = values.iter().enumerate();
    each.filter(|(place, (v, _))| !later(place + 1, key(*v))).map(|(_, given)| given).collect()
}

/// The values that an FMU does not have, as far as it can be asked, and what it has instead.
fn lost<'v>(
    instance: &mut Instance,
    given: &[&'v (usize, Value)],
) -> Result<Vec<(usize, &'v Value, Value)>> {
    let fmu = instance.fmu().clone();
    let mut lost = Vec::new();
    for (position, value) in given {
        let variable = &fmu.description().variables[*position];
        let found = instance.attempt(|instance| instance.get_value(variable))?;
        let found = found.ok().filter(|found| !taken(value, found));
        lost.extend(found.map(|found| (*position, value, found)));
    }
    Ok(lost)
}

fn taken(given: &Value, found: &Value) -> bool {
    match (given, found) {
        (Value::Real(given), Value::Real(found)) => {
            given == found || (given - found).abs() <= ROUNDING * given.abs()
        }
        _ => given == found,
    }
}

fn words(instance: &Instance, refused: &[(usize, &Value, Value)]) -> String {
    let variables = &instance.fmu().description().variables;
    let named = refused.iter().take(NAMED).map(|(variable, value, found)| {
        format!("{} = {value} (it has {found})", variables[*variable].name)
    });
    let named: Vec<String> = named.collect();
    let more = match refused.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("'{}' does not take start values: {}{more}", instance.name(), named.join(", "))
}
