//! The smoother: estimates every instant of a recorded mission from the whole recording.
//!
//! A filter goes through the samples in the order of their stamps, and a [`Tape`] stores the
//! transition of every prediction and the gain and innovation of every scalar measurement. Running
//! backwards over the tape, the modified Bryson-Frazier recursion (Bierman 1977, ch. X) accumulates
//! the information of later measurements in an adjoint lambda and its covariance Lambda:
//!
//! | step | lambda | Lambda |
//! |---|---|---|
//! | measurement | `l - h (K^T l + y/S)` | `L - h (L K)^T - (L K) h^T + (K^T L K + 1/S) h h^T` |
//! | prediction | `F^T l` | `F^T L F` |
//!
//! The smoothed error state is `-P l` with covariance `P - P L P`. No matrix is inverted, so
//! exactly known states do no harm. Where a filter discards states, to re-acquire or because they
//! are useless, F has rows that are zero or small, and later measurements contribute
//! correspondingly less about the earlier states.

use nalgebra::SMatrix;

use super::belief::{Belief, Column, Row};
use super::clocks::Clocks;
use super::estimate::{Estimate, describe};
use super::filter::Filter;
use super::intake::{Sources, take_new};
use super::interval::{Interval, SAME};
use super::kalman::Witness;
use super::measurement::{Event, Kind, Measurements};
use super::monitor::Monitor;
use super::process::Process;
use super::track::{Ahead, Setup, Track};
use super::transition::Transition;
use super::turning::ATTITUDE_GAP;

/// Steps covered by one tape; the filter runs through each twice.
const SEGMENT: usize = 2048;
/// How far ahead of an instant samples are searched (s).
const AHEAD: f64 = ATTITUDE_GAP;

/// The smoothed estimate at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smoothed {
    /// The instant (s): a multiple of the filter's interval.
    pub time: f64,
    /// The estimate, without channels, health and thrusters.
    pub estimate: Estimate,
}

/// The interface of a smoother, whatever filter is inside.
pub trait Smoothing {
    /// An empty recording for the filter's latency.
    fn recording(&self) -> Recording;

    /// Smooths a mission; returns the estimate at every multiple of the interval within it.
    ///
    /// There are no late measurements here: all are processed in the order of their stamps. If the
    /// start does not define the heading, the first attitude is used for the start.
    fn smooth(&self, recording: &Recording) -> Vec<Smoothed>;
}

/// The samples of a mission, checked for being new and valid as in a filter.
#[derive(Clone, Debug)]
pub struct Recording {
    events: Vec<Event>,
    sources: Sources,
    latency: f64,
}

impl Recording {
    /// Adds the readings of the instruments at time `now` (s), which does not go back.
    pub fn add(&mut self, now: f64, measured: &Measurements) {
        let Self { events, sources, latency } = self;
        take_new(sources, now, measured, *latency, |event| events.push(event));
    }

    /// How many samples of a kind there are, and how many more were invalid.
    #[must_use]
    pub fn count(&self, kind: Kind) -> (usize, u32) {
        let fit = self.events.iter().filter(|event| event.kind == kind).count();
        (fit, self.sources[kind as usize].invalid)
    }

    /// By stamp; of samples with the same stamp the first.
    fn in_order<P>(&self, setup: &Setup<P>) -> Vec<Event> {
        let mut events = self.events.clone();
        let sort = |events: &mut Vec<Event>| {
            events.sort_by(|a, b| a.time.total_cmp(&b.time).then(a.kind.cmp(&b.kind)));
        };
        sort(&mut events);
        events.dedup_by(|a, b| a.key() == b.key());
        if setup.watches_clocks() && events.iter().all(|event| event.kind != Kind::Imu) {
            let mut clocks = Clocks::default();
            for event in &events {
                clocks.hear(event);
            }
            let logs = events.iter_mut().filter(|event| event.kind == Kind::Dvl);
            logs.for_each(|event| event.time += clocks.lead());
            sort(&mut events);
        }
        events
    }
}

impl<P: Process<N>, const N: usize, M: Monitor<N>> Smoothing for Filter<P, N, M> {
    fn recording(&self) -> Recording {
        let latency = self.setup.parameters.latency;
        Recording { events: Vec::new(), sources: Sources::default(), latency }
    }

