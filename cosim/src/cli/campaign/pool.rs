//! Processes that make runs. Each makes many, so that FMUs are loaded only once. If a process ends
//! or takes too long, only its current run is lost, and another process takes its place.

use std::io::{Read, Write};
use std::os::fd::AsFd;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{ChildStdin, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError, mpsc};
use std::time::{Duration, Instant};

use cosim::campaign::{Bench, Row, Status, fingerprint};
use cosim::confine::Supervised;
use cosim::{Code, Error, Result};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::cli::interrupt::interrupted;

/// Everything needed to make runs.
pub(super) struct Pool<'a> {
    bench: &'a Bench,
    program: PathBuf,
    identity: String,
    jobs: usize,
}

impl<'a> Pool<'a> {
    pub(super) fn new(bench: &'a Bench, identity: &[String], jobs: usize) -> Result<Self> {
        let program = std::env::current_exe()
            .map_err(|e| Error::new(Code::File, "this program cannot be found").why(e))?;
        Ok(Self { bench, program, identity: fingerprint(identity), jobs })
    }

    /// Makes these runs, as many in parallel as there are jobs, and hands over each row when it is
    /// ready. After a signal or an error of `keep`, no further run is started.
    pub(super) fn make(
        &self,
        runs: impl Iterator<Item = u64> + Send,
        keep: &mut dyn FnMut(Row) -> Result<()>,
    ) -> Result<()> {
        let (runs, enough) = (Mutex::new(runs.fuse()), AtomicBool::new(false));
        let next = || runs.lock().unwrap_or_else(PoisonError::into_inner).next();
        let (send, receive) = mpsc::channel();
        std::thread::scope(|scope| {
            for _ in 0..self.jobs {
                let (send, next, enough) = (send.clone(), &next, &enough);
                scope.spawn(move || {
                    let mut maker = None;
                    while !enough.load(Ordering::Relaxed) && !interrupted() {
                        let Some(run) = next() else { break };
                        if send.send(self.row(&mut maker, run)).is_err() {
                            break;
                        }
                    }
                });
            }
            drop(send);
            let mut outcome = Ok(());
            for row in receive {
                if outcome.is_ok() {
                    outcome = row.and_then(&mut *keep);
                    enough.store(outcome.is_err(), Ordering::Relaxed);
                }
            }
            outcome
        })
    }

    /// Makes a run in an idle process, or in a new one.
    fn row(&self, maker: &mut Option<Maker>, run: u64) -> Result<Row> {
        let mut at_work = match maker.take() {
            Some(maker) => maker,
            None => self.start()?,
        };
        let limit = Duration::try_from_secs_f64(self.bench.campaign().time_limit);
        match at_work.ask(run, limit.unwrap_or(Duration::MAX)) {
            Ok(row) => {
                *maker = Some(at_work);
                Ok(row)
            }
            Err(Status::TimedOut) => {
                at_work.hangs = true;
                let limit = self.bench.campaign().time_limit;
                let reason = format!("it took longer than {limit} s");
                Ok(self.bench.lost(run, Status::TimedOut, reason))
            }
            Err(status) => {
                let reason = format!("the process that made it ended: {}", at_work.end());
                Ok(self.bench.lost(run, status, reason))
            }
        }
    }

    fn start(&self) -> Result<Maker> {
        let mut command = Command::new(&self.program);
        command.arg("campaign-worker").arg(&self.bench.campaign().file);
        command.args(["--identity", &self.identity]);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        // Ctrl-C is meant for this process: the runs in progress are finished.
        command.process_group(0);
        let wrong = |why: String| Error::new(Code::Lost, "no process can make runs").why(why);
        let mut process = Supervised::start(&mut command).map_err(|e| wrong(e.to_string()))?;
        match (process.0.stdin.take(), process.0.stdout.take()) {
            (Some(input), Some(output)) => {
                Ok(Maker { process, hangs: false, input: Some(input), output, read: Vec::new() })
            }
            _ => Err(wrong("it has no pipes".to_owned())),
        }
    }
}

/// A process that makes runs.
struct Maker {
    process: Supervised,
    /// Whether it is not waited for.
    hangs: bool,
    input: Option<ChildStdin>,
    output: ChildStdout,
    read: Vec<u8>,
}

impl Maker {
    /// The row of a run, or how it failed.
    fn ask(&mut self, run: u64, limit: Duration) -> Result<Row, Status> {
        let begun = Instant::now();
        let input = self.input.as_mut().ok_or(Status::Crashed)?;
        input.write_all(format!("{run}\n").as_bytes()).map_err(|_| Status::Crashed)?;
        let left = limit.saturating_sub(begun.elapsed());
        read_until(&mut self.output, &mut self.read, left, |read| {
            let end = read.iter().position(|octet| *octet == b'\n')?;
            let row = serde_json::from_slice(&read[..end]).map_err(|_| Status::Crashed);
            read.drain(..=end);
            Some(row)
        })?
    }

    /// How a process ended.
    fn end(&mut self) -> String {
        self.process.0.wait().map_or_else(|e| e.to_string(), |status| status.to_string())
    }
}

/// Reads until a row arrives: crashed if the process ends first, timed out after the limit.
pub(super) fn read_until<T>(
    output: &mut (impl Read + AsFd),
    read: &mut Vec<u8>,
    limit: Duration,
    found: impl Fn(&mut Vec<u8>) -> Option<T>,
) -> Result<T, Status> {
    let begun = Instant::now();
    loop {
        if let Some(found) = found(read) {
            return Ok(found);
        }
        let left = limit.saturating_sub(begun.elapsed());
        let mut look = [PollFd::new(output, PollFlags::IN)];
        let left = Timespec::try_from(left.min(Duration::from_secs(3600)));
        match poll(&mut look, left.ok().as_ref()) {
            Ok(0) if begun.elapsed() >= limit => return Err(Status::TimedOut),
            Ok(0) | Err(rustix::io::Errno::INTR) => continue,
            Ok(_) => {}
            Err(_) => return Err(Status::Crashed),
        }
        let mut part = [0; 4096];
        match output.read(&mut part) {
            Ok(0) | Err(_) => return Err(Status::Crashed),
            Ok(count) => read.extend_from_slice(&part[..count]),
        }
    }
}

impl Drop for Maker {
    fn drop(&mut self) {
        // A process that waits for its next run ends by itself, so that its unpacked files are
        // removed. One that hangs does not.
        self.input = None;
        let patience = Instant::now();
        while !self.hangs && patience.elapsed() < Duration::from_secs(2) {
            if !matches!(self.process.0.try_wait(), Ok(None)) {
                return;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}
