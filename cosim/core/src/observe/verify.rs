//! Where two recordings diverge.
//!
//! Values are compared bit by bit, so that -0 is not 0; all NaNs count as one, because CSV has only
//! one. Columns are matched by name, samples by number.

use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt;

use super::Recording;
use cosim_base::names;
use cosim_base::texts;

/// The result of comparing recordings A and B.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Comparison {
    /// Common columns.
    pub columns: usize,
    /// Common samples that are the same.
    pub samples: usize,
    /// Columns that only A has.
    pub only_a: Vec<String>,
    /// Columns that only B has.
    pub only_b: Vec<String>,
    /// Both have the same columns in a different order.
    pub reordered: bool,
    /// Where they first diverge.
    pub parting: Option<Parting>,
}

/// The first sample that is not the same.
#[derive(Debug, Clone, PartialEq)]
pub enum Parting {
    /// The samples are at different instants.
    Time {
        /// Number of the sample, from 0.
        sample: usize,
        /// Time in A (s).
        a: f64,
        /// Time in B (s).
        b: f64,
    },
    /// Values differ.
    Values {
        /// Number of the sample, from 0.
        sample: usize,
        /// Its time (s).
        time: f64,
        /// The variables, in the order of A.
        variables: Vec<Differing>,
    },
    /// One recording ends here, the other continues.
    End {
        /// The samples of A.
        a: usize,
        /// The samples of B.
        b: usize,
        /// The time of the last common sample (s).
        time: Option<f64>,
    },
}

/// A variable that differs.
#[derive(Debug, Clone, PartialEq)]
pub struct Differing {
    /// Its name.
    pub name: String,
    /// Its value in A.
    pub a: f64,
    /// Its value in B.
    pub b: f64,
    /// The values are Strings, given by their numbers.
    pub text: bool,
}

impl Differing {
    /// How many representable numbers apart the values are (units in the last place); `None` if one
    /// is not a number.
    pub fn ulps(&self) -> Option<u64> {
        if self.text || self.a.is_nan() || self.b.is_nan() {
            return None;
        }
        // Adjacent numbers have adjacent bits, but the order is reversed for negative ones.
        let ordered = |value: f64| match value.to_bits() as i64 {
            bits if bits < 0 => i128::from(i64::MIN) - i128::from(bits) - 1,
            bits => i128::from(bits),
        };
        u64::try_from((ordered(self.a) - ordered(self.b)).abs()).ok()
    }
}

impl fmt::Display for Differing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, a, b, text } = self;
        if *text {
            return write!(f, "{name}: {:?} and {:?}", texts::text(*a), texts::text(*b));
        }
        write!(f, "{name}: {a:?} and {b:?}")?;
        match self.ulps() {
            Some(ulps) => write!(f, ", {ulps} ULP apart"),
            None => Ok(()),
        }
    }
}

impl Comparison {
    /// Compares two recordings.
    pub fn of(a: &Recording, b: &Recording) -> Self {
        let (in_a, in_b) = (a.places(), b.places());
        let missing = |from: &HashMap<&str, usize>, of: &Recording| -> Vec<String> {
            of.names().iter().filter(|name| !from.contains_key(name.as_str())).cloned().collect()
        };
        let pairs = a.names().iter().enumerate().filter_map(|(of_a, name)| {
            let of_b = *in_b.get(name.as_str())?;
            let (a, b, text) = Recording::pair((a, of_a), (b, of_b));
            Some(Pair { name, a, b, text })
        });
        let pairs: Vec<Pair<'_>> = pairs.collect();
        let (only_a, only_b) = (missing(&in_b, a), missing(&in_a, b));
        let (samples, parting) = parting(a.time(), b.time(), &pairs);
        let reordered = only_a.is_empty() && only_b.is_empty() && a.names() != b.names();
        Self { columns: pairs.len(), samples, only_a, only_b, reordered, parting }
    }

    /// Whether both recordings are the same.
    pub fn is_same(&self) -> bool {
        self.parting.is_none() && self.only_a.is_empty() && self.only_b.is_empty()
    }

    /// For each column that only one has, the nearest name in the other: it may have been renamed.
    pub fn renamed(&self) -> Vec<(&str, &str)> {
        let others = || self.only_b.iter().map(String::as_str);
        let near = |name: &String| names::nearest(name, others());
        self.only_a.iter().filter_map(|name| Some((name.as_str(), near(name)?))).collect()
    }
}

/// A common column.
struct Pair<'a> {
    name: &'a str,
    a: Cow<'a, [f64]>,
    b: Cow<'a, [f64]>,
    text: bool,
}

