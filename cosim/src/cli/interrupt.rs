//! Ctrl-C (and SIGTERM, SIGHUP): the run ends at its next output instant, and the results are kept.
//! If an FMU does not return, so that the run cannot get there, the process is ended, and with it
//! what FMUs have started; likewise if an FMU ends the process, and at once after a second signal.
//! Signals that arrive together count as one: timeout(1) sends two.
//!
//! Code of a library runs whenever it likes: constructors while it is loaded, destructors while it
//! is unloaded, its threads until the process is gone. So the watch begins before the first library
//! is loaded and lasts until the end, which calls nothing of a library ([`leave`]).
#![allow(unsafe_code, reason = "system calls without a safe form")]

use std::io::Write;
use std::sync::Once;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU32, Ordering};
use std::time::{Duration, Instant};

use cosim::confine::{kill_descendants, reap_descendants};
use cosim::files;

use cosim::observe::{RunInfo, Stop};
use cosim::{Code, Error, Observer, Result, Time};
use rustix::process::{Signal, getppid, set_parent_process_death_signal};

/// The process that defers signals. A child that an FMU has forked does not.
static LISTENING: AtomicI32 = AtomicI32::new(0);
/// Signals that have arrived.
static ARRIVED: AtomicU32 = AtomicU32::new(0);
/// The process in which FMUs may run, from the first library until the end.
static WATCHED: AtomicI32 = AtomicI32::new(0);
/// The signal that arrives when the parent ends: once for each of its threads that ends before the
/// last one, so its second arrival means nothing. Zero if there is none.
static OF_PARENT: AtomicI32 = AtomicI32::new(0);
/// Whether a signal ends this process after [`GRACE`].
static HURRIED: AtomicBool = AtomicBool::new(false);
/// How long a command may take after a signal: a run to its next output instant.
const GRACE: Duration = Duration::from_secs(5);
const LOOK: Duration = Duration::from_millis(50);

/// Signals by which a user, a time limit or a closed terminal ends a program.
const SIGNALS: [libc::c_int; 3] = [libc::SIGINT, libc::SIGTERM, libc::SIGHUP];

/// Whether a signal has arrived.
pub(crate) fn interrupted() -> bool {
    ARRIVED.load(Ordering::Relaxed) > 0
}

extern "C" fn on_signal(signal: libc::c_int) {
    if LISTENING.load(Ordering::Relaxed) != std::process::id() as i32 {
        // SAFETY: both may be called in a handler (POSIX, async-signal-safe functions).
        unsafe {
            libc::signal(signal, libc::SIG_DFL);
            libc::raise(signal);
        }
    } else if signal != OF_PARENT.load(Ordering::Relaxed) || !interrupted() {
        ARRIVED.fetch_add(1, Ordering::Relaxed);
    }
}

/// From now on, signals are deferred. Called before anything is unpacked: temporary files are
/// removed at the end of the process, not by a signal.
pub(crate) fn listen() {
    // An isolated process is ended by another one; it is confined without other threads.
    if !super::isolate::is_inside() {
        look();
    }
    LISTENING.store(std::process::id() as i32, Ordering::Relaxed);
    let handler: extern "C" fn(libc::c_int) = on_signal;
    for signal in SIGNALS {
        // SAFETY: the handler does only what POSIX allows in one.
        let before = unsafe { libc::signal(signal, handler as libc::sighandler_t) };
        if before == libc::SIG_IGN {
            // SAFETY: restores the previous action, as `nohup` requires.
            unsafe { libc::signal(signal, libc::SIG_IGN) };
        }
    }
}

/// From now on, a thread ends this process when it must not wait any longer after a signal.
fn look() {
    static WATCH: Once = Once::new();
    WATCH.call_once(|| {
        std::thread::spawn(|| {
            while !interrupted() {
                std::thread::sleep(LOOK);
            }
            let since = Instant::now();
            std::thread::sleep(LOOK);
            let first = ARRIVED.load(Ordering::Relaxed);
            let why = loop {
                if ARRIVED.load(Ordering::Relaxed) > first {
                    break "a second signal has arrived";
                }
                if HURRIED.load(Ordering::Relaxed) && since.elapsed() >= GRACE {
                    break "an FMU or a file took too long after a signal";
                }
                std::thread::sleep(LOOK);
            };
            end(Code::Interrupted, &format!("the command was interrupted\n  why:  {why}"));
        });
    });
}

