//! The past of a filter, as far back as measurements may come late: events and copies of the track.
//!
//! A late event is inserted at its instant, the newest copy before it is restored, and the later
//! events are repeated. The result is the same as if the event had arrived in time. Everything has
//! a fixed capacity: a cycle does not allocate.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::kalman::Witness;
use super::measurement::{Event, Key, Kind};
use super::monitor::Monitor;
use super::process::Process;
use super::track::{Ahead, Setup, Track};

/// Number of events kept; at the usual rates some seconds.
const EVENTS: usize = 1024;
/// Copies of the track.
const COPIES: usize = 8;

/// A track with its past.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct History<const N: usize, M> {
    pub(super) track: Track<N, M>,
    copies: VecDeque<Track<N, M>>,
    /// In the order of their keys; the first `taken` are in the track.
    events: VecDeque<Event>,
    taken: usize,
    /// Whether the belief has changed since the last query.
    changed: bool,
}

/// What happened to an event on arrival.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Arrival {
    InTime,
    Late,
    /// Older than the history, or a duplicate.
    Lost,
}

impl<const N: usize, M: Copy> Clone for History<N, M> {
    fn clone(&self) -> Self {
        let (copies, events) = (VecDeque::with_capacity(COPIES), VecDeque::with_capacity(EVENTS));
        let mut copy = Self { track: self.track, copies, events, taken: 0, changed: true };
        copy.clone_from(self);
        copy
    }

    /// Keeps the capacity.
    fn clone_from(&mut self, from: &Self) {
        (self.track, self.taken, self.changed) = (from.track, from.taken, from.changed);
        self.copies.clear();
        self.copies.reserve(COPIES);
        self.copies.extend(&from.copies);
        self.events.clear();
        self.events.reserve(EVENTS);
        self.events.extend(&from.events);
    }
}

impl<const N: usize, M: Monitor<N>> History<N, M> {
    pub(super) fn new(track: Track<N, M>) -> Self {
        let mut copies = VecDeque::with_capacity(COPIES);
        copies.push_back(track);
        let events = VecDeque::with_capacity(EVENTS);
        Self { track, copies, events, taken: 0, changed: true }
    }

    /// Restarts; pending events are kept.
    pub(super) fn reset(&mut self, track: Track<N, M>) {
        self.track = track;
        self.changed = true;
        self.copies.clear();
        self.copies.push_back(track);
        self.events.drain(..self.taken);
        self.taken = 0;
    }

    /// Inserts an event; a late one rolls the track back to before it.
    pub(super) fn insert(&mut self, event: Event) -> Arrival {
        // Nearly every event is the newest, and not before the track.
        let is_newest = self.events.back().is_some_and(|newest| earlier(newest.key(), event.key()));
        if is_newest && event.time >= self.track.time && self.events.len() < EVENTS {
            self.events.push_back(event);
            return Arrival::InTime;
        }
        let place = self.place(event.key());
        let there = self.events.get(place).is_some_and(|e| e.key() == event.key());
        let oldest = self.copies.front().map_or(self.track.key, |copy| copy.key);
        if there || !earlier(oldest, event.key()) || event.time < self.copies_begin() {
            return Arrival::Lost;
        }
        self.make_room();
        let place = self.place(event.key());
        self.events.insert(place, event);
        if place >= self.taken && event.time >= self.track.time - 1e-9 {
            return Arrival::InTime;
        }
        // A copy between the samples around a late sample of a driving signal contains the line
        // across it.
        let before = self.events.range(..place).rev().find(|e| e.kind == event.kind);
        let time = match event.kind {
            Kind::Imu | Kind::Thrust | Kind::Ahrs => before.map_or(f64::NEG_INFINITY, |e| e.time),
            _ => event.time,
        };
        self.go_back(event.key(), time);
        Arrival::Late
    }

    /// Where an event belongs.
    fn place(&self, key: Key) -> usize {
        self.events.partition_point(|e| earlier(e.key(), key))
    }

