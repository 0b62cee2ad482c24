//! The library of FMUs that `cosim export` writes: one for all systems.
//!
//! What a system does is `cosim::hosted`, what any FMU of `cosim` does around it `cosim-served`.

mod instance;

use cosim_served::Around;
use fmu_kit::abi::{Library, Shelf};
use fmu_kit::kernel::Request;

pub use instance::System;

/// Tells whoever exports a system that this library serves it.
#[used]
static MARK: &str = cosim::export::MARK;

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
        cosim::fmi::forget();
    }

    #[inline]
    fn shelf() -> &'static Shelf<Around<System>> {
        static SHELF: Shelf<Around<System>> = Shelf::new();
        &SHELF
    }
}

fmu_kit::export_library!(Systems);
