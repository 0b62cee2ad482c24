//! Quantities declared once: the fields of a struct have a name, a documentation, a unit, bounds
//! and a start value, and move between the struct and flat arrays.
//!
//! A struct of numbers derives [`Variables`]. What the derive writes is a walk over the fields in
//! their order: [`Variables::declare`] collects a [`Declaration`] of each leaf,
//! [`Variables::load`] and [`Variables::store`] copy the values. Nothing here knows FMI: `fmu-kit`
//! makes variables of an FMU from the declarations, and mathematics that depends on this crate
//! alone declares its parameters beside its equations.
//!
//! | item | purpose |
//! |---|---|
//! | [`Variables`], its derive | a struct as a group of quantities |
//! | [`Enumeration`], its derive | a fieldless enum as one quantity |
//! | [`Field`], [`Member`], [`Declaration`] | names, descriptions, units, bounds and start values |
//! | [`Reader`], [`Writer`], [`Count`] | the flat arrays |
//! | [`Text`] | a short text without a heap |

#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing,
        clippy::todo,
        clippy::unimplemented,
        clippy::unreachable
    )
)]

mod enumeration;
mod field;
mod text;
mod variables;

pub use enumeration::Enumeration;
pub use field::{Declaration, Declarations, Field, Member, Start};
pub use fmu_kit_derive::{QuantityEnumeration as Enumeration, QuantityVariables as Variables};
pub use text::Text;
pub use variables::{Count, Reader, Variables, Writer};

/// The code of the README, for the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
