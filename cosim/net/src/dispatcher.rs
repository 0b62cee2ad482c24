//! Sends commands, awaits answers and recovers lost groups in one event loop.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use super::fabric::{Event, Fabric};
use super::failure::Failure;
use super::group_handle::{Awaited, GroupHandle, SentCommand, digest};
use super::options::{OnFatal, Options};
use super::wire::{Header, Kind, Malformed};
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::Time;
use cosim_import::status::FATAL;

/// The most spare answers that are kept.
const SPARES: usize = 64;

/// The groups of a run, whatever they compute.
pub(super) struct Dispatcher<'a> {
    pub groups: Vec<GroupHandle>,
    /// Names of the components in each group, for messages.
    names: Vec<String>,
    pub fabric: Box<dyn Fabric + 'a>,
    pub options: Options,
    /// Answers that came after others which are not read yet, by group.
    spares: VecDeque<(usize, Vec<u8>)>,
    /// What was lost, and how the run continued.
    pub notes: Vec<String>,
    /// The instant that is being computed or was computed last.
    pub now: Time,
}

impl<'a> Dispatcher<'a> {
    /// Takes each group with its name.
    pub(super) fn new(
        groups: Vec<(String, GroupHandle)>,
        fabric: Box<dyn Fabric + 'a>,
        options: Options,
        now: Time,
    ) -> Self {
        let (names, groups) = groups.into_iter().unzip();
        let (spares, notes) = (VecDeque::new(), Vec::new());
        Self { groups, names, fabric, options, spares, notes, now }
    }

    /// Starts the first incarnation of every group.
    pub(super) fn launch_all(&mut self) -> Result<()> {
        for group in 0..self.groups.len() {
            self.start_incarnation(group)?;
        }
        self.answers().map(drop)
    }

    /// Sends a command and logs it. All commands before it have been answered.
    pub(super) fn send(&mut self, group: usize, message: Vec<u8>) -> Result<()> {
        self.fabric.send(group, self.groups[group].generation, &message)?;
        self.spares.clear();
        let handle = &mut self.groups[group];
        handle.log.push(SentCommand { message, answer: None });
        handle.wait_for(Awaited::Last);
        Ok(())
    }

    /// Waits until every group has done its command, and returns their answers by group. One that
    /// cannot be understood is given to [`Self::refuse`], and the next call waits for another.
    pub(super) fn answers(&mut self) -> Result<Vec<(usize, Vec<u8>)>> {
        let mut answers: Vec<(usize, Vec<u8>)> = Vec::new();
        while let Some((group, patience)) = self.most_overdue() {
            let event = match self.spare() {
                None => self.fabric.next(self.awaited(), patience),
                spare => spare,
            };
            match event {
                Some(Event::Ready { group, generation }) => self.ready(group, generation)?,
                Some(Event::Answer { group, bytes, .. }) => {
                    answers.extend(self.hear(group, bytes)?.map(|bytes| (group, bytes)));
                }
                Some(Event::Lost { group, generation, why }) => {
                    if self.is_current(group, generation) && !self.groups[group].is_finished() {
                        self.lose(group, &why, false)?;
                    }
                }
                None => self.time_out(group)?,
            }
        }
        // By group, not by arrival: the caller reads them in the same order in every run.
        answers.sort_by_key(|(group, _)| *group);
        Ok(answers)
    }

    /// Takes a message from a group; returns it if it answers the last command.
    fn hear(&mut self, group: usize, bytes: Vec<u8>) -> Result<Option<Vec<u8>>> {
        // Otherwise from an abandoned incarnation, or a duplicate.
        if let Some(command) = self.answered(group, &bytes) {
            let handle = &self.groups[group];
            if handle.awaited_sequence() == Some(command) {
                return Ok(self.take_answer(group, &bytes)?.then_some(bytes));
            }
            if handle.sequence == command && self.spares.len() < SPARES {
                self.spares.push_back((group, bytes));
            }
        }
        Ok(None)
    }

    /// The group's answer cannot be understood, so it is not from the host, which may still answer.
    pub(super) fn refuse(&mut self, group: usize, why: &Malformed) {
        let handle = &mut self.groups[group];
        handle.awaited = Some(Awaited::Last);
        if let Some(sent) = handle.log.last_mut() {
            sent.answer = None;
        }
        self.doubt(group, Error::new(Code::Protocol, "an answer cannot be understood").why(why));
    }

