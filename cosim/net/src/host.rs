//! Computes a group: commands in, answers out.
//!
//! The host does not know how messages travel. It executes every command exactly once: a repeated
//! command gets the same answer again, a command out of order is refused with both numbers, and a
//! command for another incarnation of the group is ignored.

use super::failure::Failure;
use super::layout::{Group, Part};
use super::setup::{FmuSource, Setup};
use super::single::{Single, SingleSetup};
use super::wire::{
    APART, Body, Header, Kind, LAST, Malformed, OPENING, RECORD, put_blob, put_values,
};
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::Time;
use cosim_core::master::{Change, Engine};

/// The outcome of a message.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Handled {
    /// This is the answer.
    Answer(Vec<u8>),
    /// This is the last answer: the host ends.
    Last(Vec<u8>),
    /// It is not for this host, for the reason given.
    Ignored(String),
}

/// A group and its last answer.
pub(crate) struct Host {
    generation: u32,
    fmus: Box<dyn FmuSource>,
    work: Option<(Work, u64)>,
    sequence: u64,
    answer: Vec<u8>,
}

/// What it computes, stored together with the digest of the plan that the coordinator must have.
enum Work {
    Group(Box<Running>),
    Single(Box<Single>),
}

/// A group that is set up.
struct Running {
    engine: Engine,
    group: Group,
    /// The number of variables of each component.
    variables: Vec<usize>,
    stop: Time,
    /// What is waiting for the values that are held from the end of the last instant.
    open: Option<Open>,
}

#[derive(Clone, Copy)]
enum Open {
    Start,
    Instant(Time),
}

impl Host {
    /// A host for one incarnation of a group.
    pub(crate) fn new(generation: u32, fmus: Box<dyn FmuSource>) -> Self {
        Self { generation, fmus, work: None, sequence: 0, answer: Vec::new() }
    }

    /// Executes a message.
    pub(crate) fn handle(&mut self, message: &[u8]) -> Handled {
        let (header, body) = match Header::read(message) {
            Ok(read) => read,
            Err(why) => return Handled::Ignored(why.to_string()),
        };
        if header.generation != self.generation {
            return Handled::Ignored(format!(
                "a command for incarnation {} of this group reached incarnation {}",
                header.generation, self.generation
            ));
        }
        if self.work.is_some() && header.sequence == self.sequence {
            return Handled::Answer(self.answer.clone());
        }
        let outcome = self.obey(&header, body);
        let apart = matches!(header.kind, Kind::Calls);
        let flags = if apart { APART } else { 0 };
        let done = Header { kind: Kind::Done, flags, ..header };
        self.answer = match outcome {
            Ok(body) => [done.message(), body].concat(),
            Err(error) => {
                let mut answer = Header { kind: Kind::Failed, flags: 0, ..done }.message();
                // A structure of texts can always be serialized.
                answer.extend(postcard::to_stdvec(&Failure::from(&error)).unwrap_or_default());
                answer
            }
        };
        match header.kind {
            Kind::Finish => Handled::Last(self.answer.clone()),
            _ => Handled::Answer(self.answer.clone()),
        }
    }

    fn obey(&mut self, header: &Header, body: Body<'_>) -> Result<Vec<u8>> {
        if matches!(header.kind, Kind::Setup | Kind::Single) {
            return self.set_up(header, body);
        }
        let Some((work, tables)) = &mut self.work else {
            return Err(refused("a command came before the set-up"));
        };
        if header.sequence != self.sequence + 1 {
            let (wanted, got) = (self.sequence + 1, header.sequence);
            return Err(refused(format!("command {got} came where {wanted} was due")));
        }
        if header.tables != *tables {
            return Err(refused("the coordinator has another plan of this group"));
        }
        // Whatever the outcome, it is not executed twice.
        self.sequence = header.sequence;
        match (work, header.kind) {
            (Work::Group(running), _) => running.obey(header, body),
            (Work::Single(single), Kind::Calls) => single.obey(body),
            (Work::Single(_), Kind::Finish) => Ok(Vec::new()),
            (Work::Single(_), _) => Err(refused("that is not a command for a single instance")),
        }
    }

    fn set_up(&mut self, header: &Header, body: Body<'_>) -> Result<Vec<u8>> {
        if self.work.is_some() {
            return Err(refused("a second set-up came"));
        }
        // Verified before anything is built from it: its numbers are positions in tables.
        let setup = body.whole().map_err(malformed)?;
        let work = if header.kind == Kind::Single {
            let setup: SingleSetup = setup.structure().map_err(malformed)?;
            Work::Single(Box::new(setup.build(&mut *self.fmus)?))
        } else {
            let setup: Setup = setup.structure().map_err(malformed)?;
            let stop = setup.stop;
            let (engine, group, variables) = setup.build(&mut *self.fmus)?;
            Work::Group(Box::new(Running { engine, group, variables, stop, open: None }))
        };
        self.sequence = header.sequence;
        self.work = Some((work, header.tables));
        Ok(Vec::new())
    }
}

