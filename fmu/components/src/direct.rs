//! Structs of the mathematics as groups of inputs and outputs, without a second struct to convert
//! to and from.
//!
//! Names, units and descriptions come from a struct of variables; the numbers go directly between
//! an instance's flat array and the arrays of the mathematics. The vehicle needs this: a
//! Runge-Kutta step converts back and forth four times, which costs as much as an evaluation.

use fmu_kit::{Declarations, Field, Reader, Variables, Writer};

/// A struct of numbers with the names of a group.
pub trait Numbers: Copy + Default + Send {
    /// Declares the numbers, in the order in which [`load`](Numbers::load) and
    /// [`zip`](Numbers::zip) visit them.
    type Names: Variables + From<Self>;

    /// Takes the numbers from the flat array.
    fn load(from: &mut Reader<'_>) -> Self;

    /// Calls `f` with each number and its counterpart in `other`.
    fn zip(&mut self, other: &Self, f: &mut impl FnMut(&mut f64, f64));
}

/// A struct of the mathematics as a group of inputs or outputs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Direct<M>(pub M);

impl<M: Numbers> Variables for Direct<M> {
    const COUNT: fmu_kit::Count = M::Names::COUNT;

    fn declare(&self, at: &Field, into: &mut Declarations) {
        M::Names::from(self.0).declare(at, into);
    }

    #[inline(always)]
    fn load(from: &mut Reader<'_>) -> Self {
        Self(M::load(from))
    }

    #[inline(always)]
    fn store(&self, into: &mut Writer<'_>) {
        let mut walked = self.0;
        walked.zip(&self.0, &mut |_, number| number.store(into));
    }

    #[inline(always)]
    fn zip_reals(&mut self, other: &Self, f: &mut impl FnMut(&mut f64, f64)) {
        self.0.zip(&other.0, f);
    }
}

/// Implements [`Numbers`] for a struct of arrays that are in the order of the names.
macro_rules! numbers {
    ($math:ty, named by $names:ty: $($array:ident),+) => {
        impl $crate::direct::Numbers for $math {
            type Names = $names;

            #[inline(always)]
            fn load(from: &mut ::fmu_kit::Reader<'_>) -> Self {
                Self { $($array: ::fmu_kit::Variables::load(from)),+ }
            }

            #[inline(always)]
            fn zip(&mut self, other: &Self, f: &mut impl FnMut(&mut f64, f64)) {
                $(::fmu_kit::Variables::zip_reals(&mut self.$array, &other.$array, f);)+
            }
        }
    };
}

pub(crate) use numbers;
