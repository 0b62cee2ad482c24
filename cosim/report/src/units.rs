//! Units of recorded variables: those in the description of a system, otherwise those in the
//! results file, otherwise those suggested by names.

use std::collections::HashMap;

use super::grouping::group_name;
use cosim_base::names::Aliases;
use cosim_base::units::suggested::suggested;
use cosim_core::observe::Recording;
use cosim_core::system::System;
use cosim_import::Kind;
use cosim_results::roles::base_factor;

/// Units by name.
#[derive(Debug, Clone, Default)]
pub struct Units {
    described: HashMap<String, String>,
}

impl Units {
    /// For all recorded variables of a system.
    pub fn of(system: &System) -> Self {
        let described = system.columns().iter().filter_map(|column| {
            // Counts and switches have no dimension.
            let plain = || (column.kind != Kind::Real).then_some("1");
            Some((column.name.clone(), column.unit().or_else(plain)?.to_owned()))
        });
        Self { described: described.collect() }
    }

    /// Adds the units in a results file; those of `self` take precedence.
    #[must_use]
    pub fn or_of(mut self, recording: &Recording) -> Self {
        for (name, unit) in recording.units() {
            self.described.entry(name.to_owned()).or_insert_with(|| unit.to_owned());
        }
        self
    }

    /// Adds other units; those of `self` take precedence.
    #[must_use]
    pub(crate) fn or(mut self, other: Self) -> Self {
        for (name, unit) in other.described {
            self.described.entry(name).or_insert(unit);
        }
        self
    }

    /// The same variables also under other names.
    pub fn with(mut self, aliases: &Aliases) -> Self {
        let by_alias = |(name, unit): (&String, &String)| {
            let fitting = aliases.pairs().iter().filter_map(|(alias, meant)| {
                let rest = name.strip_prefix(meant.as_str())?;
                let alias = rest.starts_with('.').then(|| format!("{alias}{rest}"))?;
                Some((alias, unit.clone()))
            });
            fitting.collect::<Vec<_>>()
        };
        let more: Vec<_> = self.described.iter().flat_map(by_alias).collect();
        self.described.extend(more);
        self
    }

    /// The variables for which a description has units.
    pub fn names(&self) -> Vec<String> {
        self.described.keys().cloned().collect()
    }

    /// Variables of which this is equal may share an axis: those with the same unit, and elements of
    /// an array whose unit is not known.
    pub(crate) fn axis(&self, name: &str) -> (bool, String) {
        match self.unit(name) {
            Some(unit) => (true, unit.to_owned()),
            None if name.contains('[') => (false, group_name(name)),
            None => (false, name.to_owned()),
        }
    }

    /// By what an angle is multiplied to be in radians.
    pub(crate) fn radians(&self, name: &str) -> f64 {
        base_factor(self.unit(name))
    }

    /// The unit of a variable, if it is known.
    pub fn unit(&self, name: &str) -> Option<&str> {
        self.described.get(name).map(String::as_str).or_else(|| suggested(name))
    }
}

impl Units {
    /// A name with its unit, for an axis label.
    pub(crate) fn labelled(&self, name: &str) -> String {
        self.unit(name).map_or_else(|| name.to_owned(), |unit| format!("{name} ({unit})"))
    }
}
