//! A run in real time that responds to the keyboard and to the live page.
//!
//! Keys, if stdin is a terminal: space pauses and continues, s makes one output interval and
//! pauses, q ends the run. The clock of `--real-time` stops during a pause. Both are checked at
//! output instants, where they do not affect what is computed.

mod keyboard;

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use cosim::live::{Playing, Request, Server};
use cosim::observe::Stop;
use cosim::scenario::Injected;
use cosim::{Code, Controls, Error, Manipulator, Result, Step, System, Time, files};
use cosim::{Overruns, Pace};

use self::keyboard::{Key, Keyboard};
use super::{interrupt, messages};

/// Options for live viewers.
#[derive(Args)]
#[command(next_help_heading = "Watching")]
pub(crate) struct Watching {
    /// Serve a page that shows the run in progress, and Foxglove's WebSocket protocol, at
    /// ADDRESS:PORT, or at a free port that only this machine can reach. The run goes in real time,
    /// unless --real-time or the page says otherwise
    #[arg(long, value_name = "ADDRESS:PORT", num_args = 0..=1, default_missing_value = "127.0.0.1:0",
          require_equals = true)]
    live: Option<SocketAddr>,
    /// Start paused: the page or a key starts the run
    #[arg(long, requires = "live")]
    paused: bool,
}

impl Watching {
    pub(crate) fn wanted(&self) -> bool {
        self.live.is_some()
    }

    /// The server, if requested, and the initial state of the run.
    pub(crate) fn open(&self, speed: Option<f64>) -> Result<(Option<Server>, Playing)> {
        let Some(address) = self.live else {
            return Ok((None, Playing { paused: false, speed }));
        };
        let playing = Playing { paused: self.paused, speed: speed.or(Some(1.0)) };
        let server = Server::listen(address, playing.clone())?;
        messages::info(&format!("the page is at {}", server.page()));
        messages::info(&format!("Foxglove and Lichtblick: {}", server.foxglove()));
        if !address.ip().is_loopback() {
            messages::note("anyone who knows the address can control the run: it is not encrypted");
        }
        Ok((Some(server), playing))
    }
}

/// Interval at which requests are checked.
const LOOK: Duration = Duration::from_millis(20);
/// How long to wait for a request at a time during a pause.
const WAIT: Duration = Duration::from_millis(50);

/// Pace, keyboard and page.
pub(crate) struct Live {
    pace: Pace,
    keyboard: Option<Keyboard>,
    server: Option<Server>,
    playing: Playing,
    injected: Injected,
    /// The file for injected faults.
    record: PathBuf,
    looked: Option<Instant>,
    start: Time,
    interval: Step,
    /// The next output instant.
    next: Time,
    now: Time,
}

impl Live {
    /// Injected faults are written to the file `record`.
    pub(crate) fn new(server: Option<Server>, playing: Playing, record: PathBuf) -> Self {
        Self {
            pace: Pace::new(playing.speed.unwrap_or(1.0)),
            keyboard: Keyboard::open(),
            server,
            playing,
            injected: Injected::default(),
            record,
            looked: None,
            start: Time::ZERO,
            interval: Step::whole(Time::from_ns(1)),
            next: Time::ZERO,
            now: Time::ZERO,
        }
    }

    /// Whether there is anything to do.
    pub(crate) fn wanted(&self) -> bool {
        self.playing.speed.is_some() || self.listens()
    }

    fn listens(&self) -> bool {
        self.keyboard.is_some() || self.server.is_some()
    }

    pub(crate) fn server(&self) -> Option<&Server> {
        self.server.as_ref()
    }

    /// Number of late instants, if the run had a pace.
    pub(crate) fn overruns(&self) -> Option<Overruns> {
        Some(self.pace.overruns()).filter(|overruns| overruns.instants > 0)
    }

    /// The scenario file that repeats what was done to the run, if anything was.
    pub(crate) fn record(&self) -> Option<&PathBuf> {
        self.injected.text().map(|_| &self.record)
    }

    /// Shows clients how the run ended.
    pub(crate) fn end(&mut self, text: &str) {
        if let Some(server) = self.server.take() {
            server.end(self.now, text);
        }
    }

    /// Shows the keys that work in a pause.
    fn prompt(&self) {
        if self.keyboard.is_some() {
            let now = self.now;
            messages::info(&format!("paused at t = {now}; space: continue, s: step, q: quit"));
        }
    }

