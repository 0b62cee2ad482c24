//! How the coordinator reaches hosts: over Zenoh, or within this process.

use std::time::{Duration, Instant};

use super::process_status::ProcessStatus;
use cosim_base::error::Result;

/// Starts incarnations of groups and carries messages to and from them. An *incarnation* is one
/// host of a group; its generation counts from 1.
pub(crate) trait Fabric {
    /// Starts an incarnation of a group; [`Event::Ready`] reports when it accepts messages.
    fn launch(&mut self, group: usize, generation: u32) -> Result<()>;

    /// Sends a command.
    fn send(&mut self, group: usize, generation: u32, message: &[u8]) -> Result<()>;

    /// The next event; nothing if there is none within `patience`. `awaited` answers are expected:
    /// the first is of little use without the others.
    fn next(&mut self, awaited: usize, patience: Duration) -> Option<Event>;

    /// What is known of an incarnation that is lost or silent, if that can be found out quickly.
    fn inquire(&mut self, group: usize, generation: u32) -> Option<ProcessStatus>;

    /// Abandons an incarnation. It may continue somewhere, but its messages are ignored.
    fn abandon(&mut self, group: usize, generation: u32);

    /// Where a group runs, for messages.
    fn place(&self, group: usize) -> String;
}

/// What a fabric reports.
#[derive(Debug)]
pub(crate) enum Event {
    /// An incarnation accepts messages.
    Ready {
        /// Its group.
        group: usize,
        /// Its generation.
        generation: u32,
    },
    /// An incarnation answered.
    Answer {
        /// Its group.
        group: usize,
        /// The message.
        bytes: Vec<u8>,
        /// When it arrived.
        at: Instant,
    },
    /// An incarnation ended unexpectedly.
    Lost {
        /// Its group.
        group: usize,
        /// Its generation.
        generation: u32,
        /// What is known of the cause.
        why: String,
    },
}
