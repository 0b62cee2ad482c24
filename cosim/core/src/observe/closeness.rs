//! Whether two recordings are close enough to each other.
//!
//! Samples are compared at common instants; a recording may be interpolated between its samples. A
//! value is close enough if |a - b| <= absolute + relative max(|a|, |b|).

use std::collections::HashMap;
use std::fmt;

use super::Recording;
use cosim_base::names;
use cosim_base::texts;

/// Instants are the same if they differ by at most this part of 1 s + t.
const SAME_TIME: f64 = 1e-9;

/// Allowed differences.
#[derive(Debug, Clone, Default)]
pub struct Tolerance {
    absolute: Vec<(String, f64)>,
    relative: Vec<(String, f64)>,
    interpolate: bool,
}

impl Tolerance {
    /// `None`: values must be the same.
    pub fn new() -> Self {
        Self::default()
    }

    /// The allowed difference of a variable, or of those that match a pattern (`*`, `?`). Names
    /// take precedence over patterns, later ones over earlier ones.
    #[must_use]
    pub fn absolute(mut self, variable: impl Into<String>, tolerance: f64) -> Self {
        self.absolute.push((variable.into(), tolerance));
        self
    }

    /// The same, relative to the greater value.
    #[must_use]
    pub fn relative(mut self, variable: impl Into<String>, tolerance: f64) -> Self {
        self.relative.push((variable.into(), tolerance));
        self
    }

    /// At instants that only A has, B is interpolated linearly between its samples.
    #[must_use]
    pub fn interpolate(mut self, wanted: bool) -> Self {
        self.interpolate = wanted;
        self
    }

    fn of(requests: &[(String, f64)], name: &str) -> f64 {
        let last = |fits: &dyn Fn(&str) -> bool| requests.iter().rev().find(|(w, _)| fits(w));
        let found = last(&|request| request == name)
            .or_else(|| last(&|request| names::matches(request, name)));
        found.map_or(0.0, |(_, tolerance)| *tolerance)
    }
}

/// The values of a variable at an instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Apart {
    /// Its name.
    pub name: String,
    /// The instant (s).
    pub time: f64,
    /// The value in A.
    pub a: f64,
    /// The value in B.
    pub b: f64,
    /// The values are Strings, given by their numbers.
    pub text: bool,
}

/// A variable whose values are too far apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Beyond {
    /// At how many of the samples.
    pub samples: usize,
    /// First at this instant (s).
    pub first: f64,
    /// The worst difference, as a multiple of the allowed one.
    pub worst: Apart,
}

/// The result of comparing recordings A and B.
#[derive(Debug, Clone, Default)]
pub struct Closeness {
    /// Common columns.
    pub columns: usize,
    /// Instants that were compared.
    pub samples: usize,
    /// Instants of A, and of B, that were not compared.
    pub left_out: (usize, usize),
    /// Columns that only A has, and that only B has.
    pub only: (Vec<String>, Vec<String>),
    /// The largest difference of all.
    pub largest: Option<Apart>,
    /// Variables that are too far apart, in the order of A.
    pub beyond: Vec<Beyond>,
}

impl Apart {
    /// The difference; infinite if one value is not a number, or not finite.
    pub fn difference(&self) -> f64 {
        difference(self.a, self.b)
    }
}

impl fmt::Display for Apart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, time, a, b, text } = self;
        if *text {
            let (a, b) = (texts::text(*a), texts::text(*b));
            return write!(f, "{name} at t = {time}: {a:?} and {b:?}");
        }
        write!(f, "{name} at t = {time}: {a:?} and {b:?}")?;
        let (apart, size) = (self.difference(), a.abs().max(b.abs()));
        match apart.is_finite() && size > 0.0 {
            true => write!(f, ", {apart:.3e} apart, {:.2e} of the greater", apart / size),
            false => Ok(()),
        }
    }
}

impl Closeness {
    /// Compares two recordings.
    pub fn of(a: &Recording, b: &Recording, tolerance: &Tolerance) -> Self {
        let (in_a, in_b) = (a.places(), b.places());
        let only = |these: &[String], those: &HashMap<&str, usize>| -> Vec<String> {
            these.iter().filter(|name| !those.contains_key(name.as_str())).cloned().collect()
        };
        let places = align(a.time(), b.time(), tolerance.interpolate);
        let mut found = Self {
            samples: places.len(),
            left_out: (
                a.time().len() - places.len(),
                b.time().len() - places.iter().filter(|place| place.part == 0.0).count(),
            ),
            only: (only(a.names(), &in_b), only(b.names(), &in_a)),
            ..Self::default()
        };
        if tolerance.interpolate {
            found.left_out.1 = 0;
        }
        for (place, name) in a.names().iter().enumerate() {
            let Some(&place_b) = in_b.get(name.as_str()) else { continue };
            found.columns += 1;
            let (of_a, of_b, text) = Recording::pair((a, place), (b, place_b));
            let values = (a.time(), &*of_a, &*of_b);
            match text {
                true => found.compare_texts(name, &places, values),
                false => found.compare(name, &places, values, tolerance),
            }
        }
        found
    }

    /// Whether all that was compared is close enough, and something was compared.
    pub fn is_close(&self) -> bool {
        let all = self.only.0.is_empty() && self.only.1.is_empty();
        all && self.beyond.is_empty() && self.samples > 0
    }

