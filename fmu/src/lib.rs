//! FMI 2.0 components in Rust: declare the variables as struct fields, implement one trait,
//! export.
//!
//! ```
//! use fmu_kit::{Component, Fault, Info, ParameterError, Resources, Time, Variables};
//!
//! #[derive(Clone, Debug, Variables)]
//! struct Parameters {
//!     /// Time constant of the filter
//!     #[var(unit = "s", min = 1e-6)]
//!     time_constant: f64,
//! }
//!
//! impl Default for Parameters {
//!     fn default() -> Self {
//!         Self { time_constant: 0.5 }
//!     }
//! }
//!
//! #[derive(Clone, Copy, Debug, Default, Variables)]
//! struct Signal {
//!     /// Signal to be filtered
//!     u: f64,
//! }
//!
//! #[derive(Clone, Copy, Debug, Default, Variables)]
//! struct Filtered {
//!     /// Filtered signal
//!     y: f64,
//! }
//!
//! #[derive(Clone, Copy, Debug, Default, Variables)]
//! struct States {
//!     /// State of the filter
//!     x: f64,
//! }
//!
//! struct LowPass(Parameters);
//!
//! impl Component for LowPass {
//!     const INFO: Info = Info::new("LowPass", "First-order low-pass filter");
//!     type Parameters = Parameters;
//!     type Inputs = Signal;
//!     type Outputs = Filtered;
//!     type States = States;
//!     type Memory = ();
//!
//!     fn new(p: &Parameters, _: &Resources) -> Result<Self, ParameterError> {
//!         Ok(Self(p.clone()))
//!     }
//!     fn initial(&self, _: Time, signal: &Signal) -> Result<(States, ()), Fault> {
//!         Ok((States { x: signal.u }, ()))
//!     }
//!     fn derivatives(&self, _: f64, _: &(), s: &States, signal: &Signal) -> States {
//!         States { x: (signal.u - s.x) / self.0.time_constant }
//!     }
//!     fn outputs(&self, _: f64, _: &(), s: &States, _: &Signal) -> Filtered {
//!         Filtered { y: s.x }
//!     }
//! }
//!
//! fmu_kit::export!(LowPass);
//! # fn main() {
//! #     assert!(REGISTRY.named("LowPass").unwrap().describe().unwrap().contains("der(x)"));
//! # }
//! ```
//!
//! In a `cdylib` this is a complete library for an FMU, for co-simulation and model exchange;
//! `REGISTRY` provides the text of its modelDescription.xml ([`kernel::Entry::describe`]), and with
//! the feature `package` a one-line `main` (`fmu_kit::package::main(&REGISTRY)`) writes the FMU.
//! The page "Write your own component" of this project's documents explains all of it. The name of
//! a variable, its unit, bounds, description and start value are declared once, at its field.
//!
//! | part | purpose | knows |
//! |---|---|---|
//! | the items of this page | the interface for authors | nothing of FMI's C or XML |
//! | [`kernel`] | variables, state machine, stepper, description | nothing of C |
//! | [`abi`] | the 44 C functions | nothing of components |
//!
//! A component with continuous states gets the parameters `integrator.method`, `integrator.step`
//! and `integrator.tolerance` from the kernel. Where its equations change their form (a stop, a
//! limit) it names [`Component::INDICATORS`] and handles [`Component::state_event`]; if these are
//! only kinks that depend on the inputs, [`Component::KINKS_OF_INPUTS`] says so and there is
//! nothing to handle. With a [`Component::tangent`] it provides directional and output derivatives,
//! with [`Component::initial_tangent`] those with respect to parameters.
//!
//! A component that works only at its sample instants implements [`Sample`] instead, and
//! [`Sampled`] makes it a component. A component that combines both keeps a [`Sampler`] in its
//! `Memory` and handles its instants in [`Component::event`]. For tests, instances can be driven
//! without C, through [`kernel::Entry::instantiate`].

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

// The derives refer to this crate by its name from outside; inside it needs the same name.
extern crate self as fmu_kit;

pub mod abi;
mod author;
mod export;
pub mod kernel;
#[cfg(feature = "package")]
pub mod package;

pub use author::*;
pub use fmu_kit_derive::{Enumeration, Variables};

/// The code of the README, for the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
