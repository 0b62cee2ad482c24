//! FMI 2.0 components in Rust.

#![deny(unsafe_code)]
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

// The derives name this crate from outside; inside it needs the same name.
extern crate self as fmu_kit;

pub mod abi;
mod author;
mod export;
pub mod kernel;

pub use author::*;
pub use fmu_kit_derive::{Enumeration, Variables};
