//! The names of recorded variables.

use std::collections::HashMap;

/// Names in order, with their positions.
pub struct Names<'a> {
    pub(crate) ordered: Vec<&'a str>,
    places: HashMap<&'a str, usize>,
}

impl<'a> Names<'a> {
    /// For columns with distinct names.
    pub fn new(names: impl IntoIterator<Item = &'a str>) -> Self {
        let ordered: Vec<&str> = names.into_iter().collect();
        let places = ordered.iter().enumerate().map(|(place, name)| (*name, place)).collect();
        Self { ordered, places }
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        self.places.contains_key(name)
    }

    pub(crate) fn place(&self, name: &str) -> Option<usize> {
        self.places.get(name).copied()
    }
}
