//! Ctrl-C (and SIGTERM, SIGHUP): the run ends at its next output instant, and the results are
//! kept. A second one ends the process as usual.

use std::sync::atomic::{AtomicBool, Ordering};

use cosim::observe::{RunInfo, Stop};
use cosim::{Observer, Result, Time};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Signals by which a user, a time limit or a closed terminal ends a program.
const SIGNALS: [libc::c_int; 3] = [libc::SIGINT, libc::SIGTERM, libc::SIGHUP];

/// Whether a signal has come.
pub(crate) fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

extern "C" fn on_signal(signal: libc::c_int) {
    INTERRUPTED.store(true, Ordering::Relaxed);
    // SAFETY: `signal` may be called in a handler (POSIX, async-signal-safe functions).
    unsafe { libc::signal(signal, libc::SIG_DFL) };
}

/// From now on signals are waited for. Called before anything is unpacked: what is temporary is
/// removed at the end of the process, and not by a signal.
pub(crate) fn listen() {
    let handler: extern "C" fn(libc::c_int) = on_signal;
    for signal in SIGNALS {
        // SAFETY: the handler stores an atomic and calls `signal`, nothing else.
        let before = unsafe { libc::signal(signal, handler as libc::sighandler_t) };
        if before == libc::SIG_IGN {
            // SAFETY: as it was: `nohup` wants it so.
            unsafe { libc::signal(signal, libc::SIG_IGN) };
        }
    }
}

/// An observer that ends the run after a signal.
pub(crate) struct Interrupt;

impl Interrupt {
    /// From now on signals are waited for.
    pub(crate) fn new() -> Self {
        listen();
        Self
    }
}

impl Interrupt {
    /// Whether SIGINT came.
    pub(crate) fn came(&self) -> bool {
        INTERRUPTED.load(Ordering::Relaxed)
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
