//! `--isolate`: a run with untrusted FMUs.
//!
//! The program starts itself once more. The child computes and may do nothing else: it has its own
//! namespaces where the kernel allows that, writes only to a temporary folder and the files that
//! were opened for it, reads only libraries and the files it was given, and has resource limits
//! (`cosim::confine`). This process opens those files, passes on the output of the child, keeps the
//! snapshots it leaves, ends it, and recognizes when an FMU ended the child, because the child did
//! not announce the end. Steps cost nothing more; only the start does.
#![allow(unsafe_code, reason = "system calls without a safe form")]

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, IsTerminal, Read, Write};
use std::os::fd::{AsRawFd, FromRawFd, OwnedFd, RawFd};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use clap::Args;
use cosim::confine::{self, Apart};
use cosim::files::{self, CONTINUED, Unfinished};
use cosim::fmi::archive::Unpacked;
use cosim::shown::relay;
use cosim::{Code, Error, Result};
use serde::{Deserialize, Serialize};

use super::interrupt;

#[derive(Args)]
#[command(next_help_heading = "Isolation")]
pub(crate) struct Isolation {
    /// Run untrusted FMUs: in a process that writes only the results, reads only libraries, and has
    /// no network, no programs and limited memory
    #[arg(long)]
    isolate: bool,
    /// Let isolated FMUs, and those in local workers of the run, read this file or folder
    /// (repeatable)
    #[arg(long, value_name = "PATH")]
    allow_read: Vec<PathBuf>,
}

/// The parameters of the child.
#[derive(Serialize, Deserialize)]
struct Inside {
    /// Files, and the descriptors through which they are written.
    given: Vec<(PathBuf, RawFd)>,
    /// Where it announces an orderly end.
    done: RawFd,
    folder: PathBuf,
}

/// Marks a process as the child.
const VARIABLE: &str = "COSIM_INSIDE";
/// The first descriptor that the child uses for itself.
const FIRST: RawFd = 64;
const LOOK: Duration = Duration::from_millis(10);
/// The largest snapshot that is kept, in octets.
const LARGEST: u64 = 4 << 30;
/// How long an interrupted child may take: longer than it gives its FMUs.
const GRACE: Duration = Duration::from_secs(8);

/// Output files of a run.
#[derive(Default)]
pub(crate) struct Written {
    /// Existing files that are continued.
    pub continued: Option<PathBuf>,
    /// New files.
    pub created: Vec<PathBuf>,
    /// A file of which copies are kept at some times, with the time for `{t}` in its name.
    pub snapshot: Option<PathBuf>,
}

impl Isolation {
    pub(crate) fn wanted(&self) -> bool {
        self.isolate && !is_inside()
    }

    /// Refuses rights for FMUs that are not confined, because they would have no effect.
    pub(crate) fn check(&self, workers: bool) -> Result<()> {
        if self.allow_read.is_empty() || self.isolate || workers {
            return Ok(());
        }
        Err(Error::new(Code::Usage, "--allow-read is for FMUs that are confined")
            .help("add --isolate, or --workers"))
    }

    /// What confined FMUs may read.
    pub(crate) fn readable(&self) -> impl Iterator<Item = String> {
        self.allow_read.iter().map(|path| path.display().to_string())
    }

    /// In the child, before FMUs are loaded: from now on, it may do no more than they may.
    pub(crate) fn shut(&self, programs: bool) -> Result<()> {
        match inside() {
            Some(inside) if self.isolate => {
                confine::this_process_computes(&inside.folder, &self.allow_read, programs)?;
                interrupt::hurry();
                Ok(())
            }
            _ => Ok(()),
        }
    }
}

/// Whether this process is an isolated one.
pub(crate) fn is_inside() -> bool {
    inside().is_some()
}

/// Read once: an FMU may change the environment.
static INSIDE: OnceLock<Inside> = OnceLock::new();

fn inside() -> Option<&'static Inside> {
    INSIDE.get()
}

