//! How the coordinator reaches hosts: over Zenoh, or within this process.

use std::time::{Duration, Instant};

use super::process_status::ProcessStatus;
use crate::error::Result;

/// Starts lives of groups and carries messages to and from them. A *life* is one host of a group,
/// counted by its generation from 1.
pub(crate) trait Fabric {
    /// Starts a life of a group; [`Event::Ready`] tells when it can be spoken to.
    fn launch(&mut self, group: usize, generation: u32) -> Result<()>;

    /// Sends a command.
    fn send(&mut self, group: usize, generation: u32, message: &[u8]) -> Result<()>;

    /// What happens next; nothing if nothing happens for so long. So many answers are `awaited`:
    /// there is little use in the first without the others.
    fn next(&mut self, awaited: usize, patience: Duration) -> Option<Event>;

    /// What is known of a life that is lost or silent, if that can be found out soon.
    fn inquire(&mut self, group: usize, generation: u32) -> Option<ProcessStatus>;

    /// Gives a life up. It may go on somewhere, but is not listened to any more.
    fn abandon(&mut self, group: usize, generation: u32);

    /// Where a group is, for people.
    fn place(&self, group: usize) -> String;
}

/// What a fabric tells.
#[derive(Debug)]
pub(crate) enum Event {
    /// A life can be spoken to.
    Ready {
        /// Its group.
        group: usize,
        /// Which life.
        generation: u32,
    },
    /// A life answered.
    Answer {
        /// Its group.
        group: usize,
        /// The message.
        bytes: Vec<u8>,
        /// When it came.
        at: Instant,
    },
    /// A life ended by itself.
    Lost {
        /// Its group.
        group: usize,
        /// Which life.
        generation: u32,
        /// What is known of how.
        why: String,
    },
}
