//! A run that goes by the clock and listens to the keyboard.
//!
//! Keys, when stdin is a terminal: space pauses and goes on, s makes one output interval and
//! pauses, q ends the run. The clock of `--real-time` stands still in a pause.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use cosim::observe::Stop;
use cosim::pace::{Overruns, Pace};
use cosim::{Controls, Error, Manipulator, Result, System, Time};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::termios::{LocalModes, OptionalActions, Termios, tcgetattr, tcgetpgrp, tcsetattr};

use super::messages;

/// The keyboard is looked at so often.
const LOOK: Duration = Duration::from_millis(20);

/// Pace and keyboard.
pub(crate) struct Live {
    pace: Option<Pace>,
    keyboard: Option<Keyboard>,
}

impl Live {
    /// At `factor` times the clock's pace, if that is wanted.
    pub(crate) fn new(factor: Option<f64>) -> Self {
        Self { pace: factor.map(Pace::new), keyboard: Keyboard::open() }
    }

    /// Whether there is anything to do.
    pub(crate) fn wanted(&self) -> bool {
        self.pace.is_some() || self.keyboard.is_some()
    }

    pub(crate) fn overruns(&self) -> Option<Overruns> {
        self.pace.as_ref().map(Pace::overruns)
    }
}

impl Manipulator for Live {
    fn start(&mut self, system: &System, resumed: Option<Time>) -> Result<(), Error> {
        if let Some(keyboard) = &mut self.keyboard {
            keyboard.interval = system.output_interval().rounded();
            keyboard.next = resumed.unwrap_or(system.start_time()) + keyboard.interval;
        }
        self.pace.as_mut().map_or(Ok(()), |pace| pace.start(system, resumed))
    }

    fn next(&self) -> Option<Time> {
        let keyboard = self.keyboard.as_ref().map(|keyboard| keyboard.next);
        let pace = self.pace.as_ref().and_then(Pace::next);
        keyboard.into_iter().chain(pace).min()
    }

    fn act(&mut self, now: Time, controls: &mut Controls<'_>) -> Result<()> {
        if let Some(keyboard) = &mut self.keyboard {
            let begun = Instant::now();
            if keyboard.act(now) {
                controls.end(Stop::Interrupted);
                return Ok(());
            }
            if let Some(pace) = &mut self.pace {
                pace.paused(begun.elapsed());
            }
        }
        match &mut self.pace {
            Some(pace) if pace.next().is_some_and(|next| next <= now) => pace.act(now, controls),
            _ => Ok(()),
        }
    }
}

/// The terminal that stdin is, told to hand over single keys.
struct Keyboard {
    /// As it was before.
    modes: Termios,
    looked: Instant,
    paused: bool,
    interval: Time,
    next: Time,
}

impl Keyboard {
    /// None when stdin is no terminal, or another process has it.
    fn open() -> Option<Self> {
        let stdin = std::io::stdin();
        if !stdin.is_terminal() || tcgetpgrp(&stdin).ok()? != rustix::process::getpgrp() {
            return None;
        }
        let modes = tcgetattr(&stdin).ok()?;
        let mut keys = modes.clone();
        keys.local_modes.remove(LocalModes::ICANON | LocalModes::ECHO);
        tcsetattr(&stdin, OptionalActions::Now, &keys).ok()?;
        let (interval, next) = (Time::ZERO, Time::ZERO);
        Some(Self { modes, looked: Instant::now(), paused: false, interval, next })
    }

    /// Looks for keys, and waits for them in a pause; whether the run is to end.
    fn act(&mut self, now: Time) -> bool {
        if self.next <= now {
            self.next = now + self.interval;
        } else if self.paused {
            // A step is a whole output interval.
            return false;
        }
        if !self.paused && self.looked.elapsed() < LOOK {
            return false;
        }
        self.looked = Instant::now();
        if self.paused {
            messages::tell(&format!("paused at t = {now}; space: go on, s: step, q: quit"));
        }
        loop {
            match self.key() {
                Some(b'q') => return true,
                Some(b's') => {
                    self.paused = true;
                    return false;
                }
                Some(b' ') if self.paused => {
                    self.paused = false;
                    return false;
                }
                Some(b' ') => {
                    self.paused = true;
                    messages::tell(&format!("paused at t = {now}; space: go on, s: step, q: quit"));
                }
                Some(_) => (),
                // Ctrl-C: the observer that waits for it ends the run.
                None if self.paused && !super::interrupt::interrupted() => (),
                None => return false,
            }
        }
    }

    /// The next key; in a pause it is waited for, a while.
    fn key(&self) -> Option<u8> {
        let stdin = std::io::stdin();
        let wait = Timespec { tv_sec: 0, tv_nsec: if self.paused { 50_000_000 } else { 0 } };
        let mut ready = [PollFd::new(&stdin, PollFlags::IN)];
        if poll(&mut ready, Some(&wait)).ok()? == 0 {
            return None;
        }
        let mut key = [0];
        // A terminal that has gone will not say how to go on.
        let read = rustix::io::read(&stdin, &mut key).ok()?;
        Some(if read == 1 { key[0] } else { b'q' })
    }
}

impl Drop for Keyboard {
    fn drop(&mut self) {
        // Nobody is left to be told that the terminal has gone.
        let _ = tcsetattr(std::io::stdin(), OptionalActions::Now, &self.modes);
    }
}
