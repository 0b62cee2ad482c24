//! The library of FMUs that `rexrov.component` writes from Python classes: one for all of them.
//!
//! The class runs in a Python process beside the importer. Inputs and outputs are kept here: only a
//! step of the class, at its own rate, needs a message in each direction. `cosim-served` implements
//! what every FMU of `cosim` needs around that.

mod instance;
mod process;

use cosim_served::Around;
use fmu_kit::abi::{Library, Shelf};
use fmu_kit::kernel::Request;

pub use instance::Scripted;

/// Objects of Python classes behind the C interface.
#[doc(hidden)]
pub struct Classes;

impl Library for Classes {
    type Instance = Around<Scripted>;

    fn instantiate(request: Request<'_>) -> Result<Around<Scripted>, String> {
        Around::new(request, |request, folder| Scripted::open(folder, request.guid))
    }

    fn unload() {
        process::Process::forget_all();
    }

    #[inline]
    fn shelf() -> &'static Shelf<Around<Scripted>> {
        static SHELF: Shelf<Around<Scripted>> = Shelf::new();
        &SHELF
    }
}

fmu_kit::export_library!(Classes);
