//! One instance on a worker, driven by the calls of another tool's simulation.
//!
//! It is a run of one group, which is recovered like the groups of a system: every so many steps,
//! the answer includes the state; a new incarnation starts from that state and gets the calls since
//! then again. A step is one message in each direction.

use std::path::Path;
use std::time::{Duration, Instant};

use zenoh::liveliness::LivelinessToken;
use zenoh::{Session, Wait};

use super::access::session::Access;
use super::dispatcher::Dispatcher;
use super::group_handle::GroupHandle;
use super::keys;
use super::net::{Net, refused};
use super::options::Options;
use super::setup::FmuFile;
use super::single::{self, SingleSetup, bytes};
use super::wire::Kind;
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::Time;
use cosim_import::Message;
use cosim_import::calls::{Ask, Given, Outcome};
use cosim_import::proxy::manifest::Manifest;

/// How to reach a remote instance and keep it available.
#[derive(Debug, Clone)]
pub struct Reached {
    /// Where workers connect to us: the first endpoint that is free.
    pub accesses: Vec<Access>,
    /// The worker that computes it, if it is connected.
    pub worker: Option<String>,
    /// How long to wait for a worker.
    pub wait: Duration,
    /// How long an answer may take.
    pub deadline: Duration,
    /// The state is saved after this many steps; `None`: never.
    pub save_every: Option<u64>,
}

/// The instance.
pub struct Remote {
    dispatcher: Dispatcher<'static>,
    /// Its set-up; calls before the first step are added.
    setup: SingleSetup,
    save_every: Option<u64>,
    stepping: bool,
    steps: u64,
    /// Where workers connect to us.
    endpoint: String,
    /// Why it can no longer be used.
    lost: Option<String>,
    /// Workers stop their work for this run when this is dropped.
    _running: LivelinessToken,
    session: Session,
}

impl Remote {
    /// Makes an instance called `name` of the FMU described by the resources in `folder`.
    pub fn make(folder: &Path, name: &str, debug: bool, reached: &Reached) -> Result<Self> {
        let manifest = Manifest::read(folder)?;
        let (session, endpoint) = listen(&reached.accesses)?;
        let run = session.zid().to_string();
        let running = session.liveliness().declare_token(keys::running(&run)).wait();
        let running = running.map_err(refused)?;
        let held = manifest.held(folder);
        let files = held.map(|file| (manifest.sha256.clone(), file)).into_iter().collect();
        let mut net = Net::new(session.clone(), &run, vec![files])?;
        net.settle(reached.worker.iter().cloned().collect(), reached.wait);
        let options = Options {
            save_every: None,
            deadline: reached.deadline,
            launch_deadline: reached.wait.max(reached.deadline),
            give_up: reached.wait,
            ..Options::default()
        };
        let file = FmuFile { sha256: manifest.sha256.clone(), name: manifest.fmu.clone() };
        let setup =
            SingleSetup { name: name.to_owned(), file, debug, before: Vec::new(), state: None };
        let (body, tables) = setup.encode()?;
        let handle = GroupHandle::new(Kind::Single, body, tables);
        let dispatcher =
            Dispatcher::new(vec![(name.to_owned(), handle)], Box::new(net), options, Time::ZERO);
        let save_every = reached.save_every.filter(|_| manifest.can_save);
        let mut remote = Self {
            dispatcher,
            setup,
            save_every,
            stepping: false,
            steps: 0,
            endpoint,
            lost: None,
            _running: running,
            session,
        };
        let begun = Instant::now();
        remote.dispatcher.launch_all().map_err(|error| remote.explained(error, begun))?;
        Ok(remote)
    }

    /// Makes calls; returns their outcome, the messages of the FMU, and notes on recoveries.
    pub fn ask(&mut self, mut asks: Vec<Ask>) -> Result<(Outcome, Vec<Message>, Vec<String>)> {
        if asks == [Ask::Reset] && self.lost.take().is_some() {
            return self.begin_again();
        }
        if let Some(lost) = &self.lost {
            return Err(Error::new(Code::Lost, lost.clone()));
        }
        let count = asks.len();
        if self.is_saved_now(&asks) {
            asks.push(Ask::Save);
        }
        let begun = Instant::now();
        let (mut outcome, messages) = self.send(&asks).map_err(|error| {
            let error = self.explained(error, begun);
            self.lost = Some(error.what().to_owned());
            error
        })?;
        self.note(&asks, outcome.given.len())?;
        if let Some(Given::State(state)) = outcome.given.get(count) {
            self.setup.state = Some(state.clone());
            self.rebase()?;
        }
        outcome.given.truncate(count);
        Ok((outcome, messages, std::mem::take(&mut self.dispatcher.notes)))
    }

