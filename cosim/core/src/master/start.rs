//! Start values: set at all points where some tool expects them, and read back.
//!
//! FMI 2.0 allows setting them from instantiation to the end of initialization mode. Some FMUs need
//! them before `fmi2SetupExperiment`, in some `fmi2SetupExperiment` or
//! `fmi2EnterInitializationMode` restores their defaults, and some refuse them in one of these
//! modes. They are therefore set before and after the former, and those that are still not accepted
//! once more in initialization mode. A value that is refused there too is an error. Parameters are
//! read back again after that mode, which some FMUs end with their defaults.

use cosim_base::error::{Error, Result};
use cosim_base::time::Time;
use cosim_import::{Causality, Instance, Kind, Value};

/// The maximum number of values named in a warning.
const NAMED: usize = 5;
/// Accepts values that an FMU computes in single precision.
const ROUNDING: f64 = 1e-6;

/// The start values of one instance.
pub(super) struct StartValues {
    values: Vec<(usize, Value)>,
    /// The error of the FMU when it did not accept them yet.
    refused: Option<Error>,
}

impl StartValues {
    /// Sets them in a new instance. If it refuses them, they are set again later.
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

    /// Sets them and enters initialization mode; returns a warning if some were not accepted.
    pub(super) fn enter(
        &mut self,
        instance: &mut Instance,
        start: Time,
        stop: Time,
    ) -> Result<Option<String>> {
        let values = &self.values;
        // If the FMU gets no further, the cause is the value that it refused first.
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
        // All of them in order, because one may affect another.
        let last = instance.attempt(|instance| give(instance, values))?;
        if let (Err(_), Some(refused)) = (last, refused) {
            return Err(refused);
        }
        let lost = lost(instance, &given)?;
        Ok((!lost.is_empty()).then(|| words(instance, "does not accept start values", &lost)))
    }
}

impl StartValues {
    /// Leaves initialization mode; returns a warning if that changes parameters that were given.
    pub(super) fn exit(&self, instance: &mut Instance) -> Result<Option<String>> {
        let fmu = instance.fmu().clone();
        let mut before = Vec::new();
        for (position, _) in last_of_each(instance, &self.values) {
            let variable = &fmu.description().variables[*position];
            if variable.causality == Causality::Parameter {
                let value = instance.attempt(|instance| instance.get_value(variable))?;
                before.extend(value.ok().map(|value| (*position, value)));
            }
        }
        instance.exit_initialization()?;
        let lost = lost(instance, &before.iter().collect::<Vec<_>>())?;
        let loses = "loses start values at the end of its initialization";
        Ok((!lost.is_empty()).then(|| words(instance, loses, &lost)))
    }
}

fn give(instance: &mut Instance, values: &[(usize, Value)]) -> Result<()> {
    let fmu = instance.fmu().clone();
    values.iter().try_for_each(|(variable, value)| {
        instance.set_value(&fmu.description().variables[*variable], value)
    })
}

/// If one variable has several names, the last value counts.
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

/// The values that an FMU does not have, as far as they can be read, and what it has instead.
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

fn words(instance: &Instance, what: &str, refused: &[(usize, &Value, Value)]) -> String {
    let variables = &instance.fmu().description().variables;
    let named = refused.iter().take(NAMED).map(|(variable, value, found)| {
        format!("{} = {value} (it has {found})", variables[*variable].name)
    });
    let named: Vec<String> = named.collect();
    let more = match refused.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("'{}' {what}: {}{more}", instance.name(), named.join(", "))
}
