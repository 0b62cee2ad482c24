//! Resource limits of FMUs (`setrlimit`).
#![allow(unsafe_code, reason = "system calls without a safe form")]

use std::io;

/// Maximum size of a file in bytes: enough for results of days, but an FMU that writes forever
/// ends.
const FILE: u64 = 16 << 30;
const OPEN_FILES: u64 = 1024;
/// Maximum number of processes and threads, where they are counted separately from others of the
/// user.
const THREADS: u64 = 1024;

/// For this process and those that it starts, permanently. Memory: as much as the machine has.
pub(super) fn set(counted_apart: bool) -> io::Result<()> {
    let mut limits = vec![
        (libc::RLIMIT_CORE, 0),
        (libc::RLIMIT_FSIZE, FILE),
        (libc::RLIMIT_NOFILE, OPEN_FILES),
        (libc::RLIMIT_AS, memory()),
        (libc::RLIMIT_MEMLOCK, 0),
        (libc::RLIMIT_RTPRIO, 0),
    ];
    if counted_apart {
        limits.push((libc::RLIMIT_NPROC, THREADS));
    }
    for (what, limit) in limits {
        let mut now = libc::rlimit { rlim_cur: 0, rlim_max: 0 };
        // SAFETY: both calls are given a structure that lives until they return.
        unsafe {
            if libc::getrlimit(what, &mut now) != 0 {
                return Err(io::Error::last_os_error());
            }
            let limit = limit.min(now.rlim_max);
            let wanted = libc::rlimit { rlim_cur: limit, rlim_max: limit };
            if libc::setrlimit(what, &wanted) != 0 {
                return Err(io::Error::last_os_error());
            }
        }
    }
    Ok(())
}

fn memory() -> u64 {
    // SAFETY: asks for numbers.
    let (pages, size) =
        unsafe { (libc::sysconf(libc::_SC_PHYS_PAGES), libc::sysconf(libc::_SC_PAGESIZE)) };
    let bytes = u64::try_from(pages).unwrap_or(0) * u64::try_from(size).unwrap_or(0);
    // A machine that does not report it is assumed to have enough.
    if bytes == 0 { libc::RLIM_INFINITY } else { bytes.max(1 << 30) }
}
