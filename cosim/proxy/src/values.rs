//! Values that arrived with the last step: what the importer reads after each one.

use std::collections::HashMap;

use cosim_import::Basic;
use cosim_import::calls::{Ask, Given, Values};

/// The variables that are read after steps, and their values if they are current.
pub(crate) struct Known {
    lists: [List; Basic::ALL.len()],
}

#[derive(Default)]
struct List {
    references: Vec<u32>,
    places: HashMap<u32, usize>,
    values: Option<Values>,
}

impl Known {
    /// These Reals are expected to be read.
    pub(crate) fn new(reals: &[u32]) -> Self {
        let mut known = Self { lists: Default::default() };
        known.expect(Basic::Real, reals);
        known
    }

    /// From now on, these are requested with every step.
    pub(crate) fn expect(&mut self, basic: Basic, references: &[u32]) {
        let list = &mut self.lists[basic as usize];
        for &reference in references {
            let next = list.references.len();
            if *list.places.entry(reference).or_insert(next) == next {
                list.references.push(reference);
            }
        }
        if list.values.as_ref().is_some_and(|values| values.len() != list.references.len()) {
            list.values = None;
        }
    }

    /// The calls that read all of them.
    pub(crate) fn asks(&self) -> impl Iterator<Item = Ask> + '_ {
        let lists = Basic::ALL.into_iter().zip(&self.lists);
        let used = lists.filter(|(_, list)| !list.references.is_empty());
        used.map(|(basic, list)| Ask::Get(basic, list.references.clone()))
    }

    /// Takes the results of these calls.
    pub(crate) fn take(&mut self, given: impl Iterator<Item = Given>) {
        let used = self.lists.iter_mut().filter(|list| !list.references.is_empty());
        for (list, given) in used.zip(given) {
            list.values = match given {
                Given::Values(values) if values.len() == list.references.len() => Some(values),
                _ => None,
            };
        }
    }

    /// Something was set or done: the known values are outdated.
    pub(crate) fn age(&mut self) {
        self.lists.iter_mut().for_each(|list| list.values = None);
    }

    /// Some of them cannot be read: from now on, only variables that are read again are requested.
    pub(crate) fn forget(&mut self) {
        self.lists = Default::default();
    }

    /// Reals that are known.
    #[inline]
    pub(crate) fn reals(&self, references: &[u32], into: &mut [f64]) -> Option<()> {
        let list = &self.lists[Basic::Real as usize];
        let Some(Values::Real(values)) = &list.values else {
            return None;
        };
        // Most importers read the same variables in the same order, all of them.
        if references == list.references {
            into.copy_from_slice(values);
            return Some(());
        }
        for (reference, place) in references.iter().zip(into) {
            *place = values[*list.places.get(reference)?];
        }
        Some(())
    }

    /// Values of any type, if all are known.
    pub(crate) fn values(&self, basic: Basic, references: &[u32]) -> Option<Values> {
        let list = &self.lists[basic as usize];
        let places = references.iter().map(|reference| list.places.get(reference).copied());
        let places: Vec<usize> = places.collect::<Option<_>>()?;
        fn chosen<T: Clone>(values: &[T], places: &[usize]) -> Vec<T> {
            places.iter().map(|&place| values[place].clone()).collect()
        }
        Some(match list.values.as_ref()? {
            Values::Real(values) => Values::Real(chosen(values, &places)),
            Values::Integer(values) => Values::Integer(chosen(values, &places)),
            Values::Boolean(values) => Values::Boolean(chosen(values, &places)),
            Values::String(values) => Values::String(chosen(values, &places)),
        })
    }
}
