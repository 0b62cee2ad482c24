//! A group as the coordinator sees it: the commands it was sent, and what a new incarnation needs.

use std::hash::{DefaultHasher, Hasher};
use std::time::{Duration, Instant};

use sha2::{Digest, Sha256};

use super::options::Options;
use super::wire::{APART, Header, Kind};
use cosim_base::error::Error;
use cosim_base::time::Time;
use cosim_import::calls::Ask;

/// A group of the run.
pub(super) struct GroupHandle {
    /// The kind of message that sets it up.
    kind: Kind,
    pub generation: u32,
    /// Number of the last command.
    pub sequence: u64,
    /// Digest of the plan.
    pub tables: u64,
    /// The set-up without a state.
    pub setup: Vec<u8>,
    /// The set-up with the last saved state, and the number of the command before it.
    pub base: Option<(Vec<u8>, u64)>,
    /// The commands since then.
    pub log: Vec<SentCommand>,
    /// What the coordinator is waiting for.
    pub awaited: Option<Awaited>,
    since: Instant,
    /// Why the first answer to it was ignored, if one was.
    pub doubt: Option<Error>,
    /// Values that are held from the end of the last instant, until they are sent.
    pub opening: Option<Vec<u8>>,
    /// Its recorded values are those of the current instant.
    pub recorded: bool,
    /// How many new incarnations were started; if one is being started, since when and why.
    pub recoveries: u32,
    pub lost: Option<(Instant, String)>,
    /// The longest time that an answer took.
    longest: Duration,
    /// The command at which the group last failed by its own fault, and how often in a row.
    faults: (u64, u32),
    /// The same for all losses.
    losses: (u64, u32),
}

/// What the coordinator is waiting for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Awaited {
    /// The incarnation accepts messages.
    Launch,
    /// The answer to its set-up.
    SetUp,
    /// The answer to a command that was already answered before the loss, by position in the log.
    Again(usize),
    /// The answer to the last command.
    Last,
}

/// A command, and a digest of its answer.
pub(super) struct SentCommand {
    pub message: Vec<u8>,
    pub answer: Option<u64>,
}

impl GroupHandle {
    /// A group that is set up by a message of this kind.
    pub(super) fn new(kind: Kind, setup: Vec<u8>, tables: u64) -> Self {
        Self {
            kind,
            generation: 0,
            sequence: 0,
            tables,
            setup,
            base: None,
            log: Vec::new(),
            awaited: None,
            since: Instant::now(),
            doubt: None,
            opening: None,
            recorded: false,
            recoveries: 0,
            lost: None,
            longest: Duration::ZERO,
            faults: (0, 0),
            losses: (0, 0),
        }
    }

    /// The next command, still without a body.
    pub(super) fn command(&mut self, kind: Kind, flags: u8, time: Time) -> Vec<u8> {
        self.sequence += 1;
        let (generation, sequence, tables) = (self.generation, self.sequence, self.tables);
        Header { kind, flags, generation, sequence, tables, time }.message()
    }

    /// The set-up that starts an incarnation.
    pub(super) fn first(&self, time: Time) -> Vec<u8> {
        let (generation, tables, kind) = (self.generation, self.tables, self.kind);
        let sequence = self.before_log();
        let header = Header { kind, flags: 0, generation, sequence, tables, time };
        let body = self.base.as_ref().map_or(&self.setup, |(body, _)| body);
        [&header.message()[..], &Sha256::digest(body), body].concat()
    }

    fn before_log(&self) -> u64 {
        self.base.as_ref().map_or(0, |(_, sequence)| *sequence)
    }

    /// The number of the command whose answer is awaited.
    pub(super) fn awaited_sequence(&self) -> Option<u64> {
        match self.awaited? {
            Awaited::Launch => None,
            Awaited::SetUp => Some(self.before_log()),
            Awaited::Again(number) => Some(self.before_log() + 1 + number as u64),
            Awaited::Last => Some(self.sequence),
        }
    }