    fn copies_begin(&self) -> f64 {
        self.copies.front().map_or(self.track.time, |copy| copy.time)
    }

    fn go_back(&mut self, key: Key, time: f64) {
        self.changed = true;
        while let Some(copy) = self.copies.back() {
            let before = earlier(copy.key, key) && copy.time <= time + 1e-9;
            if before || self.copies.len() == 1 {
                self.track = *copy;
                break;
            }
            self.copies.pop_back();
        }
        let key = self.track.key;
        self.taken = self.events.partition_point(|e| !earlier(key, e.key()));
    }

    /// Takes all events up to an instant, and predicts to the grid before it. Returns whether that
    /// changed the belief.
    pub(super) fn run<P: Process<N>>(
        &mut self,
        setup: &Setup<P>,
        until: f64,
        witness: &mut impl Witness<N>,
    ) -> bool {
        let before = self.track.time;
        let mut changed = false;
        let spacing = setup.parameters.latency / (COPIES - 2) as f64;
        while let Some(&event) = self.events.get(self.taken).filter(|e| e.time <= until) {
            if self.track.time >= self.copies.back().map_or(f64::NEG_INFINITY, |c| c.time) + spacing
            {
                self.keep_copy(setup.parameters.latency);
            }
            let Self { track, events, taken, .. } = self;
            let ahead = || Ahead::among(events.range(*taken..));
            track.take(setup, &event, ahead, witness);
            *taken += 1;
            changed |= !matches!(event.kind, Kind::Imu | Kind::Thrust);
        }
        let Self { track, events, taken, .. } = self;
        track.advance(setup, until + 2e-9, || Ahead::among(events.range(*taken..)), witness);
        if track.time - before > 1.0 {
            // Copies keep the covariance positive; none is made where nothing is measured.
            track.belief.restore_positive();
        }
        changed |= before != self.track.time;
        self.changed |= changed;
        changed
    }

    /// Whether the belief has changed since the last query.
    pub(super) fn take_changed(&mut self) -> bool {
        core::mem::take(&mut self.changed)
    }

    fn keep_copy(&mut self, latency: f64) {
        self.track.belief.restore_positive();
        while self.copies.len() >= COPIES
            || self.copies.get(1).is_some_and(|next| next.time <= self.track.time - latency)
        {
            self.drop_oldest();
        }
        self.copies.push_back(self.track);
    }

    fn drop_oldest(&mut self) {
        self.copies.pop_front();
        if let Some(oldest) = self.copies.front() {
            let key = oldest.key;
            let gone = self.events.partition_point(|e| !earlier(key, e.key())).min(self.taken);
            self.events.drain(..gone);
            self.taken -= gone;
        }
    }

    fn make_room(&mut self) {
        while self.events.len() >= EVENTS && self.copies.len() > 1 {
            self.drop_oldest();
        }
        if self.events.len() >= EVENTS {
            // More events than fit between two copies: the past ends here.
            self.copies.clear();
            self.copies.push_back(self.track);
            self.events.drain(..self.taken);
            self.taken = 0;
            self.events.truncate(EVENTS - 1);
        }
    }
}

impl Ahead {
    /// The samples of the driving signals that come first among events.
    pub(super) fn among<'a>(events: impl IntoIterator<Item = &'a Event>) -> Self {
        let mut ahead = Self::default();
        for event in events {
            match event.kind {
                Kind::Imu if ahead.imu.is_none() => ahead.imu = Some((event.time, event.cut())),
                Kind::Thrust if ahead.thrust.is_none() => {
                    ahead.thrust = Some((event.time, event.cut()));
                }
                Kind::Ahrs if ahead.attitude.is_none() => {
                    ahead.attitude = Some((event.time, event.cut()));
                }
                _ => {}
            }
            if ahead.imu.is_some() && ahead.thrust.is_some() && ahead.attitude.is_some() {
                break;
            }
        }
        ahead
    }
}

fn earlier(a: Key, b: Key) -> bool {
    a.0 < b.0 || (a.0 == b.0 && a.1 < b.1)
}
