//! The program's end: the command that the library of a remote FMU starts.

use std::io::ErrorKind;
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::{Reached, Remote};
use cosim_base::error::{Code, Error, Result};
use cosim_import::proxy::frames::{Reply, Request, SIGN, read, write};

/// How long work in progress may continue when nothing waits for it any more.
const GRACE: Duration = Duration::from_secs(1);

/// The socket, and whether work is in progress.
struct Desk {
    stream: Mutex<UnixStream>,
    works: AtomicBool,
}

impl Desk {
    fn say(&self, reply: &Reply) -> std::io::Result<()> {
        write(&mut *self.stream.lock().unwrap_or_else(PoisonError::into_inner), reply)
    }
}

/// Serves the library at the other end of `stream` until it is gone.
pub fn serve(mut stream: UnixStream) -> Result<()> {
    let broken = |why| Error::new(Code::Session, "the library of the FMU is gone").why(why);
    let writer = stream.try_clone().map_err(broken)?;
    let desk = Arc::new(Desk { stream: Mutex::new(writer), works: AtomicBool::new(false) });
    let (signs, watched) = (desk.clone(), stream.try_clone().map_err(broken)?);
    std::thread::spawn(move || watch(&signs, &watched));
    let mut remote = None;
    loop {
        let request = match read(&mut stream) {
            Ok(request) => request,
            Err(why) if why.kind() == ErrorKind::UnexpectedEof => break,
            Err(why) => return Err(broken(why)),
        };
        desk.works.store(true, Ordering::Relaxed);
        let reply = obey(&mut remote, request).unwrap_or_else(|error| Reply::Lost(error.line()));
        desk.works.store(false, Ordering::Relaxed);
        desk.say(&reply).map_err(broken)?;
    }
    if let Some(remote) = remote {
        remote.end();
    }
    Ok(())
}

fn obey(remote: &mut Option<Remote>, request: Request) -> Result<Reply> {
    match (request, remote) {
        (Request::Make { resources, name, debug }, remote) => {
            *remote = Some(make(&resources, &name, debug)?);
            Ok(Reply::Done(Default::default(), Vec::new(), Vec::new()))
        }
        (Request::Calls(asks), Some(remote)) => {
            let (outcome, messages, notes) = remote.ask(asks)?;
            Ok(Reply::Done(outcome, messages, notes))
        }
        (Request::Calls(_), None) => {
            Err(Error::new(Code::Protocol, "calls came before there is an instance"))
        }
    }
}

fn make(resources: &Path, name: &str, debug: bool) -> Result<Remote> {
    Remote::make(resources, name, debug, &Reached::of(resources)?)
}

/// Signals regularly that work is in progress; ends everything when the library is gone.
fn watch(desk: &Desk, stream: &UnixStream) {
    let pause = Timespec { tv_sec: 0, tv_nsec: SIGN.subsec_nanos().into() };
    loop {
        let mut polled = [PollFd::from_borrowed_fd(stream.as_fd(), PollFlags::RDHUP)];
        let found = poll(&mut polled, Some(&pause));
        let gone = PollFlags::RDHUP | PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL;
        if found.is_ok() && polled[0].revents().intersects(gone) {
            std::thread::sleep(GRACE);
            // Workers stop their work for a session that is gone.
            std::process::exit(0);
        }
        if desk.works.load(Ordering::Relaxed) && desk.say(&Reply::Working).is_err() {
            std::process::exit(0);
        }
    }
}
