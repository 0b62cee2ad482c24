//! The threads on which Zenoh works: one in each process, if its program says so at its beginning.
//!
//! Usually one waits for sockets and wakes another that receives, which costs a step a quarter more.
//! And the state of a TLS connection is used for sending and for receiving without a lock
//! (zenoh-link-tls 1.10; <https://github.com/eclipse-zenoh/zenoh/issues/2557>): by two threads it is
//! damaged sooner or later, by one it is not. So there is no TLS without it.

use crate::error::{Code, Error, Result};

/// The variable in which Zenoh reads it when it is used first, and what makes it one thread.
pub const ONE_THREAD: (&str, &str) = (
    "ZENOH_RUNTIME",
    "(tx:(handover:app),rx:(handover:app),acc:(handover:app),net:(handover:app))",
);

/// Refuses to go on with several threads.
pub(super) fn is_one_thread() -> Result<()> {
    let (name, wanted) = ONE_THREAD;
    match std::env::var(name) {
        Ok(said) if said == wanted => Ok(()),
        said => Err(Error::new(Code::Session, "TLS needs one thread for all of Zenoh")
            .why(format!("{name} is {}", said.unwrap_or("not set".to_owned())))
            .help(format!("unset it for cosim; a program of one's own sets {wanted}"))),
    }
}