    fn note(&self, text: &str) {
        if let Some(server) = &self.server {
            server.note(self.now, text);
        }
    }

    fn update_clients(&self) {
        if let Some(server) = &self.server {
            server.update(self.now, &self.playing);
        }
    }

    /// The next request; in a pause, waits a while for one.
    fn key(&self) -> Option<Key> {
        let wait = if self.playing.paused { WAIT } else { Duration::ZERO };
        let (keys, page) = match self.server {
            Some(_) => (Duration::ZERO, wait),
            None => (wait, Duration::ZERO),
        };
        let key = self.keyboard.as_ref().and_then(|keyboard| keyboard.key(keys));
        key.or_else(|| self.server.as_ref()?.request(page).map(Key::Request))
    }

    /// Handles requests, in a pause until it ends; whether the run is to end.
    fn listen(&mut self, controls: &mut Controls<'_>) -> Result<bool> {
        loop {
            let request = match self.key() {
                Some(Key::Quit) => return Ok(true),
                Some(Key::Turn) if self.playing.paused => Request::Play,
                Some(Key::Turn) => Request::Pause,
                Some(Key::Request(request)) => request,
                Some(Key::Other) => continue,
                // Ctrl-C: the observer that waits for it ends the run.
                None if self.playing.paused && !interrupt::interrupted() => continue,
                None => return Ok(false),
            };
            match request {
                Request::Pause if !self.playing.paused => {
                    self.playing.paused = true;
                    self.update_clients();
                    self.note("paused");
                    self.prompt();
                }
                Request::Play if self.playing.paused => {
                    self.playing.paused = false;
                    self.update_clients();
                    self.note("continued");
                    return Ok(false);
                }
                Request::Pause | Request::Play => (),
                Request::Step => {
                    self.playing.paused = true;
                    self.update_clients();
                    return Ok(false);
                }
                Request::Speed(factor) => {
                    self.playing.speed = factor;
                    self.pace.change(factor, self.now);
                    self.update_clients();
                }
                Request::Inject(fault) => self.inject(&fault, controls)?,
            }
        }
    }

    fn inject(
        &mut self,
        fault: &serde_json::Map<String, serde_json::Value>,
        controls: &mut Controls<'_>,
    ) -> Result<()> {
        let Some(server) = &self.server else { return Ok(()) };
        match self.injected.inject(fault, self.now, controls) {
            Ok(window) => server.fault(self.now, &window),
            Err(wrong) => {
                server.error(self.now, &wrong);
                return Ok(());
            }
        }
        let text = self.injected.text().unwrap_or_default();
        files::replace(&self.record, text.as_bytes()).map_err(|e| {
            Error::new(Code::Output, "the injected faults cannot be saved").at(&self.record).why(e)
        })
    }
}

impl Manipulator for Live {
    fn start(&mut self, system: &System, resumed: Option<Time>) -> Result<(), Error> {
        (self.start, self.interval) = (system.start_time(), system.output_interval());
        self.next =
            resumed.map_or(self.start, |at| self.start + self.interval.after(at - self.start));
        self.now = resumed.unwrap_or(self.start);
        self.pace.start(system, resumed)?;
        if self.playing.speed.is_none() {
            self.pace.change(None, self.now);
        }
        Ok(())
    }

    fn next(&self) -> Option<Time> {
        self.listens().then_some(self.next).into_iter().chain(self.pace.next()).min()
    }

    fn act(&mut self, now: Time, controls: &mut Controls<'_>) -> Result<()> {
        self.now = now;
        if self.listens() && self.next <= now {
            self.next = self.start + self.interval.after(now - self.start);
            let begun = Instant::now();
            let due = self.looked.is_none_or(|looked| begun - looked >= LOOK);
            if self.playing.paused || due {
                self.looked = Some(begun);
                if self.playing.paused {
                    self.update_clients();
                    self.prompt();
                }
                if self.listen(controls)? {
                    controls.end(Stop::Interrupted);
                    return Ok(());
                }
                self.pace.paused(begun.elapsed());
            }
        }
        match self.pace.next().is_some_and(|next| next <= now) {
            true => self.pace.act(now, controls),
            false => Ok(()),
        }
    }
}
