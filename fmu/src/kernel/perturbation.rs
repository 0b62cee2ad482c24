//! Random admissible values of variables, the same in every run, for probing a component.

use crate::author::Start;

use super::table::{Group, Variable};
use super::values::Values;

/// Changes a variable to another admissible value; false if that is impossible for its type.
pub(crate) fn shift(variable: &Variable, values: &mut Values, random: &mut Random) -> bool {
    let reference = variable.reference as usize;
    match &variable.start {
        Start::Real(start) => set(&mut values.reals, reference, real(variable, *start, random)),
        Start::Integer(start) => {
            let number = real(variable, f64::from(*start), random).round();
            set(&mut values.integers, reference, number as i32)
        }
        Start::Enumeration { items, .. } => {
            let item = 1 + random.below(items.len() as u64) as i32;
            set(&mut values.integers, reference, item)
        }
        Start::Boolean(_) => {
            let now = values.booleans.get(reference).copied().unwrap_or_default();
            set(&mut values.booleans, reference, !now)
        }
        Start::String(_) => false,
    }
}

pub(crate) fn set<T>(values: &mut [T], reference: usize, value: T) -> bool {
    values.get_mut(reference).map(|place| *place = value).is_some()
}

/// A value near the start, at a bound, or of the nominal size times a power of ten, within the
/// bounds. Inputs vary most, so that saturated and distant regions are covered as well.
fn real(variable: &Variable, start: f64, random: &mut Random) -> f64 {
    let (min, max) = (variable.min.unwrap_or(f64::MIN), variable.max.unwrap_or(f64::MAX));
    let scale = variable.nominal.unwrap_or(if start == 0.0 { 1.0 } else { start.abs() });
    let powers = match variable.group {
        Group::Input => 4,
        Group::State => 2,
        _ => 1,
    };
    let reach = (0..random.below(powers)).fold(scale, |reach, _| 10.0 * reach);
    let value = match (random.below(8), variable.min, variable.max) {
        (0, Some(min), _) => min,
        (1, _, Some(max)) => max,
        (2, Some(min), Some(max)) => min + (max - min) * random.unit(),
        (3 | 4, ..) => start + 1e-3 * scale * (2.0 * random.unit() - 1.0),
        _ => start + reach * (2.0 * random.unit() - 1.0),
    };
    value.clamp(min, max)
}

/// SplitMix64 (Steele, Lea and Flood 2014): the random numbers for probing.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn below(&mut self, n: u64) -> u64 {
        self.next() % n.max(1)
    }
}