    /// Ends the instance if the other side is still listening.
    pub fn end(mut self) {
        if self.lost.is_none() && self.dispatcher.groups[0].awaited.is_none() {
            self.dispatcher.options.give_up = Duration::ZERO;
            self.dispatcher.options.deadline = FINISH_TIMEOUT;
            self.dispatcher.options.slowness = 0;
            let message = self.dispatcher.groups[0].command(Kind::Finish, 0, self.dispatcher.now);
            // The outcome does not matter any more.
            let _ =
                self.dispatcher.send(0, message).and_then(|()| self.dispatcher.answers().map(drop));
        }
        self.dispatcher.end();
        super::run::close(self.session);
    }

    fn send(&mut self, asks: &[Ask]) -> Result<(Outcome, Vec<Message>)> {
        if let Some(Ask::Step(t, _)) = Ask::main(asks) {
            self.dispatcher.now = Time::try_from_seconds(*t).unwrap_or(self.dispatcher.now);
        }
        let mut message = self.dispatcher.groups[0].command(Kind::Calls, 0, self.dispatcher.now);
        message.extend(bytes(&asks)?);
        self.dispatcher.send(0, message)?;
        loop {
            let answers = self.dispatcher.answers()?;
            let [(_, answer)] = &answers[..] else {
                return Err(Error::new(Code::Protocol, "there is no answer"));
            };
            match single::read(answer) {
                Ok(read) => return Ok(read),
                Err(why) => self.dispatcher.refuse(0, &why),
            }
        }
    }

    /// Whether the state is to be saved with these calls.
    fn is_saved_now(&mut self, asks: &[Ask]) -> bool {
        let steps = asks.iter().any(|ask| matches!(ask, Ask::Step(..)));
        self.steps += u64::from(steps);
        steps && self.save_every.is_some_and(|every| self.steps.is_multiple_of(every))
    }

    /// Records the first `done` calls.
    fn note(&mut self, asks: &[Ask], done: usize) -> Result<()> {
        for ask in asks.iter().take(done) {
            if *ask == Ask::Reset {
                self.setup.before.clear();
                self.setup.state = None;
                self.stepping = false;
                self.rebase()?;
            } else if !self.stepping && ask.changes() {
                if matches!(ask, Ask::Restore(_)) {
                    // Earlier calls have no effect any more.
                    self.setup.before.clear();
                }
                self.setup.before.push(ask.clone());
            }
            self.stepping |= matches!(ask, Ask::Exit | Ask::Restore(_));
        }
        Ok(())
    }

    fn rebase(&mut self) -> Result<()> {
        let (body, _) = self.setup.encode()?;
        self.dispatcher.rebase(0, body);
        Ok(())
    }

    /// A reset after a loss: makes a new instance from the start.
    fn begin_again(&mut self) -> Result<(Outcome, Vec<Message>, Vec<String>)> {
        self.note(&[Ask::Reset], 1)?;
        self.dispatcher.groups[0].forget();
        let begun = Instant::now();
        self.dispatcher.launch_all().map_err(|error| {
            let error = self.explained(error, begun);
            self.lost = Some(error.what().to_owned());
            error
        })?;
        let outcome = Outcome { given: vec![Given::Done], trouble: None };
        Ok((outcome, Vec::new(), std::mem::take(&mut self.dispatcher.notes)))
    }

    /// The same error, with how long the caller waited and where workers should have connected.
    fn explained(&self, error: Error, begun: Instant) -> Error {
        if error.code() != Code::Lost {
            return error;
        }
        let waited = begun.elapsed().as_secs_f64();
        let what = format!("{}; waited for {waited:.1} s at {}", error.what(), self.endpoint);
        let help = format!("cosim worker --connect {} --allow FMU", self.endpoint);
        match error.reason() {
            Some(why) => Error::new(Code::Lost, what).why(why).help(help),
            None => Error::new(Code::Lost, what).help(help),
        }
    }
}

/// How long a worker may take to finish.
const FINISH_TIMEOUT: Duration = Duration::from_millis(300);

/// Listens at the first endpoint that is free.
pub(super) fn listen(accesses: &[Access]) -> Result<(Session, String)> {
    let mut problem = Error::new(Code::Session, "there is no endpoint to listen at");
    for access in accesses {
        match access.listen() {
            Ok(session) => return Ok((session, access.endpoints.join(", "))),
            Err(error) => problem = error,
        }
    }
    Err(problem)
}
