//! The state of a run for observers: collected beside the messages, never in their way.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::fabric::{Event, Fabric};
use super::process_status::ProcessStatus;
use super::wire::Header;
use cosim_base::error::Result;
use cosim_base::time::Time;

/// The state of a run. Observers get it as JSON.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// The run.
    pub run: String,
    /// Name of the system.
    pub system: String,
    /// The instant that is being computed, s.
    pub time: f64,
    /// Stop time, s.
    pub stop: f64,
    /// Elapsed wall-clock time, s.
    pub elapsed: f64,
    /// Simulated seconds per second of wall-clock time.
    pub real_time_factor: f64,
    /// The groups.
    pub groups: Vec<GroupStatus>,
    /// The run has ended.
    pub ended: bool,
}

/// The state of a group.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct GroupStatus {
    /// Its components.
    pub components: Vec<String>,
    /// Where it runs.
    pub place: String,
    /// Generation of its incarnation.
    pub generation: u32,
    /// How long the others have been waiting for its answer, s; `None` if it has answered.
    pub awaited: Option<f64>,
    /// Commands answered.
    pub answers: u64,
    /// Mean time to an answer, including both ways on the network, s.
    pub mean: f64,
    /// Longest time to an answer, s.
    pub longest: f64,
}

/// Counters of a run in progress.
pub(super) struct Board(Mutex<Counts>);

struct Counts {
    /// When the first command was sent.
    begun: Instant,
    /// Simulated time at the start and now, ns.
    first: Option<i64>,
    time: i64,
    fixed: Status,
    groups: Vec<Count>,
}

#[derive(Default)]
struct Count {
    place: String,
    generation: u32,
    asked: Option<(Instant, u64)>,
    answers: u64,
    total: Duration,
    longest: Duration,
}

impl Board {
    /// For groups of these components.
    pub(super) fn new(run: &str, system: &str, stop: f64, groups: Vec<Vec<String>>) -> Self {
        let counts = groups.iter().map(|_| Count::default()).collect();
        let group = |components| GroupStatus { components, ..GroupStatus::default() };
        let groups = groups.into_iter().map(group).collect();
        let (run, system) = (run.to_owned(), system.to_owned());
        let fixed = Status { run, system, stop, groups, ..Status::default() };
        let begun = Instant::now();
        Self(Mutex::new(Counts { begun, first: None, time: 0, fixed, groups: counts }))
    }

    fn counts(&self) -> MutexGuard<'_, Counts> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The current state.
    pub(super) fn status(&self) -> Status {
        let counts = self.counts();
        let mut status = counts.fixed.clone();
        status.time = Time::from_ns(counts.time).seconds();
        status.elapsed = counts.begun.elapsed().as_secs_f64();
        let simulated = counts.first.map_or(0, |first| counts.time - first) as f64 * 1e-9;
        status.real_time_factor = simulated / status.elapsed.max(1e-9);
        for (group, count) in status.groups.iter_mut().zip(&counts.groups) {
            group.place.clone_from(&count.place);
            group.generation = count.generation;
            group.awaited = count.asked.map(|(since, _)| since.elapsed().as_secs_f64());
            group.answers = count.answers;
            group.mean = count.total.as_secs_f64() / count.answers.max(1) as f64;
            group.longest = count.longest.as_secs_f64();
        }
        status
    }

    fn launched(&self, group: usize, generation: u32, place: String) {
        if let Some(count) = self.counts().groups.get_mut(group) {
            count.place = place;
            count.generation = generation;
            count.asked = Some((Instant::now(), 0));
        }
    }

    fn asked(&self, group: usize, message: &[u8]) {
        let Ok((header, _)) = Header::read(message) else {
            return;
        };
        let mut counts = self.counts();
        counts.time = header.time.ns();
        if counts.first.is_none() {
            counts.first = Some(counts.time);
            counts.begun = Instant::now();
        }
        if let Some(count) = counts.groups.get_mut(group) {
            count.asked = Some((Instant::now(), header.sequence));
        }
    }

    fn answered(&self, group: usize, bytes: &[u8], at: Instant) {
        let Ok((header, _)) = Header::read(bytes) else {
            return;
        };
        let mut counts = self.counts();
        let count = counts.groups.get_mut(group);
        let Some(count) = count.filter(|count| count.generation == header.generation) else {
            return;
        };
        if let Some((since, _)) = count.asked.take_if(|(_, asked)| *asked == header.sequence) {
            let took = at.saturating_duration_since(since);
            count.answers += 1;
            count.total += took;
            count.longest = count.longest.max(took);
        }
    }
}

/// A fabric that reports to a [`Board`].
pub(super) struct Watched<F> {
    fabric: F,
    board: Arc<Board>,
}

impl<F: Fabric> Watched<F> {
    /// Notes on `board` what `fabric` carries.
    pub(super) fn new(fabric: F, board: Arc<Board>) -> Self {
        Self { fabric, board }
    }
}

impl<F: Fabric> Fabric for Watched<F> {
    fn launch(&mut self, group: usize, generation: u32) -> Result<()> {
        self.fabric.launch(group, generation)?;
        self.board.launched(group, generation, self.fabric.place(group));
        Ok(())
    }

    fn send(&mut self, group: usize, generation: u32, message: &[u8]) -> Result<()> {
        self.board.asked(group, message);
        self.fabric.send(group, generation, message)
    }

    fn next(&mut self, awaited: usize, patience: Duration) -> Option<Event> {
        let event = self.fabric.next(awaited, patience);
        if let Some(Event::Answer { group, bytes, at }) = &event {
            self.board.answered(*group, bytes, *at);
        }
        event
    }

    fn inquire(&mut self, group: usize, generation: u32) -> Option<ProcessStatus> {
        self.fabric.inquire(group, generation)
    }

    fn abandon(&mut self, group: usize, generation: u32) {
        self.fabric.abandon(group, generation);
    }

    fn place(&self, group: usize) -> String {
        self.fabric.place(group)
    }
}
