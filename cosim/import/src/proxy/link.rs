//! The library's end: starts the program and sends requests to it.
//!
//! The program is in the FMU's resources, which may be on a file system that does not allow
//! execution, and unpacking may have lost its executable flag: it is therefore run from memory.

use std::fs::File;
use std::io::{ErrorKind, Write};
use std::net::Shutdown;
use std::os::fd::{AsRawFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rustix::fs::{MemfdFlags, memfd_create};

use super::frames::{Reply, Request, SILENCE, read, write};
use super::manifest::program;
use cosim_base::error::{Code, Error, Result};

/// How long the program may take to end before it is killed.
const GRACE: Duration = Duration::from_millis(1500);

/// The program process of an instance.
pub struct Link {
    stream: UnixStream,
    /// `None` in tests.
    child: Option<Child>,
}

impl Link {
    /// Starts the program in these resources.
    pub fn start(resources: &Path) -> Result<Self> {
        let file = program(resources)?;
        let unstarted = |why: std::io::Error| {
            Error::new(Code::Session, "the program in the FMU's resources cannot be started")
                .at(&file)
                .why(why)
        };
        let image = in_memory(&file).map_err(unstarted)?;
        let (ours, theirs) = UnixStream::pair().map_err(unstarted)?;
        ours.set_read_timeout(Some(SILENCE)).map_err(unstarted)?;
        ours.set_write_timeout(Some(SILENCE)).map_err(unstarted)?;
        let child = Command::new(format!("/proc/self/fd/{}", image.as_raw_fd()))
            .arg0("cosim")
            .arg("remote")
            .stdin(OwnedFd::from(theirs))
            .stdout(Stdio::null())
            // Ctrl-C at a terminal is meant for the process that the user started.
            .process_group(0)
            .spawn()
            .map_err(unstarted)?;
        Ok(Self { stream: ours, child: Some(child) })
    }

    /// With a test that serves the other end of `stream`.
    #[doc(hidden)]
    pub fn over(stream: UnixStream) -> Self {
        Self { stream, child: None }
    }

    /// Sends a request, and waits for the answer.
    pub fn ask(&mut self, request: &Request) -> Result<Reply> {
        write(&mut self.stream, request).map_err(|why| self.broken(&why))?;
        loop {
            match read(&mut self.stream) {
                Ok(Reply::Working) => {}
                Ok(reply) => return Ok(reply),
                Err(why) => return Err(self.broken(&why)),
            }
        }
    }

    fn broken(&mut self, why: &std::io::Error) -> Error {
        let error = Error::new(Code::Lost, "the process that talks to the workers is gone");
        let silent = matches!(why.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut);
        match self.child.as_mut().map(Child::try_wait) {
            Some(Ok(Some(status))) => error.why(format!("it ended: {status}")),
            _ if silent => error.why(format!("it was silent for {} s", SILENCE.as_secs())),
            _ => error.why(why),
        }
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        // The program ends when the socket is closed.
        let _ = self.stream.shutdown(Shutdown::Both);
        let Some(child) = &mut self.child else {
            return;
        };
        let begun = Instant::now();
        while begun.elapsed() < GRACE {
            match child.try_wait() {
                Ok(None) => std::thread::sleep(Duration::from_millis(2)),
                // The importer may have waited for all of its children.
                Ok(Some(_)) | Err(_) => return,
            }
        }
        let _ = child.kill();
        let _ = child.wait();
    }
}

/// The content of the file as an executable file in memory.
fn in_memory(path: &Path) -> std::io::Result<File> {
    let mut content = File::open(path)?;
    let flags = MemfdFlags::CLOEXEC;
    // Kernels before 6.3 do not know the flag, and always allow execution.
    let image = memfd_create("cosim", flags | MemfdFlags::EXEC)
        .or_else(|_| memfd_create("cosim", flags))?;
    let mut image = File::from(image);
    std::io::copy(&mut content, &mut image)?;
    image.flush()?;
    Ok(image)
}
