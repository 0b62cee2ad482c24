//! The library of FMUs that `cosim proxy` writes: one for all of them.
//!
//! It holds back inputs until the step, requests the values that the importer reads together with
//! the step, and passes everything else on to the program in the FMU's resources, which talks to
//! the workers (`cosim_import::proxy`). `cosim-served` implements what every FMU of `cosim` needs around
//! that.

mod instance;
mod values;

use cosim_served::Around;
use fmu_kit::abi::{Library, Shelf};
use fmu_kit::kernel::Request;

pub use instance::Remote;

/// Marks the library for `cosim proxy`.
#[used]
static MARK: &str = cosim_import::proxy::MARK;

/// Remote instances behind the C interface.
#[doc(hidden)]
pub struct Remotes;

impl Library for Remotes {
    type Instance = Around<Remote>;
    const MEMORY: usize = 8 << 20;

    fn instantiate(request: Request<'_>) -> Result<Around<Remote>, String> {
        Around::new(request, |request, folder| {
            Remote::make(folder, request.name, request.guid, request.logging_on)
        })
    }

    #[inline]
    fn shelf() -> &'static Shelf<Around<Remote>> {
        static SHELF: Shelf<Around<Remote>> = Shelf::new();
        &SHELF
    }
}

fmu_kit::export_library!(Remotes);
