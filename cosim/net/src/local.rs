//! A fabric within this process, for tests: it loses, repeats and reorders messages on request.

use std::cell::RefCell;
use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::fabric::{Event, Fabric};
use super::host::{Handled, Host};
use super::process_status::ProcessStatus;
use super::setup::{FmuFile, FmuSource};
use super::wire::HEADER;
use cosim_base::error::{Code, Error, Result};
use cosim_import::Fmu;

/// FMUs by hash, with their paths in the system.
#[derive(Clone)]
pub(super) struct Files(pub BTreeMap<String, PathBuf>);

impl FmuSource for Files {
    fn open(&mut self, file: &FmuFile) -> Result<Arc<Fmu>> {
        match self.0.get(&file.sha256) {
            Some(path) => Fmu::open(path),
            None => Err(Error::new(Code::File, format!("no {} here", file.name))),
        }
    }
}

/// What goes wrong with the command of this number, counted over all commands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fault {
    /// The host dies before it gets the command.
    DiesBefore,
    /// The host dies after it has executed the command, before its answer is seen.
    DiesAfter,
    /// The answer comes twice.
    AnswersTwice,
    /// The command comes twice.
    HearsTwice,
    /// A message of the group's previous incarnation comes first.
    Ghost,
    /// The command itself comes back as if it were an answer.
    Echo,
    /// The previous answer comes again, before the one that is awaited.
    Late,
    /// The answer to a command that has not been sent yet comes first.
    Early,
    /// Foreign messages come first: noise, other versions, other plans, unknown groups.
    Foreign,
    /// The first octets of the command, and of its answer, come before the complete message.
    Torn,
    /// Answers that cannot be understood come first: shorter and longer than the true one, and a
    /// failure without text.
    Misread,
    /// The end of the answer is missing.
    CutAnswer,
    /// The end of the command is missing.
    CutCommand,
}

pub(super) struct Local {
    files: Files,
    hosts: BTreeMap<usize, (u32, Host)>,
    queue: VecDeque<Event>,
    faults: Vec<(u64, Fault)>,
    sent: u64,
    /// The last answer of each group.
    last: BTreeMap<usize, Vec<u8>>,
    /// All messages that group 0 was sent.
    pub sent_to_first: Rc<RefCell<Vec<Vec<u8>>>>,
}

impl Local {
    pub(super) fn new(files: Files, faults: Vec<(u64, Fault)>) -> Self {
        Self {
            files,
            hosts: BTreeMap::new(),
            queue: VecDeque::new(),
            faults,
            sent: 0,
            last: BTreeMap::new(),
            sent_to_first: Rc::default(),
        }
    }

    fn deliver(&mut self, group: usize, message: &[u8]) -> Option<Vec<u8>> {
        match self.hosts.get_mut(&group)?.1.handle(message) {
            Handled::Answer(bytes) | Handled::Last(bytes) => Some(bytes),
            Handled::Ignored(_) => None,
        }
    }
}

impl Local {
    /// Messages that arrive before the answer and must be ignored.
    fn strays(
        &self,
        fault: Option<Fault>,
        group: usize,
        command: &[u8],
        answer: &[u8],
    ) -> Vec<(usize, Vec<u8>)> {
        let with = |place: usize| {
            let mut bytes = answer.to_vec();
            bytes[place] = bytes[place].wrapping_add(1);
            (group, bytes)
        };
        match fault {
            Some(Fault::Echo) => vec![(group, command.to_vec())],
            Some(Fault::Late) => {
                self.last.get(&group).map(|b| (group, b.clone())).into_iter().collect()
            }
            // The positions of the fields of a header: `Header::message`.
            Some(Fault::Early) => vec![with(8)],
            Some(Fault::Torn) => vec![(group, answer[..HEADER / 2].to_vec())],
            Some(Fault::Misread) => {
                let mut failed = answer[..HEADER].to_vec();
                failed[2] = super::wire::Kind::Failed as u8;
                vec![
                    (group, answer[..answer.len() - 1].to_vec()),
                    (group, [answer, &[0]].concat()),
                    (group, failed),
                ]
            }
            Some(Fault::Foreign) => vec![
                (group, Vec::new()),
                (group, b"GET / HTTP/1.1\r\n\r\n this is not of cosim".to_vec()),
                with(0),
                with(1),
                with(16),
                (99, answer.to_vec()),
            ],
            _ => Vec::new(),
        }
    }
}

impl Fabric for Local {
    fn launch(&mut self, group: usize, generation: u32) -> Result<()> {
        let host = Host::new(generation, Box::new(self.files.clone()));
        self.hosts.insert(group, (generation, host));
        self.queue.push_back(Event::Ready { group, generation });
        Ok(())
    }

    fn send(&mut self, group: usize, generation: u32, message: &[u8]) -> Result<()> {
        self.sent += 1;
        if group == 0 {
            self.sent_to_first.borrow_mut().push(message.to_vec());
        }
        let sent = self.sent;
        let fault = self.faults.iter().find(|(at, _)| *at == sent).map(|(_, fault)| *fault);
        let why = || "it was killed".to_owned();
        match fault {
            Some(Fault::DiesBefore) => {
                self.hosts.remove(&group);
                self.queue.push_back(Event::Lost { group, generation, why: why() });
                return Ok(());
            }
            Some(Fault::Ghost) => {
                let mut bytes = message.to_vec();
                bytes[2] = super::wire::Kind::Done as u8;
                bytes[4..8].copy_from_slice(&generation.wrapping_sub(1).to_le_bytes());
                self.queue.push_back(Event::Answer { group, bytes, at: Instant::now() });
                self.queue.push_back(Event::Lost {
                    group,
                    generation: generation.wrapping_sub(1),
                    why: why(),
                });
            }
            Some(Fault::HearsTwice) => {
                if let Some(bytes) = self.deliver(group, message) {
                    self.queue.push_back(Event::Answer { group, bytes, at: Instant::now() });
                }
            }
            Some(Fault::Torn) => drop(self.deliver(group, &message[..HEADER / 2])),
            _ => {}
        }
        let heard =
            if fault == Some(Fault::CutCommand) { message.len() - 1 } else { message.len() };
        let Some(mut bytes) = self.deliver(group, &message[..heard]) else {
            return Ok(());
        };
        if fault == Some(Fault::DiesAfter) {
            self.hosts.remove(&group);
            self.queue.push_back(Event::Lost { group, generation, why: why() });
            return Ok(());
        }
        if fault == Some(Fault::AnswersTwice) {
            self.queue.push_front(Event::Answer {
                group,
                bytes: bytes.clone(),
                at: Instant::now(),
            });
        }
        if fault == Some(Fault::CutAnswer) {
            bytes.pop();
        }
        // The last answer is delivered first.
        self.queue.push_front(Event::Answer { group, bytes: bytes.clone(), at: Instant::now() });
        for (group, bytes) in self.strays(fault, group, message, &bytes) {
            self.queue.push_front(Event::Answer { group, bytes, at: Instant::now() });
        }
        self.last.insert(group, bytes);
        Ok(())
    }

    fn next(&mut self, _awaited: usize, _patience: Duration) -> Option<Event> {
        self.queue.pop_front()
    }

    fn inquire(&mut self, _group: usize, _generation: u32) -> Option<ProcessStatus> {
        None
    }

    fn abandon(&mut self, group: usize, generation: u32) {
        if self.hosts.get(&group).is_some_and(|(living, _)| *living == generation) {
            self.hosts.remove(&group);
        }
    }

    fn place(&self, group: usize) -> String {
        format!("place {group}")
    }
}
