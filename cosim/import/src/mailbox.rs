//! Messages of FMUs for a caller that passes them on: the host of a system that is exported as one
//! FMU passes them to the logger of its own importer.
//!
//! They wait until the call that caused them has returned, so that the calling thread passes them
//! on, even if an FMU logs from its own thread.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use super::status::RawStatus;

/// Maximum number of messages kept; an FMU may log without end.
const MOST: usize = 10_000;

/// A message of an instance.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Message {
    /// Name of the instance.
    pub instance: String,
    /// `fmi2Status`.
    pub status: i32,
    /// The FMU's own category.
    pub category: String,
    /// The text, rendered.
    pub text: String,
}

/// The queue of messages.
#[derive(Debug, Default)]
pub struct Mailbox {
    /// Whether there are any: checking costs nothing.
    waiting: AtomicBool,
    messages: Mutex<Vec<Message>>,
}

impl Mailbox {
    pub(super) fn put(&self, instance: &str, status: RawStatus, category: &str, text: &str) {
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        self.waiting.store(true, Ordering::Release);
        if messages.len() < MOST {
            let (category, text) = (category.to_owned(), text.to_owned());
            messages.push(Message { instance: instance.to_owned(), status, category, text });
        }
    }

    /// All messages since the last call, in order.
    #[inline]
    pub fn take(&self) -> Vec<Message> {
        if self.waiting.load(Ordering::Acquire) { self.take_all() } else { Vec::new() }
    }

    #[cold]
    fn take_all(&self) -> Vec<Message> {
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        self.waiting.store(false, Ordering::Release);
        std::mem::take(&mut *messages)
    }
}
