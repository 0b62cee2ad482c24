//! Strings, represented by numbers.
//!
//! A String that a master passes on is its position in a table of this process: equal Strings have
//! equal numbers, so passing on, comparing and storing need no second code path. Recorders and
//! results represent values of all types by an `f64`, a String by its number. Binary data of FMI
//! 3.0 could be entries of such a table too.
//!
//! A String that changes in each step takes memory for each of its values, until the last [`Scope`]
//! ends if there is one.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

struct Table {
    /// The empty String has the number 0 and no entry: values that have not been set yet are 0.
    texts: Vec<Arc<str>>,
    numbers: BTreeMap<Arc<str>, usize>,
    /// How many scopes exist, and how many entries there were when the first of them began.
    scopes: usize,
    before: usize,
}

impl Table {
    const fn new() -> Self {
        Self { texts: Vec::new(), numbers: BTreeMap::new(), scopes: 0, before: 0 }
    }

    fn number(&mut self, text: &str) -> usize {
        if text.is_empty() {
            return 0;
        }
        if let Some(number) = self.numbers.get(text) {
            return *number;
        }
        let text = Arc::<str>::from(text);
        self.texts.push(text.clone());
        self.numbers.insert(text, self.texts.len());
        self.texts.len()
    }

    fn text(&self, number: f64) -> Option<Arc<str>> {
        let place = (number as usize).checked_sub(1)?;
        self.texts.get(place).cloned()
    }

    fn begin(&mut self) {
        if self.scopes == 0 {
            self.before = self.texts.len();
        }
        self.scopes += 1;
    }

    fn end(&mut self) {
        self.scopes -= 1;
        if self.scopes == 0 {
            self.texts.truncate(self.before);
            self.numbers.retain(|_, number| *number <= self.before);
        }
        if self.scopes == 0 && self.texts.is_empty() {
            // A library that is unloaded leaves nothing.
            *self = Self::new();
        }
    }
}

/// When the last scope ends, the Strings that are new since the first one began are forgotten, and
/// their numbers become invalid. So a process that makes many runs needs no more memory than for
/// one.
#[must_use]
pub struct Scope(());

impl Scope {
    /// Begins a scope.
    pub fn begin() -> Self {
        table().begin();
        Self(())
    }
}

impl Drop for Scope {
    fn drop(&mut self) {
        table().end();
    }
}

static TABLE: Mutex<Table> = Mutex::new(Table::new());

fn table() -> MutexGuard<'static, Table> {
    TABLE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The number of a String in this process.
pub fn number(text: &str) -> f64 {
    table().number(text) as f64
}

/// The String of that number; the empty one if there is none.
pub fn text(number: f64) -> Arc<str> {
    table().text(number).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strings_are_found_again_by_their_numbers() {
        assert_eq!(number(""), 0.0);
        let (a, b) = (number("on"), number("off"));
        assert!(a != b && a == number("on"));
        assert_eq!((&*text(a), &*text(b), &*text(1e9), &*text(f64::NAN)), ("on", "off", "", ""));
    }

    #[test]
    fn strings_of_a_scope_are_forgotten_with_the_last_one() {
        let mut table = Table::new();
        let kept = table.number("known before");
        table.begin();
        let new = table.number("known in a scope");
        table.begin();
        table.end();
        assert_eq!(table.number("known in a scope"), new);
        table.end();
        assert_eq!(table.texts.len(), 1);
        assert_eq!((table.number("other"), table.number("known before")), (new, kept));
    }
}
