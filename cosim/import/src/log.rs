//! The messages of one instance: the newest are kept for a possible error, and all are passed on
//! immediately if a [`Trace`] requests them.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use super::mailbox::Mailbox;
use super::status::{self, RawStatus};
use super::trace::Trace;

const KEPT: usize = 20;

/// Where the logger callback writes. An FMU may log from a thread of its own, hence the lock.
#[derive(Default)]
pub(super) struct Log {
    messages: Mutex<Messages>,
    /// The follower of the messages, and the name of the instance.
    live: Option<(Arc<Trace>, String)>,
    /// The mailbox that passes them on, and the name of the instance.
    mailbox: Option<(Arc<Mailbox>, String)>,
    /// Which changes of the process were reported for the instance, a bit for each kind.
    changed: AtomicU32,
}

#[derive(Default)]
struct Messages {
    newest: VecDeque<String>,
    /// How many older ones were dropped.
    dropped: usize,
}

impl Log {
    pub(super) fn new(
        live: Option<Arc<Trace>>,
        mailbox: Option<Arc<Mailbox>>,
        instance: &str,
    ) -> Self {
        Self {
            messages: Mutex::default(),
            live: live.map(|trace| (trace, instance.to_owned())),
            mailbox: mailbox.map(|mailbox| (mailbox, instance.to_owned())),
            changed: AtomicU32::new(0),
        }
    }

    /// Whether messages were already shown when they arrived.
    pub(super) fn is_live(&self) -> bool {
        self.live.is_some()
    }

    /// Whether a change of this kind is the first of the instance.
    pub(super) fn is_new(&self, kind: u32) -> bool {
        self.changed.fetch_or(1 << kind, Ordering::Relaxed) & (1 << kind) == 0
    }

    /// Adds a message as it is to be shown.
    pub(super) fn push_line(&self, line: &str) {
        self.push(line.to_owned());
    }

    /// Adds a message from the FMU.
    pub(super) fn message(&self, status: RawStatus, category: &str, text: &str) {
        if let Some((mailbox, instance)) = &self.mailbox {
            mailbox.put(instance, status, category, text);
        }
        self.push(format!("{} ({category}): {text}", status::name(status)));
    }

    fn push(&self, line: String) {
        if let Some((trace, instance)) = &self.live {
            trace.message(instance, &line);
        }
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        if messages.newest.len() == KEPT {
            messages.newest.pop_front();
            messages.dropped += 1;
        }
        messages.newest.push_back(line);
    }

    /// The kept messages, oldest first; the log is empty afterwards.
    pub(super) fn take(&self) -> Vec<String> {
        let mut guard = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        let messages = std::mem::take(&mut *guard);
        let note = (messages.dropped > 0)
            .then(|| format!("({} earlier messages are not kept)", messages.dropped));
        note.into_iter().chain(messages.newest).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_are_kept_and_the_rest_is_counted() {
        let log = Log::default();
        for number in 0..25 {
            log.push(number.to_string());
        }
        let lines = log.take();
        assert_eq!((lines.len(), lines[1].as_str()), (KEPT + 1, "5"));
        assert!(lines[0].starts_with("(5 earlier"));
        assert!(log.take().is_empty());
    }
}
