//! Workers that are started for one run, on this machine. They end with it, however it ends; one
//! that is killed is started again.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use std::os::unix::process::{CommandExt, ExitStatusExt};

use crate::error::{Code, Error, Result};

/// They are looked at so often.
const LOOK: Duration = Duration::from_millis(10);
/// They may take so long to end in order.
const GRACE: Duration = Duration::from_secs(2);

/// The workers, kept by a thread.
pub(super) struct LocalWorkers {
    ended: Arc<AtomicBool>,
    keeper: Option<JoinHandle<()>>,
}

impl LocalWorkers {
    /// Starts those of these names by `program`, which dial `endpoint`. What is temporary goes into
    /// `folder`.
    pub(super) fn start(
        program: &[String],
        names: &[String],
        endpoint: &str,
        folder: &Path,
    ) -> Result<Self> {
        let ended = Arc::new(AtomicBool::new(false));
        let mut own = Self { ended: ended.clone(), keeper: None };
        let Some((file, arguments)) = program.split_first().filter(|_| !names.is_empty()) else {
            return Ok(own);
        };
        let commands = names.iter().map(|name| {
            let mut command = Command::new(file);
            command
                .args(arguments)
                .args(["--name", name])
                .args(["--connect", endpoint])
                .env("TMPDIR", folder)
                .stdin(Stdio::null())
                // Ctrl-C at a terminal is for the process that the user started.
                .process_group(0);
            command
        });
        let mut kept = Vec::new();
        for mut command in commands {
            match command.spawn() {
                Ok(child) => kept.push((command, child)),
                Err(why) => {
                    kept.into_iter().for_each(|(_, mut child)| kill(&mut child));
                    let what = "a worker cannot be started";
                    return Err(Error::new(Code::Session, what).at(file).why(why));
                }
            }
        }
        // Children are tied to the thread that started them: this one lives as long as they do.
        own.keeper = Some(std::thread::spawn(move || keep(kept, &ended)));
        Ok(own)
    }
}

impl Drop for LocalWorkers {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        if let Some(keeper) = self.keeper.take() {
            // One that panicked has no child any more.
            drop(keeper.join());
        }
    }
}

fn keep(mut workers: Vec<(Command, Child)>, ended: &AtomicBool) {
    while !ended.load(Ordering::Relaxed) {
        for (command, child) in &mut workers {
            let killed = child.try_wait().ok().flatten().is_some_and(|s| s.signal().is_some());
            // One that ended itself said why, and would do so again.
            if killed && let Ok(next) = command.spawn() {
                *child = next;
            }
        }
        std::thread::sleep(LOOK);
    }
    for (_, child) in &workers {
        terminate(child);
    }
    let begun = Instant::now();
    while begun.elapsed() < GRACE {
        workers.retain_mut(|(_, child)| matches!(child.try_wait(), Ok(None)));
        if workers.is_empty() {
            return;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    workers.iter_mut().for_each(|(_, child)| kill(child));
}

/// Asks for an end in order: the children of a worker go before it.
fn terminate(child: &Child) {
    if let Some(process) = i32::try_from(child.id()).ok().and_then(rustix::process::Pid::from_raw) {
        // It may have ended already; it is not waited for yet, so the number is still its own.
        let _ = rustix::process::kill_process(process, rustix::process::Signal::TERM);
        // One that is stopped would not hear it.
        let _ = rustix::process::kill_process(process, rustix::process::Signal::CONT);
    }
}

fn kill(child: &mut Child) {
    // It may have ended already.
    let _ = child.kill();
    let _ = child.wait();
}
