//! The library of FMUs that `cosim export` writes: one for all systems.
//!
//! The C interface, the rules what is legal when, and the log are those of `fmu-kit`; what a system
//! does is `cosim::hosted`. Between them stands [`System`], one instance.

mod instance;

use fmu_kit::abi::{Library, Shelf};
use fmu_kit::kernel::Request;

pub use instance::{State, System};

/// Tells whoever exports a system that this library serves it.
#[used]
static MARK: &str = cosim::export::MARK;

/// Systems behind the C interface.
#[doc(hidden)]
pub struct Systems;

impl Library for Systems {
    type Instance = System;

    fn instantiate(request: Request<'_>) -> Result<System, String> {
        System::new(request)
    }

    #[inline]
    fn shelf() -> &'static Shelf<System> {
        static SHELF: Shelf<System> = Shelf::new();
        &SHELF
    }
}

fmu_kit::export_library!(Systems);
