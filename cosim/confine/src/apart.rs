//! Runs a process in its own namespaces, and ends everything that processes started.
#![allow(unsafe_code, reason = "system calls without a safe form")]

use std::io;
use std::path::Path;
use std::process::{Child, Command};
use std::sync::{Mutex, PoisonError};

use cosim_base::error::{Code, Error, Result};

/// The side of a process on which [`Apart::go`] returns.
pub enum Apart {
    /// The process that continues and sees no other process; whether it has its own namespaces.
    Inside(bool),
    /// The surrounding processes: their work is done, and this is the status to exit with.
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
    /// Continues in new namespaces for users, processes, networks, mounts and IPC, where the kernel
    /// allows that, and unchanged otherwise. This process waits outside for the end of the one that
    /// continues; between them is the first process of the new namespace, whose end is the end of
    /// everything started there. Must be called while there is only one thread.
    pub fn go() -> Result<Self> {
        // SAFETY: only queries ids.
        let (user, group) = unsafe { (libc::geteuid(), libc::getegid()) };
        // SAFETY: there is one thread, and nothing here depends on what is left behind.
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
        // The surrounding processes end with the one that continues, and not before: signals from a
        // user are meant for that one.
        let before = SIGNALS.map(|signal| {
            // SAFETY: sets how this process handles a signal.
            unsafe { libc::signal(signal, libc::SIG_IGN) }
        });
        if let Some(status) = wait_for_child()? {
            return Ok(Self::Outside(status));
        }
        // The first process of the namespace: it adopts orphans.
        if let Some(status) = wait_for_child()? {
            return Ok(Self::Outside(status));
        }
        for (signal, before) in SIGNALS.into_iter().zip(before) {
            // SAFETY: restores it.
            unsafe { libc::signal(signal, before) };
        }
        Ok(Self::Inside(true))
    }
}

/// In the parent: the status to exit with once the child has ended. `None` in the child.
fn wait_for_child() -> Result<Option<i32>> {
    // SAFETY: there is one thread, so the child is a complete copy.
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

/// Drops the capabilities of a process in namespaces that it has created.
pub(super) fn drop_capabilities() -> io::Result<()> {
    // The structures of the kernel: version 3, this process; three sets of 64 bits in halves.
    let header: [u32; 2] = [0x2008_0522, 0];
    let none = [[0_u32; 3]; 2];
    // SAFETY: reads the two structures, which live until it returns.
    match unsafe { libc::syscall(libc::SYS_capset, header.as_ptr(), none.as_ptr()) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

fn failed(what: &str) -> Error {
    Error::new(Code::Session, format!("an isolated process could not be created ({what})"))
}

/// From now on, orphans of processes started here are adopted by this process, which can end them.
pub fn reap_descendants() {
    // SAFETY: sets a flag of this process.
    unsafe { libc::prctl(libc::PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0) };
}

/// The children known to this process.
static KNOWN: Mutex<Vec<u32>> = Mutex::new(Vec::new());

/// A child that is killed with its value, and with it everything that it has started: an FMU in an
/// endless loop reacts to nothing gentler. For processes that called [`reap_descendants`].
pub struct Supervised(pub Child);

impl Supervised {
    /// Starts the child.
    pub fn start(command: &mut Command) -> io::Result<Self> {
        let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        let child = command.spawn()?;
        known.push(child.id());
        Ok(Self(child))
    }
}

impl Drop for Supervised {
    fn drop(&mut self) {
        // Its descendants first, which would otherwise become ours.
        if let Ok(None) = self.0.try_wait() {
            kill_descendants(self.0.id());
        }
        // It may have ended already.
        drop(self.0.kill());
        drop(self.0.wait());
        let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        known.retain(|known| *known != self.0.id());
        drop(known);
        // Processes that it started in its last moments.
        kill_orphans();
    }
}

/// Kills the children of this process that it does not know, with everything they started: they are
/// orphans of other processes.
pub fn kill_orphans() {
    let known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    kill_all(std::process::id(), &|process| known.contains(&process));
}

/// Kills every process that descends from `root`, except `root` itself; processes that start new
/// ones meanwhile are stopped first. Waits for those that are children of this process.
pub fn kill_descendants(root: u32) {
    let own = root == std::process::id();
    // Usually there is nothing to search for.
    if own && has_no_children() {
        return;
    }
    kill_all(root, &|_| false);
    // SAFETY: waits for children that are dead.
    while own && unsafe { libc::waitpid(-1, std::ptr::null_mut(), libc::WNOHANG) } > 0 {}
}

/// Kills what this process started, except processes that are spared, lead their own group and have
/// no descendants: whatever started something ends with it.
pub fn kill_started(is_spared: &dyn Fn(u32) -> bool) {
    if has_no_children() {
        return;
    }
    // SAFETY: only asks.
    let leads = |process: u32| unsafe { libc::getpgid(process as i32) } == process as i32;
    let is_alone = |process: u32| descendants(process, &|_| false).is_empty();
    kill_all(std::process::id(), &|process| {
        leads(process) && is_spared(process) && is_alone(process)
    });
    // SAFETY: waits for children that are dead.
    while unsafe { libc::waitpid(-1, std::ptr::null_mut(), libc::WNOHANG) } > 0 {}
}

/// Kills what descends from `root`, except for processes that are spared, and what they started.
fn kill_all(root: u32, is_spared: &dyn Fn(u32) -> bool) {
    // In a PID namespace the numbers differ from those in /proc, and its end is the end of all.
    let own = std::fs::read_link("/proc/self").ok();
    if own.is_none_or(|own| own.to_str() != Some(&std::process::id().to_string())) {
        return;
    }
    let mut calm = false;
    for _ in 0..ROUNDS {
        let found = descendants(root, is_spared);
        // A process that starts another one and ends while /proc is read hides it once.
        if found.is_empty() && std::mem::replace(&mut calm, true) {
            return;
        }
        calm = found.is_empty();
        for signal in [libc::SIGSTOP, libc::SIGKILL] {
            for &process in &found {
                // SAFETY: a signal to a process that was just seen to descend from ours.
                unsafe { libc::kill(process, signal) };
            }
        }
        for &process in &found {
            // SAFETY: waits for a child, or fails if it is not one.
            unsafe { libc::waitpid(process, std::ptr::null_mut(), libc::WNOHANG) };
        }
        if !calm {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
    }
}

fn has_no_children() -> bool {
    let options = libc::WEXITED | libc::WNOHANG | libc::WNOWAIT;
    // SAFETY: only asks; nothing is stored, and no child is waited for.
    let asked = unsafe { libc::waitid(libc::P_ALL, 0, std::ptr::null_mut(), options) };
    asked == -1 && io::Error::last_os_error().raw_os_error() == Some(libc::ECHILD)
}

/// How often to look for processes that were started meanwhile.
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
            // Dead processes start nothing; their parents wait for them.
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

/// Closes the files that the parent process had open, except these: files that an FMU could write
/// to despite all rules.
pub fn close_inherited(kept: &[i32]) {
    let mut kept: Vec<u32> = kept.iter().filter_map(|&file| u32::try_from(file).ok()).collect();
    kept.sort_unstable();
    let mut first: u32 = 3;
    for file in kept.into_iter().chain([u32::MAX]) {
        if file > first {
            // SAFETY: called at the start of the process, when nothing owns these descriptors.
            unsafe { libc::syscall(libc::SYS_close_range, first, file - 1, 0) };
        }
        first = file.saturating_add(1);
    }
}
