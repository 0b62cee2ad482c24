//! Values that are no numbers, by number.
//!
//! A master carries `f64`, which every FMI Real, Integer and Boolean is exactly. A String is
//! carried as its place in one table of this process: equal Strings have equal numbers, so what is
//! done with values (passed on, compared, kept, recorded) needs no second way, and that of Reals
//! stays as it is. Other types that are no `f64` would come in here, too.
//!
//! Places are never given up, for results hold them: a String that changes in each step takes
//! memory for each of its values.

use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};

#[derive(Default)]
struct Table {
    texts: Vec<Arc<str>>,
    places: HashMap<Arc<str>, usize>,
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
}

static TABLE: LazyLock<Mutex<Table>> = LazyLock::new(|| {
    let mut table = Table::default();
    // Values that nobody has given yet are 0.
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
}
