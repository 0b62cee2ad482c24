//! What processes with FMUs may do: compute. An FMU is native code of somebody else.
//!
//! Four layers, which need no rights and hold for ever:
//!
//! * Landlock for the whole process, before it does anything else: nothing outside of its temporary
//!   folder is written, TCP goes nowhere but to the port of the coordinator, and signals reach nobody
//!   outside;
//! * limits of memory, files and their sizes (`limits`);
//! * for the thread that computes, and for those that FMUs start: no TCP at all, and nothing is read
//!   but programs, libraries and what was said to be readable;
//! * a filter of system calls for all threads (`calls`): no rights, owners or times of files are
//!   changed, no sockets opened, no programs started, no processes stopped.
//!
//! `apart` puts a process behind namespaces as well.

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
pub use apart::{Apart, close_inherited, kill_descendants, reap_descendants};
pub(crate) use apart::{forget, kill_orphans, spawn};
use calls::Programs;

/// The first version of Landlock that knows networks.
const NEEDED: ABI = ABI::V4;
/// What later ones add is used where it is there.
const WANTED: ABI = ABI::V6;
/// What programs write to that is no file.
const SINKS: [&str; 3] = ["/dev/null", "/dev/zero", "/dev/full"];
/// What every program reads: itself, libraries and what these are told about the machine.
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
/// Of the machine, without a name of anybody in them.
const READABLE_OF_PROC: [&str; 4] =
    ["/proc/cpuinfo", "/proc/meminfo", "/proc/stat", "/proc/sys/vm/overcommit_memory"];

type Attempt<T> = Result<T, Box<dyn std::error::Error>>;

/// For the whole process, which writes only below `folder`, and dials only these ports.
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
            // A machine without such a file has nobody who writes to it.
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

/// For the calling thread and those that it will start: no TCP, and nothing is read but libraries,
/// what lies below `folder` and what is `readable`. And for all threads the filter of system calls.
/// Only a process whose programs all end with it may start some. `strict`: a kernel that has no
/// filters is an error.
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
            // What is not there is not read.
            let Ok(opened) = PathFd::new(path) else { continue };
            let access = if path.is_dir() { read } else { AccessFs::ReadFile | AccessFs::Execute };
            rules = rules.add_rule(PathBeneath::new(opened, access))?;
        }
        rules.restrict_self()?;
        match calls::refuse(if programs { Programs::Allowed } else { Programs::Refused }) {
            // A kernel without filters; as without Landlock, that is told and not refused.
            Err(why) if !strict && calls::is_unknown(&why) => Ok(()),
            refused => Ok(refused?),
        }
    };
    confine().map_err(unconfined_by)
}

/// For an isolated run, at its start: it writes only below `folder`, and dials nobody. In namespaces
/// of its own its processes are counted apart from the user's others.
pub fn this_process_writes(folder: &Path, apart: bool) -> Result<()> {
    APART.store(apart, Ordering::Relaxed);
    if apart {
        apart::drop_capabilities().map_err(|why| unconfined_by(why.into()))?;
    }
    process(&[], folder, apart)
}

/// Whether all that this process starts ends with it.
static APART: AtomicBool = AtomicBool::new(false);

/// For an isolated run, before FMUs are loaded: from now on it reads libraries, `folder` and what is
/// `readable`, and starts programs only if they are wanted and end with it.
pub fn this_process_computes(folder: &Path, readable: &[PathBuf], programs: bool) -> Result<()> {
    this_thread(folder, readable, programs && APART.load(Ordering::Relaxed), true)
}

/// Why FMUs cannot be confined here; nothing when they can.
pub fn unconfined() -> Option<String> {
    let supported = Ruleset::default()
        .set_compatibility(CompatLevel::HardRequirement)
        .handle_access(AccessFs::from_write(NEEDED))
        .and_then(|rules| rules.handle_access(AccessNet::from_all(NEEDED)))
        .and_then(Ruleset::create);
    supported.err().map(|why| {
        format!(
            "FMUs are not confined: the kernel has no Landlock that knows files and networks \
             (Linux 6.7 and later): {why}"
        )
    })
}

/// What is said where the kernel cannot.
pub(crate) const LOOSE: &str = "not confined: the kernel has no Landlock";

/// In a few words.
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
        .help("--no-confine of a worker does without")
}
