//! Values that are not numbers, represented by numbers.
//!
//! A master transfers `f64`, which represents every FMI Real, Integer and Boolean exactly. A String
//! is represented by its position in a table of this process: equal Strings have equal numbers, so
//! operations on values (passing on, comparing, storing, recording) need no second code path, and
//! those for Reals stay unchanged. Other types that do not fit into an `f64` could be added here.
//!
//! Results contain such numbers, so a String that changes in each step takes memory for each of its
//! values until the run's [`Scope`] ends.

use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};

#[derive(Default)]
struct Table {
    texts: Vec<Arc<str>>,
    places: HashMap<Arc<str>, usize>,
    /// How many scopes exist, and how many Strings there were when the first of them began.
    scopes: usize,
    before: usize,
}

impl Table {
    fn place(&mut self, text: &str) -> usize {
        if let Some(place) = self.places.get(text) {
            return *place;
        }
        let (text, place) = (Arc::<str>::from(text), self.texts.len());
        self.texts.push(text.clone());
        self.places.insert(text, place);
        place
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
            self.places.retain(|_, place| *place < self.before);
        }
    }
}

/// When the last scope ends, the Strings that are new since the first one began are forgotten, and
/// their numbers become invalid. So a process that makes many runs needs no more memory than for one.
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

static TABLE: LazyLock<Mutex<Table>> = LazyLock::new(|| {
    let mut table = Table::default();
    // Values that have not been set yet are 0.
    table.place("");
    Mutex::new(table)
});

fn table() -> MutexGuard<'static, Table> {
    TABLE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The number of a String in this process.
pub fn number(text: &str) -> f64 {
    table().place(text) as f64
}

/// The String of that number; the empty one if there is none.
pub fn text(number: f64) -> Arc<str> {
    let table = table();
    let place = if number >= 0.0 { number as usize } else { 0 };
    table.texts.get(place).unwrap_or(&table.texts[0]).clone()
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
        let mut table = Table::default();
        let kept = table.place("known before");
        table.begin();
        let new = table.place("known in a scope");
        table.begin();
        table.end();
        assert_eq!(table.place("known in a scope"), new);
        table.end();
        assert_eq!(table.texts.len(), 1);
        assert_eq!((table.place("other"), table.place("known before")), (new, kept));
    }
}