/// The number of equal samples, and what follows them.
fn parting(a: &[f64], b: &[f64], pairs: &[Pair<'_>]) -> (usize, Option<Parting>) {
    let shorter = a.len().min(b.len());
    for sample in 0..shorter {
        if !same(a[sample], b[sample]) {
            return (sample, Some(Parting::Time { sample, a: a[sample], b: b[sample] }));
        }
        let differ = pairs.iter().filter(|pair| !same(pair.a[sample], pair.b[sample]));
        let variables: Vec<Differing> = differ
            .map(|p| Differing {
                name: p.name.to_owned(),
                a: p.a[sample],
                b: p.b[sample],
                text: p.text,
            })
            .collect();
        if !variables.is_empty() {
            return (sample, Some(Parting::Values { sample, time: a[sample], variables }));
        }
    }
    let time = shorter.checked_sub(1).map(|last| a[last]);
    let end = Parting::End { a: a.len(), b: b.len(), time };
    (shorter, (a.len() != b.len()).then_some(end))
}

fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan()
}

#[cfg(test)]
mod tests {
    use super::super::csv::Form;
    use super::super::{Closeness, Tolerance};
    use super::*;

    fn recording(columns: &[(&str, &[f64])]) -> Recording {
        let time = (0..columns[0].1.len()).map(|k| k as f64).collect();
        let (names, values) = columns.iter().map(|(n, v)| (n.to_string(), v.to_vec())).unzip();
        Recording::from_columns(names, time, values)
    }

    #[test]
    fn the_first_sample_that_differs_is_reported_with_all_its_variables() {
        let a = recording(&[("x", &[0.0, 1.0, 1.0]), ("y", &[0.0, -0.0, 5.0]), ("z", &[1.0; 3])]);
        let next = 1.0_f64.next_up();
        let b = recording(&[("z", &[1.0; 3]), ("x", &[0.0, next, 2.0]), ("y", &[0.0, 0.0, 5.0])]);
        let found = Comparison::of(&a, &b);
        assert!(found.reordered && !found.is_same() && found.samples == 1);
        let Some(Parting::Values { sample: 1, time: 1.0, variables }) = found.parting else {
            panic!("{found:?}")
        };
        let lines: Vec<String> = variables.iter().map(Differing::to_string).collect();
        assert_eq!(lines[0], "x: 1.0 and 1.0000000000000002, 1 ULP apart");
        assert_eq!(lines[1], "y: -0.0 and 0.0, 1 ULP apart");
    }

    #[test]
    fn ulps_are_counted_through_zero() {
        let apart = |a, b| Differing { name: String::new(), a, b, text: false }.ulps();
        assert_eq!(apart(-5e-324, 5e-324), Some(3));
        assert_eq!(apart(f64::MIN, f64::MAX), Some(2 * f64::MAX.to_bits() + 1));
        assert_eq!(apart(f64::NAN, 0.0), None);
    }

    #[test]
    fn numbers_in_quotes_are_the_same_numbers() {
        let strings = |texts: [&str; 2]| {
            let numbers = texts.map(texts::number).to_vec();
            Recording::from_columns(vec!["x".into()], vec![0.0, 1.0], vec![numbers])
                .with_forms(vec![Form::Text])
        };
        let numbers = recording(&[("x", &[1.5, 2.0])]);
        assert!(Comparison::of(&numbers, &strings(["1.5", "2"])).is_same());
        let close =
            |other: &Recording| Closeness::of(&numbers, other, &Tolerance::new()).is_close();
        assert!(close(&strings(["1.50", "2"])) && !close(&strings(["1.5", "on"])));
        let found = Comparison::of(&strings(["1.5", "on"]), &numbers);
        let Some(Parting::Values { sample: 1, variables, .. }) = found.parting else {
            panic!("{found:?}")
        };
        assert_eq!(variables[0].to_string(), "x: \"on\" and \"2.0\"");
    }

    #[test]
    fn ends_and_missing_columns_are_no_equality() {
        let a = recording(&[("x", &[f64::NAN, 1.0])]);
        assert!(Comparison::of(&a, &a).is_same());
        let short = recording(&[("x", &[f64::NAN])]);
        let end = Comparison::of(&a, &short).parting;
        assert_eq!(end, Some(Parting::End { a: 2, b: 1, time: Some(0.0) }));
        let more = recording(&[("x", &[f64::NAN, 1.0]), ("xx", &[0.0; 2])]);
        let found = Comparison::of(&more, &a);
        assert!(!found.is_same() && found.only_a == ["xx"] && found.parting.is_none());
    }
}