    fn smooth(&self, recording: &Recording) -> Vec<Smoothed> {
        let setup = &self.setup;
        let events = recording.in_order(setup);
        let Some(first) = events.first() else { return Vec::new() };
        let mut player = Player::<N, M>::new(setup, &events, first.time);
        let mut beginnings = vec![player];
        while player.play(setup, &events, &mut ()) {
            player.track.belief.restore_positive();
            beginnings.push(player);
        }
        let mut adjoint = Adjoint::zero();
        let mut path = Vec::new();
        while let Some(mut player) = beginnings.pop() {
            let mut tape = Tape::new();
            player.play(setup, &events, &mut tape);
            adjoint.unwind(tape, |time, interval, belief, correction| {
                setup.process.correct(belief, correction);
                path.push(Smoothed { time, estimate: describe(setup, belief, interval) });
            });
        }
        path.reverse();
        path
    }
}

impl<P: Process<N>, const N: usize, M: Monitor<N>> Filter<P, N, M> {
    /// Adds the monitor's findings about the thrusters, with their times, to a recording.
    pub(super) fn watch(&self, recording: &mut Recording) {
        let events = recording.in_order(&self.setup);
        let Some(first) = events.first() else { return };
        let mut player = Player::<N, M>::new(&self.setup, &events, first.time);
        let mut before = player.track.effectiveness;
        while player.step(&self.setup, &events, &mut ()) {
            let value = player.track.effectiveness;
            if value != before {
                before = value;
                let time = player.track.time;
                recording.events.push(Event { time, kind: Kind::Effectiveness, value });
            }
        }
    }
}

/// Observes, and keeps the filter's belief at the requested instants.
trait Keeper<const N: usize>: Witness<N> {
    fn keep(&mut self, time: f64, interval: &Interval, belief: &Belief<N>) {
        let _ = (time, interval, belief);
    }
}

impl<const N: usize> Keeper<N> for () {}

/// A filter on its way through the events.
#[derive(Clone, Copy)]
struct Player<const N: usize, M> {
    track: Track<N, M>,
    /// The next event, and the next multiple of the interval.
    next: usize,
    tick: f64,
}

impl<const N: usize, M: Monitor<N>> Player<N, M> {
    fn new<P: Process<N>>(setup: &Setup<P>, events: &[Event], start: f64) -> Self {
        let mut track = Track::new(setup, start);
        if let Some(attitude) = events.iter().find(|event| event.kind == Kind::Ahrs) {
            track.align(setup, attitude.cut());
        }
        Self { track, next: 0, tick: libm::ceil(start / setup.parameters.interval - 1e-6) }
    }

    /// Processes a segment; false at the end of the events.
    fn play<P: Process<N>>(
        &mut self,
        setup: &Setup<P>,
        events: &[Event],
        keeper: &mut impl Keeper<N>,
    ) -> bool {
        (0..SEGMENT).all(|_| self.step(setup, events, keeper))
    }

    fn step<P: Process<N>>(
        &mut self,
        setup: &Setup<P>,
        events: &[Event],
        keeper: &mut impl Keeper<N>,
    ) -> bool {
        let rest = &events[self.next..];
        let end = match (rest.first(), events.last()) {
            (Some(event), _) => event.time - SAME,
            (None, Some(last)) => last.time + SAME,
            (None, None) => return false,
        };
        let near = rest.partition_point(|event| event.time <= end + AHEAD);
        let ahead = || Ahead::among(&rest[..near]);
        let instant = self.tick * setup.parameters.interval;
        if instant < end {
            self.track.predict_to(setup, instant, ahead, keeper);
            let Track { time, interval, belief, .. } = &self.track;
            keeper.keep(*time, interval, belief);
            self.tick += 1.0;
        } else if let Some(event) = rest.first() {
            self.track.take(setup, event, ahead, keeper);
            self.next += 1;
        } else {
            return false;
        }
        if !self.track.belief.is_finite() {
            self.track = Track::lost(setup, self.track.time);
            let mut nothing = Transition::identity();
            (0..N).for_each(|state| nothing.scale(state, 0.0));
            keeper.given_up(&nothing);
        }
        true
    }
}

