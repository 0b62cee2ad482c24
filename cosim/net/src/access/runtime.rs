//! The threads on which Zenoh works, chosen when the program starts.
//!
//! By default, one thread waits for sockets and wakes another that receives, which makes a step a
//! quarter slower; here one thread does both. If the same thread also sends, a callback that sends
//! more than the queues hold waits for itself. But TLS requires that: the state of a connection is
//! used for sending and for receiving without a lock (zenoh-link-tls 1.10,
//! <https://github.com/eclipse-zenoh/zenoh/issues/2557>); two threads corrupt it sooner or later,
//! one does not. Connections are always closed by another thread once they are no longer used: that
//! takes seconds if a cable is cut.

use cosim_base::error::{Code, Error, Result};

/// The threads of Zenoh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Threads {
    /// One thread for everything.
    One,
    /// One thread that receives and one that sends: for programs that send so much that queues fill
    /// up.
    SenderApart,
}

/// Zenoh reads it on first use.
const VARIABLE: &str = "ZENOH_RUNTIME";

impl Threads {
    fn value(self) -> &'static str {
        match self {
            Self::One => "(tx:(handover:app),rx:(handover:app),acc:(handover:app))",
            Self::SenderApart => "(rx:(handover:app),acc:(handover:app))",
        }
    }

    /// The environment variable to set while there is no other thread, with its value; `None` if
    /// the user has already set it. A value that one of our programs set for itself does not apply
    /// to its children.
    pub fn setting(self) -> Option<(&'static str, &'static str)> {
        let ours = |said: &str| [Self::One, Self::SenderApart].iter().any(|t| t.value() == said);
        match std::env::var(VARIABLE) {
            Ok(said) if !ours(&said) => None,
            _ => Some((VARIABLE, self.value())),
        }
    }
}

/// Fails if Zenoh uses several threads.
pub(super) fn is_one_thread() -> Result<()> {
    let wanted = Threads::One.value();
    match std::env::var(VARIABLE) {
        Ok(said) if said == wanted => Ok(()),
        said => Err(Error::new(Code::Session, "TLS needs one thread for all of Zenoh")
            .why(format!("{VARIABLE} is {}", said.unwrap_or("not set".to_owned())))
            .help(format!("unset it for cosim; your own program must set {wanted}"))),
    }
}
