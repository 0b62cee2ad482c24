//! Messages of FMUs for somebody who passes them on: who hosts a system as one FMU hands them to
//! its own importer's logger.
//!
//! They wait until the call that caused them is over. So they are handed on by the thread that
//! called, also when an FMU logs from a thread of its own.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use super::status::RawStatus;

/// Messages kept at most; an FMU may log without end.
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

/// Where messages wait.
#[derive(Debug, Default)]
pub struct Mailbox {
    /// Whether there are some: looking costs nothing.
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

    /// All messages since this was asked last, in their order.
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
