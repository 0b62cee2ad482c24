//! Ctrl-C (and SIGTERM, SIGHUP): the run ends at its next output instant, and the results are
//! kept. One that does not come there, because an FMU does not come back, is ended; so it is when an
//! FMU ends the process. A second signal ends the process as usual.
#![allow(unsafe_code, reason = "system calls without a safe form")]

use std::io::Write;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::time::Duration;

use cosim::confine::{kill_descendants, reap_descendants};
use cosim::files;

use cosim::observe::{RunInfo, Stop};
use cosim::{Observer, Result, Time};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);
/// The process in which FMUs run, as long as they do.
static WATCHED: AtomicI32 = AtomicI32::new(0);
/// So long a run may take to its next output instant after a signal.
const GRACE: Duration = Duration::from_secs(5);
const LOOK: Duration = Duration::from_millis(50);

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

unsafe extern "C" {
    /// `atexit` for `quick_exit` (C11).
    fn at_quick_exit(function: extern "C" fn()) -> libc::c_int;
}

/// As long as this is there, FMUs run in this process.
pub(crate) struct Watched;

impl Drop for Watched {
    fn drop(&mut self) {
        WATCHED.store(0, Ordering::Relaxed);
        kill_descendants(std::process::id());
    }
}

/// From now on FMUs run in this process: whatever they start ends with it, and it does not end by
/// them without an error.
pub(crate) fn watch() -> Watched {
    reap_descendants();
    cosim::fmi::guard_process();
    WATCHED.store(std::process::id() as i32, Ordering::Relaxed);
    // SAFETY: the function is of this program, and calls nothing that an end of the process forbids.
    unsafe {
        libc::atexit(ended);
        at_quick_exit(ended);
    }
    std::thread::spawn(|| {
        while !interrupted() {
            std::thread::sleep(LOOK);
        }
        std::thread::sleep(GRACE);
        if is_watched() {
            let why = "an FMU did not come back after a signal";
            end(&format!("[E303] the run was interrupted\n  why:  {why}"));
        }
    });
    Watched
}

/// Not in a child that an FMU has forked.
fn is_watched() -> bool {
    WATCHED.load(Ordering::Relaxed) == std::process::id() as i32
}

/// Called when the process exits, in whatever way the C library offers: while FMUs run, only one of them can have done that.
pub(crate) extern "C" fn ended() {
    if is_watched() {
        let help = "its results until then are kept; --log-fmi-calls tells its last call";
        end(&format!("[E301] an FMU ended the process (exit)\n  help: {help}"));
    }
}

/// Ends the process, whoever computes in it.
fn end(error: &str) -> ! {
    WATCHED.store(0, Ordering::Relaxed);
    files::save_all();
    // Nobody is left to be told that stderr is closed.
    drop(writeln!(std::io::stderr(), "error: {error}"));
    kill_descendants(std::process::id());
    super::isolate::leave(1);
    // SAFETY: what is temporary is removed by the next process that unpacks something.
    unsafe { libc::_exit(1) }
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
