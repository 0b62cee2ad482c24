//! Structs as groups of variables: declaring them, and moving values between the typed struct and
//! the flat arrays of an instance.
//!
//! Everything here is walked in the order of the fields, so the position in the flat array is the
//! only identity a variable needs. The functions are small and inlined: for a slice of known length
//! the compiler sees only loads and stores.

use std::array::from_fn;
use std::ffi::{CStr, CString};

use crate::{Declaration, Declarations, Field, Start};

/// How many variables of each type a struct has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// `f64`
    pub reals: usize,
    /// `i32` and enumerations
    pub integers: usize,
    /// `bool`
    pub booleans: usize,
    /// `String`
    pub strings: usize,
}

impl Count {
    /// Nothing.
    pub const NONE: Self = Self { reals: 0, integers: 0, booleans: 0, strings: 0 };

    /// Both together.
    #[must_use]
    pub const fn plus(self, other: Self) -> Self {
        Self {
            reals: self.reals + other.reals,
            integers: self.integers + other.integers,
            booleans: self.booleans + other.booleans,
            strings: self.strings + other.strings,
        }
    }

    /// `n` of these.
    #[must_use]
    pub const fn times(self, n: usize) -> Self {
        Self {
            reals: self.reals * n,
            integers: self.integers * n,
            booleans: self.booleans * n,
            strings: self.strings * n,
        }
    }

    /// Whether there are Reals only.
    #[must_use]
    pub const fn only_reals(self) -> bool {
        self.integers == 0 && self.booleans == 0 && self.strings == 0
    }
}

/// The remaining values to load, per type.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reader<'a> {
    /// Reals not yet loaded.
    pub reals: &'a [f64],
    /// Integers and enumerations not yet loaded.
    pub integers: &'a [i32],
    /// Booleans not yet loaded.
    pub booleans: &'a [bool],
    /// Strings not yet loaded.
    pub strings: &'a [CString],
}

/// The remaining places to store into, per type.
#[derive(Debug, Default)]
pub struct Writer<'a> {
    /// Reals not yet stored.
    pub reals: &'a mut [f64],
    /// Integers and enumerations not yet stored.
    pub integers: &'a mut [i32],
    /// Booleans not yet stored.
    pub booleans: &'a mut [bool],
    /// Strings not yet stored.
    pub strings: &'a mut [CString],
}

/// A group of variables; derive it.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a kind of variable",
    label = "not a variable",
    note = "variables are f64, i32, bool, String, Text<N>, an enum deriving `Enumeration`, a struct deriving \
            `Variables`, or an array [T; N] of these"
)]
pub trait Variables: Sized {
    /// How many variables there are.
    const COUNT: Count;

    /// Declares each variable, with its value as start value.
    fn declare(&self, at: &Field, into: &mut Declarations);

    /// Takes the values from flat arrays. If those end early or an enumeration has no such item,
    /// the variable gets the `Default` of its type.
    fn load(from: &mut Reader<'_>) -> Self;

    /// Puts the values into flat arrays, as far as those reach.
    fn store(&self, into: &mut Writer<'_>);

    /// Calls `f` with each Real and its counterpart in `other`; other types are left alone.
    fn zip_reals(&mut self, other: &Self, f: &mut impl FnMut(&mut f64, f64));
}

/// The next remaining element, or the default.
#[inline(always)]
fn take<'a, T>(rest: &mut &'a [T]) -> Option<&'a T> {
    let (first, tail) = rest.split_first()?;
    *rest = tail;
    Some(first)
}

/// Puts `value` into the next place, if there is one left.
#[inline(always)]
fn put<T>(rest: &mut &mut [T], value: T) {
    if let Some((first, tail)) = std::mem::take(rest).split_first_mut() {
        *first = value;
        *rest = tail;
    }
}

/// A leaf type: how it is counted, declared, loaded and stored.
macro_rules! leaf {
    ($type:ty, $kind:ident, $list:ident, $load:expr, $store:expr) => {
        impl Variables for $type {
            const COUNT: Count = Count { $list: 1, ..Count::NONE };

            fn declare(&self, at: &Field, into: &mut Declarations) {
                into.push(Declaration { field: at.clone(), start: Start::$kind(self.clone()) });
            }

            #[inline]
            fn load(from: &mut Reader<'_>) -> Self {
                take(&mut from.$list).map($load).unwrap_or_default()
            }

            #[inline]
            fn store(&self, into: &mut Writer<'_>) {
                put(&mut into.$list, $store(self));
            }

            #[inline]
            fn zip_reals(&mut self, _: &Self, _: &mut impl FnMut(&mut f64, f64)) {}
        }
    };
}

leaf!(i32, Integer, integers, |value| *value, |value: &i32| *value);
leaf!(bool, Boolean, booleans, |value| *value, |value: &bool| { *value });
leaf!(
    String,
    String,
    strings,
    |value: &CString| value.to_string_lossy().into_owned(),
    |value: &String| terminated(value)
);

/// The text up to its first NUL, as C expects it.
fn terminated(text: &str) -> CString {
    let up_to_nul = text.split('\0').next().unwrap_or_default();
    CString::new(up_to_nul).unwrap_or_else(|_| CStr::to_owned(c""))
}

impl Variables for f64 {
    const COUNT: Count = Count { reals: 1, ..Count::NONE };

    fn declare(&self, at: &Field, into: &mut Declarations) {
        into.push(Declaration { field: at.clone(), start: Start::Real(*self) });
    }

    #[inline(always)]
    fn load(from: &mut Reader<'_>) -> Self {
        take(&mut from.reals).copied().unwrap_or_default()
    }

    #[inline(always)]
    fn store(&self, into: &mut Writer<'_>) {
        put(&mut into.reals, *self);
    }

    #[inline(always)]
    fn zip_reals(&mut self, other: &Self, f: &mut impl FnMut(&mut f64, f64)) {
        f(self, *other);
    }
}

/// No variables at all.
impl Variables for () {
    const COUNT: Count = Count::NONE;

    fn declare(&self, _: &Field, _: &mut Declarations) {}

    #[inline(always)]
    fn load(_: &mut Reader<'_>) -> Self {}

    #[inline(always)]
    fn store(&self, _: &mut Writer<'_>) {}

    #[inline(always)]
    fn zip_reals(&mut self, _: &Self, _: &mut impl FnMut(&mut f64, f64)) {}
}

impl<T: Variables, const N: usize> Variables for [T; N] {
    const COUNT: Count = T::COUNT.times(N);

    fn declare(&self, at: &Field, into: &mut Declarations) {
        for (index, element) in self.iter().enumerate() {
            element.declare(&at.element(index), into);
        }
    }

    #[inline(always)]
    fn load(from: &mut Reader<'_>) -> Self {
        from_fn(|_| T::load(from))
    }

    #[inline(always)]
    fn store(&self, into: &mut Writer<'_>) {
        for element in self {
            element.store(into);
        }
    }

    #[inline(always)]
    fn zip_reals(&mut self, other: &Self, f: &mut impl FnMut(&mut f64, f64)) {
        for (own, theirs) in self.iter_mut().zip(other) {
            own.zip_reals(theirs, f);
        }
    }
}