/// In the child, at the very start: enters namespaces and continues in one process only. Returns
/// the exit status if this process is not the one that continues.
pub(crate) fn enter() -> Result<Option<i32>> {
    let Ok(text) = std::env::var(VARIABLE) else { return Ok(None) };
    let read: Inside = serde_json::from_str(&text)
        .map_err(|why| failed("the child cannot read its parameters").why(why))?;
    let inside = INSIDE.get_or_init(|| read);
    let kept: Vec<RawFd> =
        inside.given.iter().map(|(_, file)| *file).chain([inside.done]).collect();
    confine::close_inherited(&kept);
    let apart = match Apart::go()? {
        Apart::Outside(status) => return Ok(Some(status)),
        Apart::Inside(apart) => apart,
    };
    confine::this_process_writes(&inside.folder, apart)?;
    files::give(inside.given.clone(), inside.folder.clone());
    Ok(None)
}

/// In the child, at its end: announces that its exit code is intended.
pub(crate) fn leave(code: u8) {
    if let Some(inside) = inside() {
        // SAFETY: the descriptor was made for this purpose only.
        let mut done = unsafe { File::from_raw_fd(inside.done) };
        drop(done.write_all(&[code]));
    }
}

fn failed(what: &str) -> Error {
    Error::new(Code::Session, format!("the isolated run cannot be started: {what}"))
}

/// Runs the child to its end; its errors have been reported when this returns its exit code.
pub(crate) fn supervise(written: Written, programs: bool) -> Result<u8> {
    interrupt::be_patient();
    if let Some(why) = confine::unconfined() {
        return Err(failed("this kernel cannot confine it").why(why).help("run without --isolate"));
    }
    let folder = Unpacked::new()?;
    let outbox = folder.path().join("outbox");
    fs::create_dir(&outbox).map_err(|why| failed("a folder").why(why))?;
    let mut open: Vec<(PathBuf, OwnedFd)> = Vec::new();
    let unwritten = |path: &Path, why: io::Error| {
        Error::new(Code::Output, "the results cannot be written").at(path).why(why)
    };
    for path in &written.created {
        let file = files::create_plain(path, "the results cannot be written")?;
        open.push((path.clone(), file.into()));
    }
    let mut unfinished = None;
    if let Some(path) = &written.continued {
        let new = Unfinished::new(path).map_err(|why| unwritten(path, why))?;
        let file = new.file().try_clone().map_err(|why| unwritten(path, why))?;
        open.push((path.clone(), file.into()));
        unfinished = Some(new);
    }
    let (mut done, writer) = io::pipe().map_err(|why| failed("a pipe").why(why))?;
    let writer = OwnedFd::from(writer);
    let fds: Vec<RawFd> =
        open.iter().map(|(_, file)| file.as_raw_fd()).chain([writer.as_raw_fd()]).collect();
    let places = FIRST..;
    let given = open.iter().zip(places).map(|((path, _), place)| (path.clone(), place)).collect();
    let inside = Inside { given, done: FIRST + open.len() as RawFd, folder: outbox.clone() };
    let mut child = start(&inside, folder.path(), fds)?;
    drop((open, writer));
    let relays = [
        child.stdout.take().map(|from| relay(from, io::stdout(), io::stdout().is_terminal())),
        child.stderr.take().map(|from| relay(from, io::stderr(), true)),
    ];
    let kept = Kept { outbox, snapshot: written.snapshot };
    let status = watch(&mut child, &kept, &mut unfinished)?;
    relays.into_iter().flatten().for_each(|relay| drop(relay.join()));
    let mut code = [0];
    match done.read(&mut code) {
        Ok(1) => Ok(code[0]),
        _ => Err(ended(status, programs)),
    }
}

fn start(inside: &Inside, folder: &Path, fds: Vec<RawFd>) -> Result<Child> {
    let text = serde_json::to_string(inside).map_err(|why| failed("its parameters").why(why))?;
    let program = super::this_program()?;
    let arguments: Vec<OsString> = std::env::args_os().skip(1).collect();
    let mut command = Command::new(program);
    command
        .args(arguments)
        .env_clear()
        .envs(confine::environment())
        .env(VARIABLE, text)
        .env("TMPDIR", folder.join("outbox"))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .process_group(0);
    let first = FIRST;
    // SAFETY: only system calls are made between fork and exec.
    unsafe {
        command.pre_exec(move || {
            libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGKILL);
            for (place, &file) in (first..).zip(&fds) {
                if libc::dup2(file, place) < 0 {
                    return Err(io::Error::last_os_error());
                }
            }
            Ok(())
        });
    }
    command.spawn().map_err(|why| failed("its process").why(why))
}