    /// Ignores an answer that the host cannot have given, unless it gives no other in time.
    fn doubt(&mut self, group: usize, error: Error) {
        let handle = &mut self.groups[group];
        if handle.doubt.is_none() {
            let why = error.reason().unwrap_or_default();
            let ignored = format!("ignored at t = {}: {}: {why}", self.now, error.what());
            (self.options.report)(&format!("{}: {ignored}", self.names[group]));
            handle.doubt = Some(error);
        }
    }

    fn time_out(&mut self, group: usize) -> Result<()> {
        let handle = &mut self.groups[group];
        let (awaited, silent) = (handle.awaits(), handle.silent().as_secs_f64());
        let why = format!("no answer to {awaited} for {silent:.1} s");
        match handle.doubt.take() {
            None => self.lose(group, &why, false),
            Some(error) if error.code() == Code::Differs => Err(error),
            Some(error) => {
                let doubt = error.reason().unwrap_or_default();
                self.lose(group, &format!("{why}; {}: {doubt}", error.what()), false)
            }
        }
    }

    /// The group whose timeout ends first, and how much time is left.
    fn most_overdue(&self) -> Option<(usize, Duration)> {
        let waiting = self.groups.iter().enumerate().filter(|(_, m)| m.awaited.is_some());
        let left = waiting.map(|(group, m)| (m.patience(&self.options), group));
        left.min().map(|(left, group)| (group, left))
    }

    /// How many answers must arrive before there is something to do.
    fn awaited(&self) -> usize {
        let awaited = self.groups.iter().filter_map(|handle| handle.awaited);
        match awaited.clone().all(|awaited| awaited == Awaited::Last) {
            true => awaited.count(),
            false => 1,
        }
    }

    fn is_current(&self, group: usize, generation: u32) -> bool {
        self.groups.get(group).is_some_and(|handle| handle.generation == generation)
    }

    /// The number of the command that a message answers.
    fn answered(&self, group: usize, bytes: &[u8]) -> Option<u64> {
        let (handle, (header, _)) = (self.groups.get(group)?, Header::read(bytes).ok()?);
        let matches = matches!(header.kind, Kind::Done | Kind::Failed)
            && header.generation == handle.generation
            && header.tables == handle.tables;
        matches.then_some(header.sequence)
    }

    /// The next spare answer of a group whose answer was refused.
    fn spare(&mut self) -> Option<Event> {
        let wanted = |(group, _): &(usize, Vec<u8>)| self.groups[*group].awaited.is_some();
        let place = self.spares.iter().position(wanted)?;
        let (group, bytes) = self.spares.remove(place)?;
        Some(Event::Answer { group, bytes, at: Instant::now() })
    }

    /// An incarnation is ready: it gets its set-up.
    fn ready(&mut self, group: usize, generation: u32) -> Result<()> {
        if self.is_current(group, generation) && self.groups[group].is_launching() {
            let first = self.groups[group].first(self.now);
            self.groups[group].wait_for(Awaited::SetUp);
            self.fabric.send(group, generation, &first)?;
        }
        Ok(())
    }

    /// Takes the expected answer; whether it answers the last command.
    fn take_answer(&mut self, group: usize, bytes: &[u8]) -> Result<bool> {
        match self.failure(group, bytes) {
            Ok(None) => {}
            Ok(Some(error)) => {
                let fatal = error.status() == Some(FATAL);
                let fatal = fatal && self.options.on_fatal == OnFatal::Resume;
                // A host that was sent something else than our commands starts over, too.
                if !fatal && error.code() != Code::Protocol {
                    return Err(error);
                }
                let why = error.reason().unwrap_or_default();
                self.lose(group, &format!("{}: {why}", error.what()), fatal)?;
                return Ok(false);
            }
            Err(why) => {
                self.doubt(group, Error::new(Code::Protocol, "a failure cannot be read").why(why));
                return Ok(false);
            }
        }
        let handle = &mut self.groups[group];
        handle.answered();
        let next = match handle.awaited {
            Some(Awaited::SetUp) => 0,
            Some(Awaited::Again(number)) => {
                let digest = digest(bytes);
                if handle.log[number].answer.is_some_and(|before| before != digest) {
                    let differs = self.differs(group, number);
                    self.doubt(group, differs);
                    return Ok(false);
                }
                number + 1
            }
            _ => {
                handle.awaited = None;
                if let Some(sent) = handle.log.last_mut() {
                    sent.answer = Some(digest(bytes));
                }
                return Ok(true);
            }
        };
        self.resend(group, next)?;
        Ok(false)
    }

