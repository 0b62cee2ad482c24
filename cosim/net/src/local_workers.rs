//! Workers that are started for one run on this machine. They end with the run, however it ends; a
//! worker that is killed is restarted.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use std::os::unix::process::{CommandExt, ExitStatusExt};

use cosim_base::error::{Code, Error, Result};

/// Interval at which they are checked.
const LOOK: Duration = Duration::from_millis(10);
/// Time they have for an orderly shutdown.
const GRACE: Duration = Duration::from_secs(2);

/// The workers, supervised by a thread.
pub(super) struct LocalWorkers {
    ended: Arc<AtomicBool>,
    keeper: Option<JoinHandle<()>>,
}

impl LocalWorkers {
    /// Starts workers with these names by `program`, which connect to `endpoint`. Their temporary
    /// files go into `folder`.
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
                // Ctrl-C at a terminal is meant for the process that the user started.
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
        // Children are tied to the thread that started them; this thread lives as long as they do.
        own.keeper = Some(std::thread::spawn(move || keep(kept, &ended)));
        Ok(own)
    }
}

impl Drop for LocalWorkers {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        if let Some(keeper) = self.keeper.take() {
            // A supervisor that panicked has no child any more.
            drop(keeper.join());
        }
    }
}

fn keep(mut workers: Vec<(Command, Child)>, ended: &AtomicBool) {
    while !ended.load(Ordering::Relaxed) {
        for (command, child) in &mut workers {
            let killed = child.try_wait().ok().flatten().is_some_and(|s| s.signal().is_some());
            // A worker that exited by itself reported why, and would do so again.
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

/// Requests an orderly shutdown: a worker ends its children first.
fn terminate(child: &Child) {
    if let Some(process) = i32::try_from(child.id()).ok().and_then(rustix::process::Pid::from_raw) {
        // It may have exited already; it has not been waited for, so the process id is still its
        // own.
        let _ = rustix::process::kill_process(process, rustix::process::Signal::TERM);
        // A stopped process would not receive the signal.
        let _ = rustix::process::kill_process(process, rustix::process::Signal::CONT);
    }
}

fn kill(child: &mut Child) {
    // It may have exited already.
    let _ = child.kill();
    let _ = child.wait();
}
