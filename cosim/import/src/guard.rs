//! What an FMU must leave unchanged: the floating-point environment of its thread, the signal mask
//! and handlers, locale, working directory, umask, and where the standard streams go.
//!
//! All of that belongs to the process, so an FMU that changes it affects the other FMUs, and a
//! system computes different results in one process than in two. The floating-point environment is
//! compared after every call, because the next FMU would compute with it; after direct steps by
//! [`Steady`]. The rest costs system calls; it is compared after each call that creates,
//! initializes or ends an instance, after the first steps, and then occasionally
//! (`cosim_core::master`). Changes are undone, and the messages of the instance report what was
//! changed and by which function.

use std::ffi::{CStr, CString};
use std::mem::MaybeUninit;
use std::os::fd::{AsRawFd, FromRawFd, OwnedFd, RawFd};
use std::os::unix::ffi::OsStringExt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use super::log::Log;
use super::status;

/// Rounding mode, flushing of subnormals to zero, and enabled traps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Float {
    /// MXCSR without its flags; on AArch64 FPCR.
    control: u64,
    /// The x87 control word.
    x87: u16,
}

/// MXCSR flags: exceptions that have occurred.
#[cfg(target_arch = "x86_64")]
const FLAGS: u32 = 0x3f;

impl Float {
    /// The environment of the calling thread.
    #[cfg(target_arch = "x86_64")]
    #[must_use]
    #[inline(always)]
    pub fn now() -> Self {
        let (mut control, mut x87) = (0_u32, 0_u16);
        // SAFETY: both instructions store to the location they are given.
        unsafe {
            std::arch::asm!(
                "stmxcsr [{}]", "fnstcw [{}]", in(reg) &mut control, in(reg) &mut x87,
                options(nostack, preserves_flags)
            );
        }
        Self { control: u64::from(control & !FLAGS), x87 }
    }

    #[cfg(target_arch = "x86_64")]
    #[cold]
    fn set(self) {
        let (control, x87) = (self.control as u32, self.x87);
        // SAFETY: the values were read from the same registers; cleared flags have no effect.
        unsafe {
            std::arch::asm!(
                "fnclex", "ldmxcsr [{}]", "fldcw [{}]", in(reg) &control, in(reg) &x87,
                options(nostack, readonly)
            );
        }
    }

    /// The environment of the calling thread.
    #[cfg(target_arch = "aarch64")]
    #[must_use]
    #[inline(always)]
    pub fn now() -> Self {
        let control: u64;
        // SAFETY: reads a register.
        unsafe { std::arch::asm!("mrs {}, fpcr", out(reg) control, options(nomem, nostack)) };
        Self { control, x87: 0 }
    }

    #[cfg(target_arch = "aarch64")]
    #[cold]
    fn set(self) {
        // SAFETY: the value was read from the same register.
        unsafe { std::arch::asm!("msr fpcr, {}", in(reg) self.control, options(nostack)) };
    }

    /// Unknown on this machine.
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    #[must_use]
    #[inline(always)]
    pub fn now() -> Self {
        Self { control: 0, x87: 0 }
    }

    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    fn set(self) {}

    /// The x87 control word, which is read without waiting.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn x87() -> u16 {
        let mut x87 = 0_u16;
        // SAFETY: the instruction stores to the location it is given.
        unsafe {
            std::arch::asm!(
                "fnstcw [{}]", in(reg) &mut x87, options(nostack, preserves_flags)
            );
        }
        x87
    }

    /// Undoes what a call of `function` changed, and reports it.
    #[inline(always)]
    pub(super) fn check(self, log: &Log, function: &'static str) {
        if Self::now() != self {
            self.changed(log, function);
        }
    }

    #[cold]
    #[inline(never)]
    pub(super) fn changed(self, log: &Log, function: &str) {
        self.set();
        report(log, Kind::Float, function);
    }
}

/// The floating-point environment before direct steps, and a comparison with it that costs almost
/// nothing.
///
/// To read MXCSR, a processor waits for all operations before it, which can take half the time of a
/// small FMU's step. It does not wait for sums whose bits depend on MXCSR. These do not depend on
/// which exceptions trap: that changes no results, and is compared with the rest of the process.
pub struct Steady {
    before: Float,
    #[cfg(target_arch = "x86_64")]
    sums: std::arch::x86_64::__m128i,
}

#[cfg(target_arch = "x86_64")]
impl Steady {
    /// The environment of the calling thread.
    pub fn now() -> Self {
        Self { before: Float::now(), sums: sums() }
    }

    /// Whether the calling thread now rounds differently, flushes subnormals differently, or has
    /// another x87 control word. That is compared first: `feenableexcept` changes it too, and then
    /// the sums, which are inexact, would trap.
    #[inline(always)]
    pub fn is_changed(&self) -> bool {
        use std::arch::x86_64::{_mm_cmpeq_epi32, _mm_movemask_epi8};
        // SAFETY: every x86-64 processor has SSE2.
        let equal = || unsafe { _mm_movemask_epi8(_mm_cmpeq_epi32(sums(), self.sums)) == 0xffff };
        Float::x87() != self.before.x87 || !equal()
    }
}

