//! Ctrl-C: the run ends at its next output instant, and the results are kept. A second one ends
//! the process as usual.

use std::sync::atomic::{AtomicBool, Ordering};

use cosim::observe::{RunInfo, Stop};
use cosim::{Observer, Result, Time};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Whether SIGINT has come.
pub(crate) fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

extern "C" fn on_signal(_: libc::c_int) {
    INTERRUPTED.store(true, Ordering::Relaxed);
    // SAFETY: `signal` may be called in a handler (POSIX, async-signal-safe functions).
    unsafe { libc::signal(libc::SIGINT, libc::SIG_DFL) };
}

/// An observer that ends the run after SIGINT.
pub(crate) struct Interrupt;

impl Interrupt {
    /// From now on SIGINT is waited for.
    pub(crate) fn new() -> Self {
        let handler: extern "C" fn(libc::c_int) = on_signal;
        // SAFETY: the handler stores an atomic and calls `signal`, nothing else.
        unsafe { libc::signal(libc::SIGINT, handler as libc::sighandler_t) };
        Self
    }
}

impl Observer for Interrupt {
    fn start(&mut self, _: &RunInfo<'_>) -> Result<()> {
        Ok(())
    }

    fn sample(&mut self, _: Time, _: &[f64]) -> Result<()> {
        Ok(())
    }

    fn finish(&mut self) -> Result<()> {
        Ok(())
    }

    fn stop(&self) -> Option<Stop> {
        interrupted().then_some(Stop::Interrupted)
    }
}
