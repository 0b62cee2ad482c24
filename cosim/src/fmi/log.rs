//! The messages of one instance: the newest are kept for the error that may follow.

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

const KEPT: usize = 20;

/// Where the logger callback writes. An FMU may log from a thread of its own, hence the lock.
#[derive(Default)]
pub(super) struct Log(Mutex<VecDeque<String>>);

impl Log {
    pub(super) fn push(&self, line: String) {
        let mut lines = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if lines.len() == KEPT {
            lines.pop_front();
        }
        lines.push_back(line);
    }

    /// The kept lines, oldest first; the log is empty afterwards.
    pub(super) fn take(&self) -> Vec<String> {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .drain(..)
            .collect()
    }
}