    /// Sends a new incarnation the command `number` of the log; the last one may not have been
    /// answered yet.
    fn resend(&mut self, group: usize, number: usize) -> Result<()> {
        let handle = &mut self.groups[group];
        let generation = handle.generation;
        let Some(sent) = handle.log.get(number) else {
            handle.awaited = None;
            self.recovered(group);
            return Ok(());
        };
        let message = sent.again(generation);
        let awaited = match sent.answer {
            Some(_) => Awaited::Again(number),
            None => Awaited::Last,
        };
        handle.wait_for(awaited);
        if awaited == Awaited::Last {
            self.recovered(group);
        }
        self.fabric.send(group, generation, &message)
    }

    /// A new incarnation has caught up with the lost one.
    fn recovered(&mut self, group: usize) {
        if let Some((since, why)) = self.groups[group].lost.take() {
            let took = since.elapsed().as_secs_f64() * 1e3;
            let (names, place) = (&self.names[group], self.fabric.place(group));
            self.notes.push(format!("{names}: {why}; went on at {place} after {took:.0} ms"));
        }
    }

    /// The error that an answer carries.
    fn failure(&self, group: usize, answer: &[u8]) -> Result<Option<Error>, Malformed> {
        match Header::read(answer)? {
            (Header { kind: Kind::Failed, .. }, body) => {
                let failure: Failure = body.structure()?;
                Ok(Some(failure.into_error(&self.fabric.place(group))))
            }
            _ => Ok(None),
        }
    }

    /// A group is lost, possibly by its own fault: starts a new incarnation from its last state,
    /// which gets all commands since then again.
    fn lose(&mut self, group: usize, why: &str, at_fault: bool) -> Result<()> {
        let begun = Instant::now();
        let place = self.fabric.place(group);
        let known = format!("lost at {place}, t = {}: {why}", self.now);
        (self.options.report)(&format!("{}: {known}", self.names[group]));
        let status = self.fabric.inquire(group, self.groups[group].generation);
        let detail = status.as_ref().map_or_else(String::new, |status| format!("; {status}"));
        let why = format!("{known}{detail}");
        let handle = &mut self.groups[group];
        let since = handle.lost.as_ref().map_or(begun, |(since, _)| *since);
        handle.lost = Some((since, why.clone()));
        handle.recoveries += 1;
        let faults = handle.faults(at_fault || status.is_some_and(|status| status.is_own_fault()));
        let losses = handle.losses();
        let help = if faults >= self.options.attempts {
            "it fails each time at the same command: its FMU is at fault"
        } else if losses >= self.options.losses {
            "it is lost each time at the same command: an FMU that stops or kills its own \
             process cannot be told from one that is killed from outside"
        } else if handle.recoveries > self.options.recoveries {
            "--recoveries allows more restarts"
        } else if handle.base.is_none() && self.options.require_resume {
            "without --require-resume it would be computed again from the start"
        } else if since.elapsed() > self.options.give_up {
            "no worker took it over in time"
        } else {
            let what = format!("{} is {why}", self.names[group]);
            return self.start_incarnation(group).map_err(|error| match error.code() {
                Code::Lost => {
                    let found = error.reason().unwrap_or_default();
                    let found = format!("{}: {found}", error.what());
                    let help = error.remedy().map(str::to_owned);
                    Error::new(Code::Lost, what).why(found).maybe_help(help)
                }
                _ => error,
            });
        };
        Err(Error::new(Code::Lost, format!("{} is {why}", self.names[group])).help(help))
    }

    fn start_incarnation(&mut self, group: usize) -> Result<()> {
        let handle = &mut self.groups[group];
        if handle.generation > 0 {
            self.fabric.abandon(group, handle.generation);
        }
        handle.generation += 1;
        handle.wait_for(Awaited::Launch);
        self.fabric.launch(group, handle.generation)
    }

    /// From now on, new incarnations start from this set-up, which includes the effect of all
    /// commands so far.
    pub(super) fn rebase(&mut self, group: usize, setup: Vec<u8>) {
        let handle = &mut self.groups[group];
        handle.base = Some((setup, handle.sequence));
        handle.log.clear();
    }

    /// Stops all groups that still run.
    pub(super) fn end(&mut self) {
        for (group, handle) in self.groups.iter().enumerate() {
            self.fabric.abandon(group, handle.generation);
        }
    }

    fn differs(&self, group: usize, number: usize) -> Error {
        let time = Header::read(&self.groups[group].log[number].message).map(|(h, _)| h.time);
        let time = time.map_or_else(|_| String::new(), |time| format!(" at t = {time}"));
        let names = &self.names[group];
        Error::new(Code::Differs, format!("{names}: the repeated computation differs{time}"))
            .why("an FMU there is not deterministic, or the state that it serializes is incomplete")
            .help("--require-resume with --save-every 0 ends such a run instead of repeating it")
    }
}
