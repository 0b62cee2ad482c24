//! Watches a run from another process.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use zenoh::Wait;

use super::access::members::Role;
use super::access::rights;
use super::access::session::Access;
use super::keys;
use super::status::Status;
use cosim_base::error::{Code, Error, Result};

/// A run that is silent for this long is gone: it publishes its status four times a second.
const PATIENCE: Duration = Duration::from_secs(10);

/// Shows the status of the run at `access` until it ends, or until `ended` returns true.
pub fn watch(
    access: &Access,
    ended: &dyn Fn() -> bool,
    show: &mut dyn FnMut(&Status) -> Result<()>,
) -> Result<()> {
    let session = access.dial()?;
    rights::ask(&session, access, Role::Observer)?;
    let (news, inbox) = channel();
    let _subscriber = session
        .declare_subscriber(keys::open("*/status"))
        .callback(move |sample| {
            let _ = news.send(serde_json::from_slice::<Status>(&sample.payload().to_bytes()));
        })
        .wait()
        .map_err(|why| Error::new(Code::Session, "the session failed").why(why))?;
    let mut heard = Instant::now();
    while !ended() {
        match inbox.recv_timeout(Duration::from_millis(200)) {
            Ok(Ok(status)) => {
                heard = Instant::now();
                show(&status)?;
                if status.ended {
                    return Ok(());
                }
            }
            Ok(Err(why)) => {
                let what = "the status of the run cannot be understood";
                return Err(Error::new(Code::Protocol, what)
                    .why(why)
                    .help("do both sides have the same version of cosim?"));
            }
            Err(RecvTimeoutError::Timeout) if heard.elapsed() < PATIENCE => {}
            Err(_) => {
                let silent = format!("nothing was received for {} s", PATIENCE.as_secs());
                return Err(Error::new(Code::Lost, "the run is gone").why(silent));
            }
        }
    }
    Ok(())
}