    /// Strings are either the same or not; in B, the previous sample counts.
    fn compare_texts(
        &mut self,
        name: &str,
        places: &[Place],
        (time, of_a, of_b): (&[f64], &[f64], &[f64]),
    ) {
        let mut differ = places.iter().filter(|p| of_a[p.a].to_bits() != of_b[p.b].to_bits());
        let Some(first) = differ.next() else { return };
        let (time, a, b) = (time[first.a], of_a[first.a], of_b[first.b]);
        let worst = Apart { name: name.to_owned(), time, a, b, text: true };
        self.beyond.push(Beyond { samples: 1 + differ.count(), first: time, worst });
    }

    fn compare(
        &mut self,
        name: &str,
        places: &[Place],
        (time, of_a, of_b): (&[f64], &[f64], &[f64]),
        tolerance: &Tolerance,
    ) {
        let absolute = Tolerance::of(&tolerance.absolute, name);
        let relative = Tolerance::of(&tolerance.relative, name);
        let mut beyond: Option<(Beyond, f64)> = None;
        for place in places {
            let (a, b) = (of_a[place.a], place.value(of_b));
            let apart = difference(a, b);
            let here = || Apart { name: name.to_owned(), time: time[place.a], a, b, text: false };
            let largest = self.largest.as_ref().map_or(0.0, Apart::difference);
            if apart > largest {
                self.largest = Some(here());
            }
            // Infinite or NaN values are close only to the same value.
            let permitted = match apart.is_finite() && apart > 0.0 {
                true => absolute + relative * a.abs().max(b.abs()),
                false => 0.0,
            };
            if apart <= permitted {
                continue;
            }
            let excess = apart / permitted;
            match &mut beyond {
                None => {
                    let first = Beyond { samples: 1, first: time[place.a], worst: here() };
                    beyond = Some((first, excess));
                }
                Some((beyond, worst)) => {
                    beyond.samples += 1;
                    // If no difference is allowed, every excess is infinite.
                    if excess > *worst || (excess == *worst && apart > beyond.worst.difference()) {
                        (*worst, beyond.worst) = (excess, here());
                    }
                }
            }
        }
        self.beyond.extend(beyond.map(|(beyond, _)| beyond));
    }
}

fn difference(a: f64, b: f64) -> f64 {
    match a == b || (a.is_nan() && b.is_nan()) {
        true => 0.0,
        false if (a - b).is_nan() => f64::INFINITY,
        false => (a - b).abs(),
    }
}

/// A sample of A, and its position in B: at a sample, or this part of the way to the next.
struct Place {
    a: usize,
    b: usize,
    part: f64,
}

impl Place {
    fn value(&self, of_b: &[f64]) -> f64 {
        match self.part {
            0.0 => of_b[self.b],
            part => of_b[self.b] + part * (of_b[self.b + 1] - of_b[self.b]),
        }
    }
}

/// Instants can occur more than once if events are recorded: the first is compared with the first.
fn align(a: &[f64], b: &[f64], interpolate: bool) -> Vec<Place> {
    let mut places = Vec::new();
    let mut next = 0;
    for (sample, &time) in a.iter().enumerate() {
        let same = SAME_TIME * (1.0 + time.abs());
        while next < b.len() && b[next] < time - same {
            next += 1;
        }
        if next == b.len() {
            break;
        }
        if b[next] <= time + same {
            places.push(Place { a: sample, b: next, part: 0.0 });
            next += 1;
        } else if interpolate && next > 0 {
            let (from, to) = (b[next - 1], b[next]);
            places.push(Place { a: sample, b: next - 1, part: (time - from) / (to - from) });
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording(time: &[f64], x: &[f64]) -> Recording {
        Recording::from_columns(vec!["m.x".to_owned()], time.to_vec(), vec![x.to_vec()])
    }

    #[test]
    fn tolerances_are_absolute_plus_relative_and_names_come_before_patterns() {
        let a = recording(&[0.0, 1.0, 2.0], &[0.0, 100.0, f64::NAN]);
        let b = recording(&[0.0, 1.0, 2.0], &[1e-4, 101.0, f64::NAN]);
        let close = |tolerance: Tolerance| Closeness::of(&a, &b, &tolerance).is_close();
        let all = Tolerance::new().absolute("*", 1e-3).relative("*", 0.02);
        assert!(close(all.clone()));
        assert!(!close(all.clone().relative("m.x", 1e-3)));
        let endless = recording(&[0.0, 1.0, 2.0], &[0.0, f64::INFINITY, f64::NAN]);
        assert!(!Closeness::of(&a, &endless, &all).is_close());
        assert!(!close(all.relative("m.?", 1e-3)));
        let found = Closeness::of(&a, &b, &Tolerance::new());
        assert_eq!(found.beyond[0].samples, 2);
        assert_eq!((found.beyond[0].first, found.beyond[0].worst.time), (0.0, 1.0));
        let text = found.largest.unwrap().to_string();
        assert_eq!(text, "m.x at t = 1: 100.0 and 101.0, 1.000e0 apart, 9.90e-3 of the greater");
        assert!(!Closeness::of(&a, &recording(&[5.0], &[0.0]), &Tolerance::new()).is_close());
    }

    #[test]
    fn instants_are_aligned_or_interpolated() {
        let a = recording(&[0.0, 0.5, 1.0, 1.5], &[0.0, 1.0, 2.0, 3.0]);
        let b = recording(&[0.0, 1.0 + 1e-12, 1.2, 2.0], &[0.0, 2.0, 9.0, 1.0]);
        let plain = Closeness::of(&a, &b, &Tolerance::new());
        assert!(plain.is_close());
        assert_eq!((plain.samples, plain.left_out), (2, (2, 2)));
        let between = Closeness::of(&a, &b, &Tolerance::new().interpolate(true));
        assert_eq!((between.samples, between.left_out), (4, (0, 0)));
        assert_eq!(between.beyond[0].worst.b, 6.0);
    }
}
