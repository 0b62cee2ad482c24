//! The library of FMUs that `cosim export` writes: one for all systems.
//!
//! `cosim_core::hosted` implements the system, `cosim-served` what every FMU of `cosim` needs around it.

mod instance;

use cosim_served::Around;
use fmu_kit::abi::{Library, Shelf};
use fmu_kit::kernel::Request;

pub use instance::System;

/// Marks the library for `cosim export`.
#[used]
static MARK: &str = cosim_core::hosted::MARK;

/// Systems behind the C interface.
#[doc(hidden)]
pub struct Systems;

impl Library for Systems {
    type Instance = Around<System>;
    const MEMORY: usize = 32 << 20;

    fn instantiate(request: Request<'_>) -> Result<Around<System>, String> {
        Around::new(request, |request, folder| System::open(folder, request.logging_on))
    }

    fn unload() {
        cosim_import::forget();
    }

    #[inline]
    fn shelf() -> &'static Shelf<Around<System>> {
        static SHELF: Shelf<Around<System>> = Shelf::new();
        &SHELF
    }
}

fmu_kit::export_library!(Systems);