    /// What is awaited, as text.
    pub(super) fn awaits(&self) -> String {
        let sent = match self.awaited {
            Some(Awaited::Launch) | None => return "its start".to_owned(),
            Some(Awaited::SetUp) => return "its set-up".to_owned(),
            Some(Awaited::Again(number)) => self.log.get(number),
            Some(Awaited::Last) => self.log.last(),
        };
        match sent.and_then(|sent| Header::read(&sent.message).ok()) {
            Some((Header { kind: Kind::Step, time, .. }, _)) => format!("the step to t = {time}"),
            Some((Header { kind: Kind::Calls, time, .. }, body)) => {
                let asks: Vec<Ask> = body.structure().unwrap_or_default();
                let function = Ask::main(&asks).map_or("a call", |ask| ask.function().name());
                format!("{function} at t = {time}")
            }
            Some((Header { kind, .. }, _)) => format!("the command {kind:?}"),
            None => "its last command".to_owned(),
        }
    }

    /// Counts a loss; how often in a row it was lost by its own fault at this command.
    pub(super) fn faults(&mut self, own: bool) -> u32 {
        let at = self.awaited_sequence().unwrap_or_default();
        self.faults = match self.faults {
            _ if !own => (at, 0),
            (before, count) if before == at => (at, count + 1),
            _ => (at, 1),
        };
        self.faults.1
    }

    /// How often in a row it was lost at this command, this time included, whatever the cause.
    pub(super) fn losses(&mut self) -> u32 {
        let at = self.awaited_sequence().unwrap_or_default();
        let (before, count) = self.losses;
        self.losses = (at, if before == at { count + 1 } else { 1 });
        self.losses.1
    }

    pub(super) fn is_launching(&self) -> bool {
        self.awaited == Some(Awaited::Launch)
    }

    pub(super) fn wait_for(&mut self, awaited: Awaited) {
        self.awaited = Some(awaited);
        self.since = Instant::now();
        self.doubt = None;
    }

    /// It has done its last command, and its process may end.
    pub(super) fn is_finished(&self) -> bool {
        let header = self.log.last().filter(|sent| sent.answer.is_some());
        let header = header.and_then(|sent| Header::read(&sent.message).ok());
        self.awaited.is_none() && header.is_some_and(|(header, _)| header.kind == Kind::Finish)
    }

    /// Starts over: drops the log, but keeps counting generations.
    pub(super) fn forget(&mut self) {
        self.log.clear();
        (self.awaited, self.opening, self.lost, self.recoveries) = (None, None, None, 0);
    }

    /// How long the coordinator has been waiting.
    pub(super) fn silent(&self) -> Duration {
        self.since.elapsed()
    }

    /// How much longer to wait.
    pub(super) fn patience(&self, options: &Options) -> Duration {
        let allowed = match self.awaited {
            Some(Awaited::Launch | Awaited::SetUp) => options.launch_deadline,
            _ => options.deadline.max(self.longest.saturating_mul(options.slowness)),
        };
        allowed.saturating_sub(self.silent())
    }

    /// An answer arrived.
    pub(super) fn answered(&mut self) {
        if matches!(self.awaited, Some(Awaited::Again(_) | Awaited::Last)) {
            self.longest = self.longest.max(self.silent());
        }
    }
}

impl SentCommand {
    /// The same command for another incarnation.
    pub(super) fn again(&self, generation: u32) -> Vec<u8> {
        let mut message = self.message.clone();
        // The position of the generation in `Header`.
        message[4..8].copy_from_slice(&generation.to_le_bytes());
        message
    }
}

/// A digest of the part of an answer that is the same whenever its command is repeated.
pub(super) fn digest(answer: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    hasher.write(match Header::read(answer) {
        Ok((header, mut body)) if header.has(APART) => body.blob().unwrap_or_default(),
        Ok((_, body)) => body.rest(),
        Err(_) => answer,
    });
    hasher.finish()
}
