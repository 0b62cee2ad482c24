//! What the processes of groups may do: compute. An FMU is native code of somebody else.
//!
//! Two layers of Landlock, which need no rights and hold for ever. The first is for the whole
//! process, before the session is opened: nothing outside of its temporary folder is written, TCP
//! goes nowhere but to the port of the coordinator, and signals reach nobody outside. The second is
//! for the thread that computes, and for those that FMUs start: no TCP at all. Reading is not
//! restricted: libraries, and Python for those that need it, may be anywhere.

use std::path::Path;

use landlock::{
    ABI, Access, AccessFs, AccessNet, CompatLevel, Compatible, NetPort, PathBeneath, PathFd,
    Ruleset, RulesetAttr, RulesetCreatedAttr, RulesetStatus, Scope,
};

use super::endpoint::Endpoint;
use crate::error::{Code, Error, Result};

/// The first version of Landlock that knows networks.
const NEEDED: ABI = ABI::V4;
/// What later ones add is used where it is there.
const WANTED: ABI = ABI::V6;
/// What programs write to that is no file.
const SINKS: [&str; 3] = ["/dev/null", "/dev/zero", "/dev/full"];

/// For the whole process, which writes only to `folder`, and dials only these endpoints.
pub(crate) fn process(endpoints: &[String], folder: &Path) -> Result<()> {
    let ports = endpoints.iter().filter_map(|endpoint| match Endpoint::parse(endpoint) {
        Ok(Endpoint::Tcp(_, port) | Endpoint::Tls(_, port)) => Some(port),
        _ => None,
    });
    let confine = || -> Result<RulesetStatus, Box<dyn std::error::Error>> {
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
        for port in ports {
            rules = rules.add_rule(NetPort::new(port, AccessNet::ConnectTcp))?;
        }
        Ok(rules.restrict_self()?.ruleset)
    };
    confine().map(drop).map_err(unconfined_by)
}

/// For the calling thread and those that it will start: no TCP.
pub(crate) fn this_thread() -> Result<()> {
    let confine = || -> Result<RulesetStatus, Box<dyn std::error::Error>> {
        let rules = Ruleset::default()
            .set_compatibility(CompatLevel::BestEffort)
            .handle_access(AccessNet::from_all(WANTED))?
            .create()?;
        Ok(rules.restrict_self()?.ruleset)
    };
    confine().map(drop).map_err(unconfined_by)
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
        (true, None) => "confined by Landlock",
        (true, Some(_)) => LOOSE,
        (false, _) => "not confined: --no-confine",
    };
    text.to_owned()
}

/// Closes what the process that started this one had open: files that an FMU could write to in
/// spite of all rules.
pub fn close_inherited() {
    // SAFETY: called at the start of the process, when nobody owns a descriptor above stderr.
    unsafe { libc::syscall(libc::SYS_close_range, 3, libc::c_uint::MAX, 0) };
}

fn unconfined_by(why: Box<dyn std::error::Error>) -> Error {
    Error::new(Code::Session, "the process of a group could not be confined")
        .why(why)
        .help("--no-confine of the worker does without")
}
