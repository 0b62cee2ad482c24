//! Single key presses in the terminal.

use std::io::IsTerminal;
use std::time::Duration;

use cosim::live::Request;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::termios::{LocalModes, OptionalActions, Termios, tcgetattr, tcgetpgrp, tcsetattr};

/// The terminal of stdin, set to deliver single keys.
pub(super) struct Keyboard {
    /// Its previous settings.
    modes: Termios,
}

/// The meaning of a key.
pub(super) enum Key {
    Request(Request),
    /// Pause, or continue.
    Turn,
    Quit,
    Other,
}

impl Keyboard {
    /// `None` if stdin is not a terminal, or belongs to another process.
    pub(super) fn open() -> Option<Self> {
        let stdin = std::io::stdin();
        if !stdin.is_terminal() || tcgetpgrp(&stdin).ok()? != rustix::process::getpgrp() {
            return None;
        }
        let modes = tcgetattr(&stdin).ok()?;
        let mut keys = modes.clone();
        keys.local_modes.remove(LocalModes::ICANON | LocalModes::ECHO);
        tcsetattr(&stdin, OptionalActions::Now, &keys).ok()?;
        Some(Self { modes })
    }

    /// The next key; waits at most this long.
    pub(super) fn key(&self, wait: Duration) -> Option<Key> {
        let stdin = std::io::stdin();
        let wait = Timespec { tv_sec: 0, tv_nsec: i64::from(wait.subsec_nanos()) };
        let mut ready = [PollFd::new(&stdin, PollFlags::IN)];
        if poll(&mut ready, Some(&wait)).ok()? == 0 {
            return None;
        }
        let mut key = [0];
        // A terminal that is gone delivers no more keys.
        let read = rustix::io::read(&stdin, &mut key).ok()?;
        Some(match key[0] {
            _ if read != 1 => Key::Quit,
            b'q' => Key::Quit,
            b's' => Key::Request(Request::Step),
            b' ' => Key::Turn,
            _ => Key::Other,
        })
    }
}

impl Drop for Keyboard {
    fn drop(&mut self) {
        // If the terminal is gone, there is no channel left to report it.
        let _ = tcsetattr(std::io::stdin(), OptionalActions::Now, &self.modes);
    }
}
