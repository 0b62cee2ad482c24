//! The flat value arrays of an instance, indexed by value reference, and which parameters the user
//! set.

use std::ffi::CString;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::author::{Count, Ports, Reader, Variables, Writer};

/// All values of an instance, one array per FMI type; a value reference is an index.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Values {
    /// Reals: parameters, inputs, outputs, states, derivatives, time.
    pub reals: Box<[f64]>,
    /// Integers and enumerations.
    pub integers: Box<[i32]>,
    /// Booleans.
    pub booleans: Box<[bool]>,
    /// Strings, terminated for C.
    pub strings: Box<[CString]>,
}

impl Values {
    /// Zeros, as many as counted.
    pub(crate) fn zeros(count: Count) -> Self {
        Self {
            reals: vec![0.0; count.reals].into(),
            integers: vec![0; count.integers].into(),
            booleans: vec![false; count.booleans].into(),
            strings: vec![CString::default(); count.strings].into(),
        }
    }

    /// The values of a single struct.
    pub(crate) fn of<V: Variables>(value: &V) -> Self {
        let mut values = Self::zeros(V::COUNT);
        values.store(value);
        values
    }

    /// Puts a struct's values first.
    pub(crate) fn store<V: Variables>(&mut self, value: &V) {
        value.store(&mut Writer {
            reals: &mut self.reals,
            integers: &mut self.integers,
            booleans: &mut self.booleans,
            strings: &mut self.strings,
        });
    }

    /// The struct whose values come first.
    pub(crate) fn load<V: Variables>(&self) -> V {
        V::load(&mut Reader {
            reals: &self.reals,
            integers: &self.integers,
            booleans: &self.booleans,
            strings: &self.strings,
        })
    }

    /// Copies from `other` what was set explicitly there.
    pub(crate) fn overlay(&mut self, other: &Self, explicit: &Explicit) {
        fn each<T: Clone>(own: &mut [T], theirs: &[T], set: &[bool]) {
            for ((own, theirs), _) in own.iter_mut().zip(theirs).zip(set).filter(|(_, set)| **set) {
                own.clone_from(theirs);
            }
        }
        each(&mut self.reals, &other.reals, &explicit.reals);
        each(&mut self.integers, &other.integers, &explicit.integers);
        each(&mut self.booleans, &other.booleans, &explicit.booleans);
        each(&mut self.strings, &other.strings, &explicit.strings);
    }
}

/// The inputs and outputs that are not Reals: what follows the parameters in their arrays.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Discrete {
    integers: Box<[i32]>,
    booleans: Box<[bool]>,
    strings: Box<[CString]>,
}

impl Discrete {
    /// Those of an instance with so many parameters.
    pub(crate) fn of(values: &Values, parameters: Count) -> Self {
        fn rest<T: Clone>(all: &[T], first: usize) -> Box<[T]> {
            all.get(first..).unwrap_or_default().into()
        }
        Self {
            integers: rest(&values.integers, parameters.integers),
            booleans: rest(&values.booleans, parameters.booleans),
            strings: rest(&values.strings, parameters.strings),
        }
    }

    /// Takes those of the same instance again, without allocating if no text changed its length.
    pub(crate) fn copy_from(&mut self, values: &Values, parameters: Count) {
        fn each<T: Clone>(own: &mut [T], all: &[T], first: usize) {
            all.iter().skip(first).zip(own).for_each(|(value, own)| own.clone_from(value));
        }
        each(&mut self.integers, &values.integers, parameters.integers);
        each(&mut self.booleans, &values.booleans, parameters.booleans);
        each(&mut self.strings, &values.strings, parameters.strings);
    }

    /// Puts them back.
    pub(crate) fn copy_to(&self, values: &mut Values, parameters: Count) {
        fn each<T: Clone>(own: &[T], all: &mut [T], first: usize) {
            all.iter_mut().skip(first).zip(own).for_each(|(value, own)| value.clone_from(own));
        }
        each(&self.integers, &mut values.integers, parameters.integers);
        each(&self.booleans, &mut values.booleans, parameters.booleans);
        each(&self.strings, &mut values.strings, parameters.strings);
    }

    /// Whether both have the same number of each type.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.integers.len() == other.integers.len()
            && self.booleans.len() == other.booleans.len()
            && self.strings.len() == other.strings.len()
    }
}

/// Which parameters were set by the user, per type.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Explicit {
    /// Real parameters.
    pub reals: Box<[bool]>,
    /// Integer and enumeration parameters.
    pub integers: Box<[bool]>,
    /// Boolean parameters.
    pub booleans: Box<[bool]>,
    /// String parameters.
    pub strings: Box<[bool]>,
}

impl Explicit {
    /// Whether both have the same number of parameters.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.reals.len() == other.reals.len()
            && self.integers.len() == other.integers.len()
            && self.booleans.len() == other.booleans.len()
            && self.strings.len() == other.strings.len()
    }

    /// None set yet.
    pub(crate) fn none(parameters: Count) -> Self {
        let unset = |n: usize| vec![false; n].into();
        Self {
            reals: unset(parameters.reals),
            integers: unset(parameters.integers),
            booleans: unset(parameters.booleans),
            strings: unset(parameters.strings),
        }
    }
}