/// Four sums: only to nearest are both of the first two rounded away from zero; the third is
/// subnormal, and so is an operand of the fourth.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn sums() -> std::arch::x86_64::__m128i {
    use std::arch::x86_64::{_mm_castps_si128, _mm_set_ps};
    const PART: f32 = 0.75 * f32::EPSILON;
    const TINY: f32 = f32::MIN_POSITIVE;
    // SAFETY: every x86-64 processor has SSE2; the instruction adds registers. The compiler would
    // assume the default environment.
    unsafe {
        let mut sums = _mm_set_ps(1.0, -1.0, TINY, f32::from_bits(1));
        std::arch::asm!(
            "addps {}, {}", inout(xmm_reg) sums,
            in(xmm_reg) _mm_set_ps(PART, -PART, -1.5 * TINY, 0.0),
            options(nomem, nostack, preserves_flags)
        );
        _mm_castps_si128(sums)
    }
}

#[cfg(not(target_arch = "x86_64"))]
impl Steady {
    /// The environment of the calling thread.
    pub(crate) fn now() -> Self {
        Self { before: Float::now() }
    }

    /// Whether it has changed.
    #[inline(always)]
    pub(crate) fn is_changed(&self) -> bool {
        Float::now() != self.before
    }
}

impl Steady {
    /// The environment to set back.
    pub fn before(&self) -> Float {
        self.before
    }
}

/// What can be changed; the bits record what has been reported for an instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Float,
    Mask,
    Handlers,
    Faults,
    Locale,
    Folder,
    Umask,
    Streams,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Float => "the floating-point environment (rounding, subnormals or traps)",
            Self::Mask => "the signal mask",
            Self::Handlers => "a signal's handler",
            Self::Faults => "the handler of a fault",
            Self::Locale => "the locale",
            Self::Folder => "the working directory",
            Self::Umask => "the umask",
            Self::Streams => "where a standard stream goes",
        }
    }

    /// Whether it is undone. Runtimes inside FMUs (Java, Go) depend on their handlers for faults.
    fn is_set_back(self) -> bool {
        self != Self::Faults
    }
}

fn report(log: &Log, kind: Kind, function: &str) {
    if log.is_new(kind as u32) {
        let name = kind.name();
        let end = if kind.is_set_back() { "; it was set back" } else { "" };
        let text = format!("{function} changed {name} of the whole process{end}");
        log.message(status::WARNING, "cosim", &text);
    }
}

/// Signals whose handlers are compared: the standard ones that can have one.
const SIGNALS: std::ops::Range<usize> = 1..32;
/// Signals for faults; runtimes inside FMUs handle them, and must be able to continue to.
const FAULTS: [libc::c_int; 5] =
    [libc::SIGSEGV, libc::SIGBUS, libc::SIGFPE, libc::SIGILL, libc::SIGTRAP];

/// The state of the process and of the calling thread.
struct Process {
    float: Float,
    mask: libc::sigset_t,
    handlers: [libc::sigaction; 32],
    locale: CString,
    thread_locale: libc::locale_t,
    folder: Option<(u64, u64)>,
    path: Option<CString>,
    umask: libc::mode_t,
    streams: [Option<(u64, u64)>; 3],
}

// SAFETY: the handle of a locale is compared and set by the thread that has it.
unsafe impl Send for Process {}

/// The state before any FMU was loaded.
static BEFORE: Mutex<Option<Before>> = Mutex::new(None);
/// Whether we own the process.
static OWN: AtomicBool = AtomicBool::new(false);

/// From now on, FMUs must leave the process unchanged, not only the floating-point environment of
/// their threads. For programs that do not change it themselves while systems run: in other
/// programs the cause of a change cannot be determined.
pub fn guard_process() {
    OWN.store(true, Ordering::Relaxed);
}

/// Records the current state, before FMUs are created.
pub fn begin() {
    if OWN.load(Ordering::Relaxed) {
        *BEFORE.lock().unwrap_or_else(PoisonError::into_inner) = Some(Before::now());
    }
}

/// Undoes changes, and reports that `function` made them.
#[cold]
#[inline(never)]
pub(super) fn check(log: &Log, function: &str) {
    if !OWN.load(Ordering::Relaxed) {
        return;
    }
    let before = BEFORE.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(before) = &*before {
        before.compare(log, function);
    }
}

/// For library code that runs while the library is loaded: its changes are reported by the
/// instances that are created from it.
pub(super) fn around<T>(function: &str, call: impl FnOnce() -> T) -> (T, Vec<String>) {
    let (log, before) = (Log::default(), Before::now());
    let result = call();
    before.compare(&log, function);
    (result, log.take())
}