/// What happened to a belief, in order.
struct Tape<const N: usize> {
    steps: Vec<Step<N>>,
}

enum Step<const N: usize> {
    /// The errors were propagated.
    Propagated(Box<Transition<N>>),
    /// A scalar measurement was fused.
    Measured(Box<Measured<N>>),
    /// The belief at a requested instant.
    Instant(Box<(f64, Interval, Belief<N>)>),
}

struct Measured<const N: usize> {
    row: Row<N>,
    gain: Column<N>,
    innovation: f64,
    s: f64,
}

impl<const N: usize> Tape<N> {
    fn new() -> Self {
        Self { steps: Vec::with_capacity(8 * SEGMENT) }
    }
}

impl<const N: usize> Witness<N> for Tape<N> {
    fn predicted(&mut self, f: &Transition<N>) {
        self.steps.push(Step::Propagated(Box::new(*f)));
    }

    fn updated(&mut self, row: &Row<N>, gain: &Column<N>, innovation: f64, s: f64) {
        let measured = Measured { row: *row, gain: *gain, innovation, s };
        self.steps.push(Step::Measured(Box::new(measured)));
    }

    fn given_up(&mut self, f: &Transition<N>) {
        self.predicted(f);
    }
}

impl<const N: usize> Keeper<N> for Tape<N> {
    fn keep(&mut self, time: f64, interval: &Interval, belief: &Belief<N>) {
        self.steps.push(Step::Instant(Box::new((time, *interval, *belief))));
    }
}

/// The information of later measurements about an instant.
struct Adjoint<const N: usize> {
    lambda: Column<N>,
    covariance: SMatrix<f64, N, N>,
}

impl<const N: usize> Adjoint<N> {
    fn zero() -> Self {
        Self { lambda: Column::zeros(), covariance: SMatrix::zeros() }
    }

    /// Runs backwards over a tape. `take` receives each instant: its belief with the smoothed
    /// covariance, and the correction of the mean.
    fn unwind(
        &mut self,
        tape: Tape<N>,
        mut take: impl FnMut(f64, &Interval, &mut Belief<N>, &Column<N>),
    ) {
        for step in tape.steps.into_iter().rev() {
            match step {
                Step::Propagated(f) => self.before_transition(&f),
                Step::Measured(m) => self.before_measurement(&m),
                Step::Instant(kept) => {
                    let (time, interval, mut belief) = *kept;
                    if !self.is_finite() {
                        *self = Self::zero();
                    }
                    let p = belief.covariance;
                    let mut correction = -(p * self.lambda);
                    let reduction = p * self.covariance * p;
                    belief.covariance -= (reduction + reduction.transpose()) * 0.5;
                    belief.restore_positive();
                    if !belief.is_positive() {
                        // Beyond rounding: claim what the filter itself knew, and no more.
                        belief.covariance = p;
                        correction.fill(0.0);
                    }
                    take(time, &interval, &mut belief, &correction);
                }
            }
        }
    }

    fn before_transition(&mut self, f: &Transition<N>) {
        self.lambda = f.apply_transposed(&self.lambda);
        let mut transposed = self.covariance;
        for _ in 0..2 {
            for mut column in transposed.column_iter_mut() {
                let image = f.apply_transposed(&column.clone_owned());
                column.copy_from(&image);
            }
            transposed = transposed.transpose();
        }
        // No measurement would ever reduce an antisymmetric part caused by rounding.
        self.covariance = (transposed + transposed.transpose()) * 0.5;
    }

    fn before_measurement(&mut self, m: &Measured<N>) {
        let seen = self.covariance * m.gain;
        let information = m.gain.dot(&seen) + 1.0 / m.s;
        // h c^T + c h^T with c = information h / 2 - L K: only the rows of h change.
        let change = m.row.dense() * (0.5 * information) - seen;
        for (i, h) in m.row.iter() {
            for j in 0..N {
                self.covariance[(i, j)] += h * change[j];
                self.covariance[(j, i)] += h * change[j];
            }
        }
        self.lambda -= m.row.dense() * (m.gain.dot(&self.lambda) + m.innovation / m.s);
    }

    fn is_finite(&self) -> bool {
        self.lambda.iter().chain(self.covariance.iter()).all(|x| x.is_finite())
    }
}
