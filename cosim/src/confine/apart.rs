//! A process behind namespaces, and the end of everything that processes started.
#![allow(unsafe_code, reason = "system calls without a safe form")]

use std::io;
use std::path::Path;
use std::process::{Child, Command};
use std::sync::{Mutex, PoisonError};

use crate::error::{Code, Error, Result};

/// The side of a process that [`Apart::go`] left.
pub enum Apart {
    /// The one that goes on, with nobody else in sight; whether in namespaces of its own.
    Inside(bool),
    /// The ones around it: their work is done, and this is the status to end with.
    Outside(i32),
}

const SIGNALS: [libc::c_int; 3] = [libc::SIGINT, libc::SIGTERM, libc::SIGHUP];
const NAMESPACES: libc::c_int = libc::CLONE_NEWUSER
    | libc::CLONE_NEWPID
    | libc::CLONE_NEWNET
    | libc::CLONE_NEWNS
    | libc::CLONE_NEWIPC
    | libc::CLONE_NEWUTS;

impl Apart {
    /// Goes on in namespaces of its own for users, processes, networks, mounts and IPC, where the
    /// kernel allows that, and otherwise as it is. This process waits outside for the end of the one
    /// that goes on; in between is the first process of the new namespace, whose end is that of all
    /// that were started there. Called while there is one thread.
    pub fn go() -> Result<Self> {
        // SAFETY: asks for numbers.
        let (user, group) = unsafe { (libc::geteuid(), libc::getegid()) };
        // SAFETY: there is one thread, and nothing here depends on what is left.
        if unsafe { libc::unshare(NAMESPACES) } != 0 {
            return Ok(Self::Inside(false));
        }
        let write = |file: &str, text: String| {
            std::fs::write(Path::new("/proc/self").join(file), text)
                .map_err(|why| failed(&format!("/proc/self/{file}")).why(why))
        };
        write("setgroups", "deny".to_owned())?;
        write("uid_map", format!("{user} {user} 1"))?;
        write("gid_map", format!("{group} {group} 1"))?;
        // Those around the one that goes on end when it does, and not before: what a user sends them is
        // for that one.
        let before = SIGNALS.map(|signal| {
            // SAFETY: sets how this process takes a signal.
            unsafe { libc::signal(signal, libc::SIG_IGN) }
        });
        if let Some(status) = wait_for_child()? {
            return Ok(Self::Outside(status));
        }
        // The first process of the namespace: it adopts what the others leave.
        if let Some(status) = wait_for_child()? {
            return Ok(Self::Outside(status));
        }
        for (signal, before) in SIGNALS.into_iter().zip(before) {
            // SAFETY: sets it back.
            unsafe { libc::signal(signal, before) };
        }
        Ok(Self::Inside(true))
    }
}

/// In the parent: the status to end with, when the child has ended. Nothing in the child.
fn wait_for_child() -> Result<Option<i32>> {
    // SAFETY: there is one thread, so the child is a whole copy.
    match unsafe { libc::fork() } {
        -1 => Err(failed("fork").why(io::Error::last_os_error())),
        0 => {
            // SAFETY: sets a flag of this process.
            unsafe { libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGKILL) };
            Ok(None)
        }
        child => loop {
            let mut status = 0;
            // SAFETY: the status is stored in a variable that lives until the call returns.
            let ended = unsafe { libc::waitpid(-1, &mut status, 0) };
            if ended == child {
                return Ok(Some(match libc::WIFSIGNALED(status) {
                    true => 128 + libc::WTERMSIG(status),
                    false => libc::WEXITSTATUS(status),
                }));
            }
            if ended == -1 && io::Error::last_os_error().kind() != io::ErrorKind::Interrupted {
                return Err(failed("waitpid").why(io::Error::last_os_error()));
            }
        },
    }
}