/// The state to which changes are set back.
struct Before {
    process: Process,
    /// Duplicates of the standard streams.
    streams: [Option<OwnedFd>; 3],
}

/// Duplicates of streams have at least this number: out of the way of programs that count.
const DUPLICATES: RawFd = 64;

impl Before {
    fn now() -> Self {
        let streams = [0, 1, 2].map(|stream| {
            // SAFETY: the new descriptor has no other owner.
            unsafe {
                let made = libc::fcntl(stream, libc::F_DUPFD_CLOEXEC, DUPLICATES);
                (made >= 0).then(|| OwnedFd::from_raw_fd(made))
            }
        });
        Self { process: Process::now(), streams }
    }
}

impl Process {
    fn now() -> Self {
        let mut handlers = [const { MaybeUninit::<libc::sigaction>::zeroed() }; 32];
        // SAFETY: each call writes to the structure that it is given, or only reads; the structures
        // are plain data, for which all zeros are valid.
        unsafe {
            let mut mask = MaybeUninit::<libc::sigset_t>::zeroed();
            libc::pthread_sigmask(libc::SIG_BLOCK, std::ptr::null(), mask.as_mut_ptr());
            for signal in SIGNALS {
                let handler = handlers[signal].as_mut_ptr();
                libc::sigaction(signal as libc::c_int, std::ptr::null(), handler);
            }
            let umask = libc::umask(0o077);
            libc::umask(umask);
            let name = libc::setlocale(libc::LC_ALL, std::ptr::null());
            let locale = if name.is_null() { c"C" } else { CStr::from_ptr(name) };
            Self {
                float: Float::now(),
                mask: mask.assume_init(),
                handlers: handlers.map(|handler| handler.assume_init()),
                locale: locale.to_owned(),
                thread_locale: libc::uselocale(std::ptr::null_mut()),
                folder: identity(|status| libc::stat(c".".as_ptr(), status)),
                path: std::env::current_dir()
                    .ok()
                    .and_then(|folder| CString::new(folder.into_os_string().into_vec()).ok()),
                umask,
                streams: [0, 1, 2].map(|file| identity(|status| libc::fstat(file, status))),
            }
        }
    }
}

impl Before {
    fn compare(&self, log: &Log, function: &str) {
        let (before, now) = (&self.process, Process::now());
        if now.float != before.float {
            before.float.changed(log, function);
        }
        // SAFETY: the values were read by the same functions in this process; the locale of a
        // thread is set by the calling thread itself.
        unsafe {
            if (1..65)
                .any(|s| libc::sigismember(&before.mask, s) != libc::sigismember(&now.mask, s))
            {
                libc::pthread_sigmask(libc::SIG_SETMASK, &before.mask, std::ptr::null_mut());
                report(log, Kind::Mask, function);
            }
            for signal in SIGNALS {
                let (old, new) = (&before.handlers[signal], &now.handlers[signal]);
                // After a signal from the user, our own handler sets the default action.
                let signal = signal as libc::c_int;
                if !same(old, new) && new.sa_sigaction != libc::SIG_DFL {
                    if FAULTS.contains(&signal) {
                        report(log, Kind::Faults, function);
                    } else {
                        libc::sigaction(signal, old, std::ptr::null_mut());
                        report(log, Kind::Handlers, function);
                    }
                }
            }
            if now.locale != before.locale {
                libc::setlocale(libc::LC_ALL, before.locale.as_ptr());
                report(log, Kind::Locale, function);
            }
            if now.thread_locale != before.thread_locale {
                libc::uselocale(before.thread_locale);
                report(log, Kind::Locale, function);
            }
            if now.folder != before.folder {
                if let Some(path) = &before.path {
                    libc::chdir(path.as_ptr());
                }
                report(log, Kind::Folder, function);
            }
            if now.umask != before.umask {
                libc::umask(before.umask);
                report(log, Kind::Umask, function);
            }
        }
        for (stream, duplicate) in (0..).zip(&self.streams) {
            if now.streams[stream as usize] != before.streams[stream as usize] {
                if let Some(duplicate) = duplicate {
                    // SAFETY: the stream becomes again what it was.
                    unsafe { libc::dup2(duplicate.as_raw_fd(), stream) };
                }
                report(log, Kind::Streams, function);
            }
        }
    }
}

fn same(a: &libc::sigaction, b: &libc::sigaction) -> bool {
    a.sa_sigaction == b.sa_sigaction && a.sa_flags == b.sa_flags
}

/// Device and number of a file.
fn identity(stat: impl FnOnce(*mut libc::stat) -> libc::c_int) -> Option<(u64, u64)> {
    let mut status = MaybeUninit::<libc::stat>::zeroed();
    let done = stat(status.as_mut_ptr());
    // SAFETY: the structure is plain data, for which all zeros are a value.
    let status = unsafe { status.assume_init() };
    (done == 0).then_some((status.st_dev, status.st_ino))
}