impl Running {
    fn obey(&mut self, header: &Header, mut body: Body<'_>) -> Result<Vec<u8>> {
        if header.has(OPENING) {
            self.begin_steps(&mut body)?;
        }
        let mut answer = Vec::with_capacity(512);
        match header.kind {
            Kind::Enter => {
                body.end().map_err(malformed)?;
                self.engine.enter(self.stop)?;
                self.put_outputs(&self.group.own, &mut answer);
            }
            Kind::Exchange => {
                let part = self.part(&mut body, |group| &group.stretches)?;
                self.engine.pass(&part.members)?;
                self.put_outputs(&part.members, &mut answer);
            }
            Kind::Exit => {
                body.end().map_err(malformed)?;
                self.engine.exit()?;
                self.open = Some(Open::Start);
                self.put_outputs(&self.group.own, &mut answer);
            }
            Kind::Step => self.step(header, body, &mut answer)?,
            Kind::Sample => {
                body.end().map_err(malformed)?;
                self.record(header.time, &mut answer)?;
            }
            Kind::Save => {
                body.end().map_err(malformed)?;
                put_blob(&mut answer, &bytes(&(self.engine.save()?, self.engine.tally()))?);
            }
            Kind::Change => {
                let (component, change): (usize, Change) = body.structure().map_err(malformed)?;
                if component >= self.group.own.len() {
                    return Err(refused(format!("this group has no component {component}")));
                }
                let (variable, count) = (change.variable, self.variables[component]);
                if variable >= count {
                    return Err(refused(format!("there is no variable {variable} of {count}")));
                }
                self.engine.change(component, change)?;
            }
            Kind::Finish => {
                body.end().map_err(malformed)?;
                answer = bytes(&cosim_core::master::Drive::report(&mut self.engine)?)?;
            }
            Kind::Setup | Kind::Single | Kind::Calls | Kind::Done | Kind::Failed => {
                return Err(refused("that is not a command for a running group"));
            }
        }
        Ok(answer)
    }

    /// Makes the steps of a part that end at the time of the message.
    fn step(&mut self, header: &Header, mut body: Body<'_>, answer: &mut Vec<u8>) -> Result<()> {
        let now = header.time;
        let part = self.part(&mut body, |group| &group.parts)?;
        if header.has(LAST) {
            self.engine.shorten(now);
        }
        let due = |&member: &usize| self.engine.due(member, now);
        let due: Vec<usize> = part.members.iter().copied().filter(due).collect();
        self.engine.end_steps(&part.members, now)?;
        self.open = Some(Open::Instant(now));
        self.put_outputs(&due, answer);
        if header.has(RECORD) {
            self.record(now, answer)?;
        }
        Ok(())
    }

    /// Takes the values that are held from the end of the last instant, and begins the steps with
    /// them.
    fn begin_steps(&mut self, body: &mut Body<'_>) -> Result<()> {
        let (held, engine) = (self.group.held.iter().copied(), &mut self.engine);
        body.values(held, &engine.plan.value_texts, &mut engine.values).map_err(malformed)?;
        match self.open.take() {
            Some(Open::Start) => self.engine.begin(),
            Some(Open::Instant(now)) => self.engine.begin_steps(now),
            None => Err(refused("no step is waiting for the values it holds")),
        }
    }

    /// The part that a message refers to, with the values that it reads.
    fn part(&mut self, body: &mut Body<'_>, of: fn(&Group) -> &Vec<Part>) -> Result<Part> {
        let number = body.number().map_err(malformed)? as usize;
        let part = of(&self.group).get(number).cloned();
        let part = part.ok_or_else(|| refused(format!("this group has no part {number}")))?;
        let (reads, engine) = (part.reads.iter().copied(), &mut self.engine);
        body.values(reads, &engine.plan.value_texts, &mut engine.values).map_err(malformed)?;
        body.end().map_err(malformed)?;
        Ok(part)
    }

    fn record(&mut self, now: Time, answer: &mut Vec<u8>) -> Result<()> {
        self.engine.read_recorded(now)?;
        let (plan, values) = (&self.engine.plan, &self.engine.values);
        put_values(answer, plan.recorded(&self.group.own), &plan.value_texts, values);
        Ok(())
    }

    fn put_outputs(&self, members: &[usize], answer: &mut Vec<u8>) {
        let (plan, values) = (&self.engine.plan, &self.engine.values);
        put_values(answer, plan.outputs(members), &plan.value_texts, values);
    }
}

fn bytes<T: serde::Serialize>(value: &T) -> Result<Vec<u8>> {
    postcard::to_stdvec(value).map_err(|why| refused("an answer cannot be serialized").why(why))
}

fn malformed(why: Malformed) -> Error {
    refused("a message cannot be understood").why(why)
}

fn refused(what: impl Into<String>) -> Error {
    Error::new(Code::Protocol, what)
}
