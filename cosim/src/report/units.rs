//! Units of recorded variables: those that a system describes, else those of the file of results, else
//! those that names suggest.

use std::collections::HashMap;

use crate::fmi::Kind;
use crate::observe::Recording;
use crate::system::System;
use crate::units::suggested::suggested;

/// Units by names.
#[derive(Debug, Clone, Default)]
pub struct Units {
    described: HashMap<String, String>,
}

impl Units {
    /// Of all recorded variables of a system.
    pub fn of(system: &System) -> Self {
        let described = system.columns().iter().filter_map(|column| {
            // What is counted or switched has no dimension.
            let plain = || (column.kind != Kind::Real).then_some("1");
            Some((column.name.clone(), column.unit().or_else(plain)?.to_owned()))
        });
        Self { described: described.collect() }
    }

    /// Those that a file of results has; `self` goes before them.
    #[must_use]
    pub fn or_of(mut self, recording: &Recording) -> Self {
        for (name, unit) in recording.units() {
            self.described.entry(name.to_owned()).or_insert_with(|| unit.to_owned());
        }
        self
    }

    /// The variables that a description has units of.
    pub(crate) fn names(&self) -> Vec<String> {
        self.described.keys().cloned().collect()
    }

    /// The unit of a variable, if it is known.
    pub fn unit(&self, name: &str) -> Option<&str> {
        self.described.get(name).map(String::as_str).or_else(|| suggested(name))
    }
}

impl Units {
    /// A name with its unit, as an axis has it.
    pub(crate) fn labelled(&self, name: &str) -> String {
        self.unit(name).map_or_else(|| name.to_owned(), |unit| format!("{name} ({unit})"))
    }
}
