//! Messages of FMUs for somebody who passes them on: who hosts a system as one FMU hands them to
//! its own importer's logger.
//!
//! They wait until the call that caused them is over. So they are handed on by the thread that
//! called, also when an FMU logs from a thread of its own.

use std::sync::{Mutex, PoisonError};

use super::status::RawStatus;

/// Messages kept at most; an FMU may log without end.
const MOST: usize = 10_000;

/// A message of an instance.
#[derive(Debug, Clone, PartialEq, Eq)]
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
pub struct Mailbox(Mutex<Vec<Message>>);

impl Mailbox {
    pub(super) fn put(&self, instance: &str, status: RawStatus, category: &str, text: &str) {
        let mut messages = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if messages.len() < MOST {
            let (category, text) = (category.to_owned(), text.to_owned());
            messages.push(Message { instance: instance.to_owned(), status, category, text });
        }
    }

    /// All messages since this was asked last, in their order.
    pub fn take(&self) -> Vec<Message> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