/// Whether all values are finite.
///
/// If one of the values is not finite, their sum is not finite either, and adding takes one
/// operation for several values. Only if the sum is not finite must each be checked, because large
/// values overflow together.
#[inline]
pub(crate) fn all_finite(values: &[f64]) -> bool {
    let (chunks, rest) = values.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for chunk in chunks {
        sums.iter_mut().zip(chunk).for_each(|(sum, value)| *sum += value);
    }
    let sum = sums.iter().chain(rest).fold(0.0, |sum, value| sum + value);
    sum.is_finite() || each_finite(values)
}

#[cold]
#[inline(never)]
fn each_finite(values: &[f64]) -> bool {
    values.iter().all(|value| value.is_finite())
}

/// Whether all values of a group are finite; see [`all_finite`].
#[inline]
pub(crate) fn is_finite<P: Ports>(ports: &P) -> bool {
    let (mut copy, mut sums, mut index) = (*ports, [0.0; 4], 0_usize);
    copy.zip_reals(ports, &mut |_, value| {
        if let Some(sum) = sums.get_mut(index % 4) {
            *sum += value;
        }
        index += 1;
    });
    sums.iter().sum::<f64>().is_finite() || first_not_finite(ports).is_none()
}

/// Index of the first value of a group that is not finite.
#[cold]
#[inline(never)]
pub(crate) fn first_not_finite<P: Ports>(ports: &P) -> Option<usize> {
    let (mut copy, mut index, mut found) = (*ports, 0, None);
    copy.zip_reals(ports, &mut |_, value| {
        if !value.is_finite() {
            found.get_or_insert(index);
        }
        index += 1;
    });
    found
}

/// Reads a group from its position among the Reals.
///
/// The comparison of lengths tells the compiler the length of the slice, which eliminates every
/// check inside `load`.
#[inline(always)]
pub(crate) fn read<P: Variables + Default>(reals: &[f64], place: &Range<usize>) -> P {
    match reals.get(place.clone()) {
        Some(slice) if slice.len() == P::COUNT.reals => {
            P::load(&mut Reader { reals: slice, ..Reader::default() })
        }
        _ => P::default(),
    }
}

/// Writes a group to its position among the Reals.
#[inline(always)]
pub(crate) fn write<P: Variables>(value: &P, reals: &mut [f64], place: &Range<usize>) {
    match reals.get_mut(place.clone()) {
        Some(slice) if slice.len() == P::COUNT.reals => {
            value.store(&mut Writer { reals: slice, ..Writer::default() });
        }
        _ => {}
    }
}

/// Reads a group of any types; `before` counts what comes before it.
#[inline(always)]
pub(crate) fn read_ports<P: Ports>(values: &Values, reals: &Range<usize>, before: Count) -> P {
    if const { P::COUNT.only_reals() } {
        return read(&values.reals, reals);
    }
    P::load(&mut Reader {
        reals: values.reals.get(before.reals..).unwrap_or_default(),
        integers: values.integers.get(before.integers..).unwrap_or_default(),
        booleans: values.booleans.get(before.booleans..).unwrap_or_default(),
        strings: values.strings.get(before.strings..).unwrap_or_default(),
    })
}

/// Writes a group of any types.
#[inline(always)]
pub(crate) fn write_ports<P: Ports>(
    ports: &P,
    values: &mut Values,
    reals: &Range<usize>,
    before: Count,
) {
    if const { P::COUNT.only_reals() } {
        return write(ports, &mut values.reals, reals);
    }
    ports.store(&mut Writer {
        reals: values.reals.get_mut(before.reals..).unwrap_or_default(),
        integers: values.integers.get_mut(before.integers..).unwrap_or_default(),
        booleans: values.booleans.get_mut(before.booleans..).unwrap_or_default(),
        strings: values.strings.get_mut(before.strings..).unwrap_or_default(),
    });
}

/// Selects the values of these references; `None` if not every one exists. Nothing is computed.
#[inline]
pub(crate) fn gather(reals: &[f64], references: &[u32], into: &mut [f64]) -> Option<()> {
    let get = |reference: &u32| reals.get(*reference as usize).copied();
    // Four at a time: otherwise half of the work would be counting.
    let (by_four, rest) = references.as_chunks::<4>();
    let (into_four, into_rest) = into.as_chunks_mut::<4>();
    for ([a, b, c, d], place) in by_four.iter().zip(into_four) {
        *place = [get(a)?, get(b)?, get(c)?, get(d)?];
    }
    for (reference, place) in rest.iter().zip(into_rest) {
        *place = get(reference)?;
    }
    Some(())
}

/// Adds a group to the values at its position among the Reals.
pub(crate) fn accumulate<P: Ports>(value: &P, reals: &mut [f64], place: &Range<usize>) {
    let mut sum: P = read(reals, place);
    sum.zip_reals(value, &mut |sum, value| *sum += value);
    write(&sum, reals, place);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finite_is_what_std_says_it_is() {
        let finite = [0.0, -0.0, f64::MAX, f64::MIN, f64::MIN_POSITIVE, 5e-324, -1.0];
        assert!(all_finite(&finite) && is_finite(&finite) && all_finite(&[]));
        assert!(all_finite(&[f64::MAX; 9]) && is_finite(&[f64::MIN; 9]));
        for bad in [f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for place in 0..finite.len() {
                let mut values = finite;
                values[place] = bad;
                assert!(!all_finite(&values) && !is_finite(&values), "{bad} at {place}");
            }
        }
    }
}
