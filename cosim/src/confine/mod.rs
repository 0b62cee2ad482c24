//! What processes with FMUs may do: compute. An FMU is third-party native code.
//!
//! Four layers, which need no privileges and are permanent:
//!
//! * Landlock for the whole process, before it does anything else: nothing outside its temporary
//!   folder is written, TCP connects only to the port of the coordinator, and signals reach no
//!   outside process;
//! * limits of memory, files and their sizes (`limits`);
//! * for the thread that computes, and for those that FMUs start: no TCP at all, and only programs,
//!   libraries and explicitly readable files are read;
//! * a system call filter for all threads (`calls`): no permissions, owners or times of files are
//!   changed, no sockets opened, no programs started, no processes stopped.
//!
//! `apart` additionally puts a process into its own namespaces.

mod apart;
mod calls;
mod limits;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use landlock::{
    ABI, Access, AccessFs, AccessNet, CompatLevel, Compatible, NetPort, PathBeneath, PathFd,
    Ruleset, RulesetAttr, RulesetCreatedAttr, Scope,
};

use crate::error::{Code, Error, Result};
pub(crate) use apart::kill_orphans;
pub use apart::{Apart, Supervised, close_inherited, kill_descendants, reap_descendants};
use calls::Programs;

/// The first version of Landlock that supports networks.
const NEEDED: ABI = ABI::V4;
/// Features of later versions are used where available.
const WANTED: ABI = ABI::V6;
/// Devices that programs write to.
const SINKS: [&str; 3] = ["/dev/null", "/dev/zero", "/dev/full"];
/// Environment variables that processes with FMUs keep: no secrets.
const KEPT: [&str; 15] = [
    "PATH",
    "HOME",
    "LANG",
    "LC_ALL",
    "LC_NUMERIC",
    "TZ",
    "LD_LIBRARY_PATH",
    "PYTHONHOME",
    "PYTHONPATH",
    "COSIM_LIBPYTHON",
    "COSIM_PYTHON",
    "NO_COLOR",
    "OMP_NUM_THREADS",
    "RUST_LOG",
    "ZENOH_RUNTIME",
];

/// The environment of a process with FMUs that are not trusted.
pub fn environment() -> impl Iterator<Item = (&'static str, std::ffi::OsString)> {
    KEPT.iter().filter_map(|name| Some((*name, std::env::var_os(name)?)))
}

/// What every program reads: itself, libraries and information about the machine.
const READABLE: [&str; 22] = [
    "/usr",
    "/lib",
    "/lib64",
    "/bin",
    "/opt",
    "/nix/store",
    "/etc/ld.so.cache",
    "/etc/ld.so.conf",
    "/etc/ld.so.conf.d",
    "/etc/ld.so.preload",
    "/etc/localtime",
    "/etc/locale.alias",
    "/etc/nsswitch.conf",
    "/etc/alternatives",
    "/etc/python3",
    "/etc/os-release",
    "/dev/null",
    "/dev/zero",
    "/dev/random",
    "/dev/urandom",
    "/sys/devices/system/cpu",
    "/proc/self",
];
/// Information about the machine, without names of users.
const READABLE_OF_PROC: [&str; 4] =
    ["/proc/cpuinfo", "/proc/meminfo", "/proc/stat", "/proc/sys/vm/overcommit_memory"];

type Attempt<T> = Result<T, Box<dyn std::error::Error>>;

/// For the whole process, which writes only below `folder`, and connects only to these ports.
pub(crate) fn process(ports: &[u16], folder: &Path, counted_apart: bool) -> Result<()> {
    let confine = || -> Attempt<()> {
        limits::set(counted_apart)?;
        let mut rules = Ruleset::default()
            .set_compatibility(CompatLevel::BestEffort)
            .handle_access(AccessFs::from_write(WANTED))?
            .handle_access(AccessNet::from_all(WANTED))?
            .scope(Scope::Signal)?
            .scope(Scope::AbstractUnixSocket)?
            .create()?
            .add_rule(PathBeneath::new(PathFd::new(folder)?, AccessFs::from_write(WANTED)))?;
        for sink in SINKS {
            // A machine without such a file has no process that writes to it.
            if let Ok(sink) = PathFd::new(sink) {
                let write = AccessFs::WriteFile | AccessFs::Truncate;
                rules = rules.add_rule(PathBeneath::new(sink, write))?;
            }
        }
        for &port in ports {
            rules = rules.add_rule(NetPort::new(port, AccessNet::ConnectTcp))?;
        }
        rules.restrict_self()?;
        Ok(())
    };
    confine().map_err(unconfined_by)
}