/// Files that the child leaves for this process to keep.
struct Kept {
    outbox: PathBuf,
    snapshot: Option<PathBuf>,
}

impl Kept {
    /// Keeps them: first the results, then the snapshots that need them.
    fn take(&self, unfinished: &mut Option<Unfinished>) -> Result<()> {
        if self.outbox.join(CONTINUED).exists()
            && let Some(whole) = unfinished.take()
        {
            whole.finish().map_err(|why| {
                Error::new(Code::Output, "the results cannot be replaced").why(why)
            })?;
        }
        let Some(pattern) = &self.snapshot else { return Ok(()) };
        for entry in fs::read_dir(&self.outbox).into_iter().flatten().flatten() {
            let name = entry.file_name();
            let target = name.to_str().and_then(files::of_outbox);
            let Some(target) = target.filter(|target| is_of(pattern, target)) else { continue };
            let unwritten = |why: io::Error| {
                Error::new(Code::Output, "the snapshot cannot be written").at(&target).why(why)
            };
            if let Some(bytes) = files::read_foreign(&entry.path(), LARGEST).map_err(unwritten)? {
                files::refuse_others(&target, "the snapshot cannot be written", None)?;
                files::replace(&target, &bytes).map_err(unwritten)?;
                drop(fs::remove_file(entry.path()));
            }
        }
        Ok(())
    }
}

/// Whether a file matches the pattern, in which `{t}` stands for a time.
fn is_of(pattern: &Path, file: &Path) -> bool {
    let (Some(pattern), Some(file)) = (pattern.to_str(), file.to_str()) else { return false };
    let Some((before, after)) = pattern.split_once("{t}") else { return pattern == file };
    let inner = file.strip_prefix(before).and_then(|rest| rest.strip_suffix(after));
    inner.is_some_and(|time| time.parse::<f64>().is_ok())
}

/// Waits for the end of the child and of everything it started.
fn watch(
    child: &mut Child,
    kept: &Kept,
    unfinished: &mut Option<Unfinished>,
) -> Result<ExitStatus> {
    let mut asked: Option<Instant> = None;
    let failed = |why: io::Error| failed("its exit status is unknown").why(why);
    let status = loop {
        if let Some(status) = child.try_wait().map_err(failed)? {
            break status;
        }
        kept.take(unfinished)?;
        match asked {
            None if interrupt::interrupted() => {
                asked = Some(Instant::now());
                signal(child, libc::SIGTERM);
            }
            Some(since) if since.elapsed() > GRACE => {
                drop(child.kill());
                break child.wait().map_err(failed)?;
            }
            _ => std::thread::sleep(LOOK),
        }
    };
    signal(child, libc::SIGKILL);
    confine::kill_descendants(std::process::id());
    kept.take(unfinished)?;
    Ok(status)
}

/// Sends a signal to the process group of the child.
fn signal(child: &Child, signal: libc::c_int) {
    if let Ok(group) = i32::try_from(child.id()) {
        // SAFETY: a signal to the group whose leader is the child.
        unsafe { libc::kill(-group, signal) };
    }
}

/// The child ended without announcing it.
fn ended(status: ExitStatus, programs: bool) -> Error {
    let signal =
        status.signal().or(status.code().filter(|code| *code > 128).map(|code| code - 128));
    let how = match (signal, status.code()) {
        (Some(libc::SIGKILL), _) if interrupt::interrupted() => {
            return Error::new(Code::Interrupted, "the run was interrupted")
                .why("an FMU did not return, and its process was ended");
        }
        (Some(signal), _) => format!("was killed by signal {signal}"),
        (None, code) => format!("ended with code {}", code.unwrap_or_default()),
    };
    let error = Error::new(Code::Fmu, "an FMU ended the process that computes it")
        .why(format!("the process {how} before the end of the run"))
        .help("--log-fmi-calls shows the last call; the results until then are kept");
    match programs {
        true => error,
        false => error.help(
            "--log-fmi-calls shows the last call; an FMU that starts its tool needs --execution-tool",
        ),
    }
}
