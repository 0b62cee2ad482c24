//! What processes with FMUs may do: compute. An FMU is third-party native code.
//!
//! Four layers, which need no privileges and are permanent:
//!
//! * Landlock for the whole process, before it does anything else: nothing outside its temporary
//!   folder is written, TCP connects only to the port of the coordinator, and signals reach no
//!   outside process;
//! * limits of memory, files and their sizes (`limits`);
//! * for all threads: only programs, libraries and explicitly readable files are read; on workers
//!   also the files needed to reach the coordinator, except by the thread that computes and those
//!   that FMUs start, which have no TCP at all;
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
    ABI, Access, AccessFs, AccessNet, BitFlags, CompatLevel, Compatible, NetPort, PathBeneath,
    PathFd, Ruleset, RulesetAttr, RulesetCreated, RulesetCreatedAttr, Scope,
};

pub use apart::{
    Apart, Supervised, close_inherited, kill_descendants, kill_orphans, kill_started,
    reap_descendants,
};
use calls::Programs;
use cosim_base::error::{Code, Error, Result};

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

/// What names of machines are looked up with.
const RESOLVER: [&str; 6] = [
    "/etc/hosts",
    "/etc/host.conf",
    "/etc/resolv.conf",
    "/etc/gai.conf",
    "/run/systemd/resolve",
    "/sys/class/net",
];

type Attempt<T> = Result<T, Box<dyn std::error::Error>>;

/// For the whole process, which writes only below `folder`, and connects only to these ports.
pub fn process(ports: &[u16], folder: &Path, counted_apart: bool) -> Result<()> {
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
pub fn this_thread(
    folder: &Path,
    readable: &[PathBuf],
    programs: bool,
    strict: bool,
) -> Result<()> {
    let confine = || -> Attempt<()> {
        reads(folder, readable, AccessNet::from_all(WANTED))?.restrict_self()?;
        match calls::refuse(if programs { Programs::Allowed } else { Programs::Refused }) {
            // A kernel without filters: as without Landlock, this is reported and not refused.
            Err(why) if !strict && calls::is_unknown(&why) => Ok(()),
            refused => Ok(refused?),
        }
    };
    confine().map_err(unconfined_by)
}

/// For all threads that this one will start, and itself: only libraries, files below `folder` and
/// `readable` are read, and what is needed to reach the coordinator. An FMU can use each of them.
pub fn all_threads_read(folder: &Path, readable: &[PathBuf]) -> Result<()> {
    check_alone()?;
    let readable: Vec<PathBuf> =
        RESOLVER.iter().map(PathBuf::from).chain(readable.iter().cloned()).collect();
    let confine = || -> Attempt<()> {
        reads(folder, &readable, BitFlags::EMPTY)?.restrict_self()?;
        Ok(())
    };
    confine().map_err(unconfined_by)
}

/// An FMU can use every thread of its process: none may exist before it is confined.
fn check_alone() -> Result<()> {
    match std::fs::read_dir("/proc/self/task").map_or(0, Iterator::count) {
        1 => Ok(()),
        threads => Err(unconfined_by(format!("there are {threads} threads").into())),
    }
}

/// Rules by which only these, and libraries, are read.
fn reads(
    folder: &Path,
    readable: &[PathBuf],
    network: BitFlags<AccessNet>,
) -> Attempt<RulesetCreated> {
    let read = AccessFs::from_read(WANTED);
    let rules =
        Ruleset::default().set_compatibility(CompatLevel::BestEffort).handle_access(read)?;
    let rules = if network.is_empty() { rules } else { rules.handle_access(network)? };
    let mut rules = rules.create()?;
    let own = std::env::current_exe().ok();
    let named = READABLE.iter().chain(&READABLE_OF_PROC).map(Path::new);
    let all = named.chain([folder]).chain(own.as_deref());
    for path in all.chain(readable.iter().map(PathBuf::as_path)) {
        // Paths that do not exist are not read.
        let Ok(opened) = PathFd::new(path) else { continue };
        let access = if path.is_dir() { read } else { AccessFs::ReadFile | AccessFs::Execute };
        rules = rules.add_rule(PathBeneath::new(opened, access))?;
    }
    Ok(rules)
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
    check_alone()?;
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
pub const LOOSE: &str = "not confined: the kernel has no Landlock";

/// A short description.
pub fn describe(wanted: bool) -> String {
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