/// For the calling thread and those that it will start: no TCP, and only libraries, files below
/// `folder` and `readable` are read. For all threads, the system call filter. A process may start
/// programs only if all of them end with it. `strict`: a kernel without filters is an error.
pub(crate) fn this_thread(
    folder: &Path,
    readable: &[PathBuf],
    programs: bool,
    strict: bool,
) -> Result<()> {
    let confine = || -> Attempt<()> {
        let read = AccessFs::from_read(WANTED);
        let mut rules = Ruleset::default()
            .set_compatibility(CompatLevel::BestEffort)
            .handle_access(read)?
            .handle_access(AccessNet::from_all(WANTED))?
            .create()?;
        let own = std::env::current_exe().ok();
        let named = READABLE.iter().chain(&READABLE_OF_PROC).map(Path::new);
        let all = named.chain([folder]).chain(own.as_deref());
        for path in all.chain(readable.iter().map(PathBuf::as_path)) {
            // Paths that do not exist are not read.
            let Ok(opened) = PathFd::new(path) else { continue };
            let access = if path.is_dir() { read } else { AccessFs::ReadFile | AccessFs::Execute };
            rules = rules.add_rule(PathBeneath::new(opened, access))?;
        }
        rules.restrict_self()?;
        match calls::refuse(if programs { Programs::Allowed } else { Programs::Refused }) {
            // A kernel without filters: as without Landlock, this is reported and not refused.
            Err(why) if !strict && calls::is_unknown(&why) => Ok(()),
            refused => Ok(refused?),
        }
    };
    confine().map_err(unconfined_by)
}

/// For an isolated run, at its start: it writes only below `folder`, and makes no connections. In
/// its own namespaces its processes are counted separately from others of the user.
pub fn this_process_writes(folder: &Path, apart: bool) -> Result<()> {
    APART.store(apart, Ordering::Relaxed);
    if apart {
        apart::drop_capabilities().map_err(|why| unconfined_by(why.into()))?;
    }
    process(&[], folder, apart)
}

/// Whether everything that this process starts ends with it.
static APART: AtomicBool = AtomicBool::new(false);

/// For an isolated run, before FMUs are loaded: from now on it reads only libraries, `folder` and
/// `readable`, and starts programs only if they are wanted and end with it.
pub fn this_process_computes(folder: &Path, readable: &[PathBuf], programs: bool) -> Result<()> {
    this_thread(folder, readable, programs && APART.load(Ordering::Relaxed), true)
}

/// Why FMUs cannot be confined here; `None` if they can.
pub fn unconfined() -> Option<String> {
    let supported = Ruleset::default()
        .set_compatibility(CompatLevel::HardRequirement)
        .handle_access(AccessFs::from_write(NEEDED))
        .and_then(|rules| rules.handle_access(AccessNet::from_all(NEEDED)))
        .and_then(Ruleset::create);
    supported.err().map(|why| {
        format!(
            "FMUs are not confined: the kernel has no Landlock for files and networks \
             (Linux 6.7 and later): {why}"
        )
    })
}

/// Shown if the kernel does not support it.
pub(crate) const LOOSE: &str = "not confined: the kernel has no Landlock";

/// A short description.
pub(crate) fn describe(wanted: bool) -> String {
    let text = match (wanted, unconfined()) {
        (true, None) => "confined by Landlock and seccomp",
        (true, Some(_)) => LOOSE,
        (false, _) => "not confined: --no-confine",
    };
    text.to_owned()
}

fn unconfined_by(why: Box<dyn std::error::Error>) -> Error {
    Error::new(Code::Session, "the process with the FMUs could not be confined")
        .why(why)
        .help("start the worker with --no-confine to run without")
}