/// From now on, a signal ends this process after some seconds, even if an FMU or a file keeps it
/// busy.
pub(crate) fn hurry() {
    HURRIED.store(true, Ordering::Relaxed);
    look();
}

/// From now on, only what other processes do can take long after a signal, and those are ended.
pub(crate) fn be_patient() {
    HURRIED.store(false, Ordering::Relaxed);
}

/// From now on, this process gets a signal when the one that started it ends, however it ends.
pub(crate) fn end_with_parent(signal: Signal) -> Result<()> {
    let before = getppid();
    OF_PARENT.store(signal.as_raw(), Ordering::Relaxed);
    set_parent_process_death_signal(Some(signal)).map_err(|why| {
        Error::new(Code::Session, "the process cannot be tied to its parent").why(why)
    })?;
    if getppid() != before || before.is_none() {
        return Err(Error::new(Code::Session, "the process that started this one is gone"));
    }
    Ok(())
}

unsafe extern "C" {
    /// `atexit` for `quick_exit` (C11).
    fn at_quick_exit(function: extern "C" fn()) -> libc::c_int;
}

/// At the beginning of a command that reads files, and then runs FMUs.
pub(crate) fn begin() {
    listen();
    // An isolated process is ended by another one; it is confined without other threads.
    if !super::isolate::is_inside() {
        hurry();
    }
}

/// From now on, FMUs run in this process: processes that they start end with it, they cannot end it
/// without an error message, and a signal ends them.
pub(crate) fn watch() {
    begin();
    reap_descendants();
    cosim::fmi::guard_process();
    WATCHED.store(std::process::id() as i32, Ordering::Relaxed);
    // SAFETY: the function belongs to this program, and calls nothing that is forbidden while a
    // process exits.
    unsafe {
        libc::atexit(ended);
        at_quick_exit(ended);
    }
}

/// The end of the process, without what FMUs have registered for it: their functions could change
/// the exit code, never return, or use memory that has been freed (PythonFMU 0.7).
pub(crate) fn leave(code: u8) -> ! {
    be_patient();
    super::isolate::leave(code);
    // If a stream is closed, there is no channel left to report it.
    drop(super::standard::out().flush());
    drop(std::io::stdout().flush());
    if WATCHED.swap(0, Ordering::Relaxed) != 0 {
        kill_descendants(std::process::id());
    }
    exit(code.into())
}

/// Ends the process without calling anything else.
pub(crate) fn exit(code: libc::c_int) -> ! {
    loop {
        // SAFETY: ends the process.
        unsafe { libc::syscall(libc::SYS_exit_group, code) };
    }
}

/// Not in a child that an FMU has forked.
fn is_watched() -> bool {
    WATCHED.load(Ordering::Relaxed) == std::process::id() as i32
}

/// Called when the process exits by any function of the C library: while FMUs run, only an FMU can
/// have caused that.
pub(crate) extern "C" fn ended() {
    if is_watched() {
        let help = "the results until then are kept; --log-fmi-calls shows its last call";
        end(Code::Fmu, &format!("an FMU ended the process (exit)\n  help: {help}"));
    }
}

/// Ends the process, whichever thread is computing. Temporary files are removed by the next process
/// that unpacks something.
fn end(code: Code, error: &str) -> ! {
    WATCHED.store(0, Ordering::Relaxed);
    files::save_all();
    kill_descendants(std::process::id());
    // If stderr is closed, there is no channel left to report it.
    drop(writeln!(std::io::stderr(), "error: [{}] {error}", code.as_str()));
    super::isolate::leave(code.exit_code());
    exit(code.exit_code().into())
}

/// An observer that ends the run after a signal.
pub(crate) struct Interrupt;

impl Interrupt {
    /// From now on, signals are deferred.
    pub(crate) fn new() -> Self {
        listen();
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
