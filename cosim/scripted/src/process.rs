//! The Python process: it imports the module once, and creates an object for each instance.
//!
//! A message is its length as a `u32`, a letter, and that many octets, all little-endian; `host.py`
//! is the other end. Each request has one answer, and the next one is not sent before that has
//! arrived. A process whose object has ended waits for the next instance: a campaign starts Python
//! only once per worker.
//!
//! Nothing here limits the duration of a call. That is up to the importer, and when it ends or is
//! killed, the socket closes and the kernel ends the Python process whatever it is doing.

use std::io::{Error as IoError, ErrorKind, Read, Write};
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, PoisonError};

use cosim_base::{Code, Error, Result};
use cosim_import::scripted::Manifest;

/// Requests.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(u8)]
pub(crate) enum Ask {
    /// Create an object from parameters (JSON).
    Make = b'M',
    /// Step it: the time and the inputs as `f64`; the answer has the outputs.
    Step = b'S',
    /// Return its state as octets.
    Save = b'G',
    /// Create an object from a state.
    Restore = b'R',
    /// The object is no longer needed; the answer comes when its process has ended.
    End = b'E',
}

const DONE: u8 = b'.';
/// The class raised an exception or returned something wrong; the object still exists.
const FAILED: u8 = b'!';

/// Octets of length and letter.
const HEAD: usize = 5;
/// Maximum size of a message in octets.
const MOST: usize = 1 << 30;

/// Numeric libraries start a thread per core by default: too many when runs share the cores, and
/// results may depend on the number of threads.
const SINGLE: [&str; 3] = ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"];

/// Processes without an object, by the resources whose module they have imported.
static IDLE: Mutex<Vec<(PathBuf, Process)>> = Mutex::new(Vec::new());

/// A Python process.
pub(crate) struct Process {
    stream: UnixStream,
    child: Child,
    message: Vec<u8>,
    /// It answers.
    sound: bool,
}

impl Process {
    /// A process that has imported the module in these resources.
    pub(crate) fn of(resources: &Path, manifest: &Manifest) -> Result<Self> {
        let mut idle = IDLE.lock().unwrap_or_else(PoisonError::into_inner);
        let place = idle.iter().position(|(folder, _)| folder == resources);
        let found = place.map(|place| idle.swap_remove(place).1);
        drop(idle);
        // It may have been killed meanwhile.
        if let Some(mut process) = found
            && matches!(process.child.try_wait(), Ok(None))
        {
            return Ok(process);
        }
        Self::start(resources, manifest)
    }

    /// Keeps it for the next instance with the same resources.
    pub(crate) fn release(mut self, resources: &Path) {
        if self.sound && self.ask(Ask::End, &[]).is_ok() {
            let mut idle = IDLE.lock().unwrap_or_else(PoisonError::into_inner);
            idle.push((resources.to_owned(), self));
        }
    }

    /// Ends processes without an object.
    pub(crate) fn forget_all() {
        IDLE.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }

    fn start(resources: &Path, manifest: &Manifest) -> Result<Self> {
        let unstarted = |why: IoError| manifest.unstarted(why);
        let (ours, theirs) = UnixStream::pair().map_err(unstarted)?;
        // What the class prints must not appear among the results of the importer.
        let printed = std::io::stderr().as_fd().try_clone_to_owned().map_err(unstarted)?;
        let mut command = Command::new(manifest.python());
        command.args(["-P", "-B", "-u"]).arg(Manifest::host(resources)).arg(resources);
        command.env("PYTHONHASHSEED", "0");
        for name in SINGLE.into_iter().filter(|name| std::env::var_os(name).is_none()) {
            command.env(name, "1");
        }
        command.stdin(OwnedFd::from(theirs)).stdout(Stdio::from(printed));
        // Ctrl-C at a terminal is meant for the process that the user started.
        let child = command.process_group(0).spawn().map_err(unstarted)?;
        let mut process = Self { stream: ours, child, message: Vec::new(), sound: true };
        process.answer().map(drop)?;
        Ok(process)
    }

    /// Sends a request, and returns the answer.
    pub(crate) fn ask(&mut self, what: Ask, parts: &[&[u8]]) -> Result<&[u8]> {
        if let Err(why) = self.send(what, parts) {
            return Err(self.lost(&why));
        }
        self.answer()
    }

    fn send(&mut self, what: Ask, parts: &[&[u8]]) -> std::io::Result<()> {
        let length: usize = parts.iter().map(|part| part.len()).sum();
        let size = u32::try_from(length).ok().filter(|_| length < MOST);
        let size = size.ok_or_else(|| IoError::new(ErrorKind::InvalidData, "it is too large"))?;
        self.message.clear();
        self.message.extend_from_slice(&size.to_le_bytes());
        self.message.push(what as u8);
        parts.iter().for_each(|part| self.message.extend_from_slice(part));
        self.stream.write_all(&self.message)
    }

    fn answer(&mut self) -> Result<&[u8]> {
        let letter = match self.receive() {
            Ok(letter) => letter,
            Err(why) => return Err(self.lost(&why)),
        };
        if letter == DONE {
            return Ok(self.message.get(HEAD..).unwrap_or_default());
        }
        self.sound &= letter == FAILED;
        let text = String::from_utf8_lossy(self.message.get(HEAD..).unwrap_or_default());
        Err(Error::new(Code::Fmu, text))
    }

    /// Reads a message, which usually arrives as a whole; returns its letter.
    fn receive(&mut self) -> std::io::Result<u8> {
        self.message.resize(4096, 0);
        let (mut have, mut need) = (0, HEAD);
        while have < need {
            let Some(buffer) = self.message.get_mut(have..) else { break };
            match self.stream.read(buffer) {
                Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
                Ok(count) => have += count,
                Err(why) if why.kind() == ErrorKind::Interrupted => {}
                Err(why) => return Err(why),
            }
            if let (HEAD, Some(head)) = (need, self.message[..have].first_chunk::<4>()) {
                let length = u32::from_le_bytes(*head) as usize;
                if length >= MOST {
                    let why = format!("{length} octets are not a message");
                    return Err(IoError::new(ErrorKind::InvalidData, why));
                }
                need += length;
                self.message.resize(need.max(self.message.len()), 0);
            }
        }
        self.message.truncate(need);
        Ok(self.message.get(HEAD - 1).copied().unwrap_or_default())
    }

    fn lost(&mut self, why: &IoError) -> Error {
        self.sound = false;
        let error = Error::new(Code::Lost, "the Python process is gone");
        let gone = matches!(why.kind(), ErrorKind::UnexpectedEof | ErrorKind::BrokenPipe);
        match gone.then(|| self.child.wait()) {
            Some(Ok(status)) => error.why(format!("it ended: {status}")),
            _ => error.why(why),
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // The object, if there is one, ends with the socket; the process then has nothing to do.
        drop(self.stream.shutdown(std::net::Shutdown::Both));
        // If it has already ended, there is nothing to kill.
        drop(self.child.kill());
        drop(self.child.wait());
    }
}
