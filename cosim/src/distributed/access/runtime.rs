//! The threads on which Zenoh works, as the program says at its beginning.
//!
//! Usually one waits for sockets and wakes another that receives, which costs a step a quarter more;
//! here one does both. If it is the one that sends, too, a callback that sends more than the queues
//! hold waits for itself. But TLS needs that: the state of a connection is used for sending and for
//! receiving without a lock (zenoh-link-tls 1.10, <https://github.com/eclipse-zenoh/zenoh/issues/2557>);
//! by two threads it is damaged sooner or later, by one it is not. Connections are closed by another
//! one in any case, when nobody uses them any more: that takes seconds where a cable is cut.

use crate::error::{Code, Error, Result};

/// Which threads there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Threads {
    /// One for all.
    One,
    /// One that receives and one that sends: for who tells so much that queues are full.
    SenderApart,
}

/// Zenoh reads it when it is used first.
const VARIABLE: &str = "ZENOH_RUNTIME";

impl Threads {
    fn value(self) -> &'static str {
        match self {
            Self::One => "(tx:(handover:app),rx:(handover:app),acc:(handover:app))",
            Self::SenderApart => "(rx:(handover:app),acc:(handover:app))",
        }
    }

    /// The variable to be set, and to what, while there is no other thread; nothing if somebody
    /// else has set it. What a program of ours has set for itself is not for those that it starts.
    pub fn setting(self) -> Option<(&'static str, &'static str)> {
        let ours = |said: &str| [Self::One, Self::SenderApart].iter().any(|t| t.value() == said);
        match std::env::var(VARIABLE) {
            Ok(said) if !ours(&said) => None,
            _ => Some((VARIABLE, self.value())),
        }
    }
}

/// Refuses to go on with several threads.
pub(super) fn is_one_thread() -> Result<()> {
    let wanted = Threads::One.value();
    match std::env::var(VARIABLE) {
        Ok(said) if said == wanted => Ok(()),
        said => Err(Error::new(Code::Session, "TLS needs one thread for all of Zenoh")
            .why(format!("{VARIABLE} is {}", said.unwrap_or("not set".to_owned())))
            .help(format!("unset it for cosim; a program of one's own sets {wanted}"))),
    }
}