/// Gives up what a process may do in namespaces that it has made.
pub(super) fn drop_capabilities() -> io::Result<()> {
    // The kernel's structures: version 3, this process; three sets of 64 bits in halves.
    let header: [u32; 2] = [0x2008_0522, 0];
    let none = [[0_u32; 3]; 2];
    // SAFETY: reads the two structures, which live until it returns.
    match unsafe { libc::syscall(libc::SYS_capset, header.as_ptr(), none.as_ptr()) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

fn failed(what: &str) -> Error {
    Error::new(Code::Session, format!("a process apart could not be made ({what})"))
}

/// From now on what the processes started here leave behind comes to this one, which can end it.
pub fn reap_descendants() {
    // SAFETY: sets a flag of this process.
    unsafe { libc::prctl(libc::PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0) };
}

/// The children that this process knows.
static KNOWN: Mutex<Vec<u32>> = Mutex::new(Vec::new());

/// Starts a child that [`kill_orphans`] spares until it is forgotten.
pub(crate) fn spawn(command: &mut Command) -> io::Result<Child> {
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let child = command.spawn()?;
    known.push(child.id());
    Ok(child)
}

/// A child that has ended and was waited for.
pub(crate) fn forget(child: u32) {
    KNOWN.lock().unwrap_or_else(PoisonError::into_inner).retain(|known| *known != child);
}

/// Kills the children of this process that are not known to it, with all that they started: they were
/// left by others.
pub(crate) fn kill_orphans() {
    let known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    kill_all(std::process::id(), &|process| known.contains(&process));
}

/// Kills every process that descends from `root` but itself; whoever starts new ones meanwhile is
/// stopped first. What is left of them is waited for when they are this process's.
pub fn kill_descendants(root: u32) {
    kill_all(root, &|_| false);
}

/// The same but for children that are spared, and what they started.
fn kill_all(root: u32, is_spared: &dyn Fn(u32) -> bool) {
    // In a namespace of processes the numbers are others than in /proc, and its end is that of all.
    let own = std::fs::read_link("/proc/self").ok();
    if own.is_none_or(|own| own.to_str() != Some(&std::process::id().to_string())) {
        return;
    }
    for _ in 0..ROUNDS {
        let found = descendants(root, is_spared);
        if found.is_empty() {
            return;
        }
        for signal in [libc::SIGSTOP, libc::SIGKILL] {
            for &process in &found {
                // SAFETY: a signal to a process that was just seen to descend from ours.
                unsafe { libc::kill(process, signal) };
            }
        }
        for &process in &found {
            // SAFETY: waits for a child, or fails for what is none.
            unsafe { libc::waitpid(process, std::ptr::null_mut(), libc::WNOHANG) };
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
}

/// So often it is looked for those that were started meanwhile.
const ROUNDS: usize = 1000;

fn descendants(root: u32, is_spared: &dyn Fn(u32) -> bool) -> Vec<i32> {
    let entries = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let numbers = entries.filter_map(|entry| entry.file_name().to_str()?.parse::<i32>().ok());
    let parents: Vec<(i32, i32)> = numbers
        .filter_map(|process| {
            let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
            let mut words = stat.rsplit_once(") ")?.1.split(' ');
            let state = words.next()?;
            let parent = words.next()?.parse().ok()?;
            // The dead start nobody; whoever has to waits for them.
            (!matches!(state, "Z" | "X")).then_some((process, parent))
        })
        .collect();
    let mut found = vec![root as i32];
    let mut next = 0;
    while let Some(&above) = found.get(next) {
        let children = parents.iter().filter(|(_, p)| *p == above).map(|(process, _)| *process);
        found.extend(children.filter(|&process| !is_spared(process as u32)));
        next += 1;
    }
    found.split_off(1)
}

/// Closes what the process that started this one had open, but for these: files that an FMU could
/// write to in spite of all rules.
pub fn close_inherited(kept: &[i32]) {
    let mut kept: Vec<u32> = kept.iter().filter_map(|&file| u32::try_from(file).ok()).collect();
    kept.sort_unstable();
    let mut first: u32 = 3;
    for file in kept.into_iter().chain([u32::MAX]) {
        if file > first {
            // SAFETY: called at the start of the process, when nobody owns these descriptors.
            unsafe { libc::syscall(libc::SYS_close_range, first, file - 1, 0) };
        }
        first = file.saturating_add(1);
    }
}
