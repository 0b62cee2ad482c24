//! A filter at an instant: its belief, the signals that drive it, and the record of each sensor.
//!
//! All of it changes only by events in the order of their times, so going back to an earlier copy
//! and repeating the events gives the same result as if all of them had come in time.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::belief::{Belief, Column};
use super::interval::{Inertial, Interval, SAME, Stream, Thrusts};
use super::kalman::{Both, GATE, Verdict, Witness, absorb, fuse};
use super::kinematics::{Kinematics, Motion, skew};
use super::measurement::{Event, Key, Kind};
use super::monitor::Monitor;
use super::parameters::NavigationParameters;
use super::process::Process;
use super::recovery::{Agreement, Hidden, follow_unobservable, hand_to_bias, hidden, reacquire};
use super::sensor::{Depth, Dvl, Fix, Heading, Observation, Sensor, Tilt};
use super::turning::Tracker;
use crate::attitude;

/// Sensors whose innovations are monitored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Roll and pitch.
    Tilt,
    /// Compass.
    Heading,
    /// Pressure.
    Depth,
    /// Velocity log.
    Dvl,
    /// Position fix.
    Fix,
}

/// How many channels there are.
pub const CHANNELS: usize = 5;

/// The record of a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Record {
    /// Innovation of the newest measurement.
    pub(super) innovation: [f64; 3],
    /// Its standard deviation as predicted.
    pub(super) sigma: [f64; 3],
    /// Its normalised innovation squared.
    pub(super) nis: f64,
    /// Measurements fused, including limited ones.
    pub(super) used: u32,
    /// Measurements whose influence was limited.
    pub(super) rejected: u32,
    /// Recent share that was limited, over some twenty measurements.
    pub(super) limited_share: f64,
    /// Time of the newest measurement (s).
    pub(super) newest: f64,
    pub(super) agreement: Agreement,
}

/// Standard deviation of the position of a lost vehicle (m).
const LOST_SIGMA: f64 = 1e4;

/// A filter at an instant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Track<const N: usize, M> {
    /// The instant (s).
    pub(super) time: f64,
    /// The last event included in it.
    pub(super) key: Key,
    pub(super) belief: Belief<N>,
    imu: Stream<6>,
    thrust: Stream<8>,
    turning: Tracker,
    before: Interval,
    pub(super) interval: Interval,
    pub(super) records: [Record; CHANNELS],
    /// Share of its thrust that each thruster gives.
    pub(super) effectiveness: [f64; 8],
    aligned: bool,
    /// What the velocity log could not observe at its newest sample, if the velocity coasted since
    /// then.
    hidden: Option<Hidden>,
    monitor: M,
}

/// The next samples, which a boundary between two samples needs.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ahead {
    pub(super) imu: Option<(f64, [f64; 6])>,
    pub(super) thrust: Option<(f64, [f64; 8])>,
    pub(super) attitude: Option<(f64, [f64; 3])>,
}

/// The constant part: the process and the sensor models.
#[derive(Clone, Debug)]
pub(super) struct Setup<P> {
    pub(super) process: P,
    pub(super) parameters: NavigationParameters,
    tilt: Tilt,
    heading: Heading,
    depth: Depth,
    dvl: Dvl,
    fix: Fix,
}

impl<P> Setup<P> {
    pub(super) fn new(process: P, parameters: &NavigationParameters) -> Self {
        let (s, m) = (&parameters.sensors, &parameters.mounting);
        Self {
            process,
            parameters: *parameters,
            tilt: Tilt { sigma: s.tilt_sigma },
            heading: Heading { sigma: s.heading_sigma },
            depth: Depth { lever: m.pressure.into(), sigma: s.depth_sigma },
            dvl: Dvl { lever: m.dvl.into(), sigma: s.dvl_sigma },
            fix: Fix { lever: m.fix.into(), sigma: s.fix_sigma },
        }
    }

    /// Whether the clocks of velocity log and attitude are compared: forward of the centre of
    /// gravity a log's lever arm hides the slip.
    pub(super) fn watches_clocks(&self) -> bool {
        self.parameters.gated && self.parameters.mounting.dvl[0] <= 0.0
    }
}

impl<const N: usize, M: Monitor<N>> Track<N, M> {
    pub(super) fn new<P: Process<N>>(setup: &Setup<P>, start: f64) -> Self {
        let mut monitor = M::default();
        monitor.prepare(&core::array::from_fn(|i| setup.process.thrust_effect(i)));
        let [roll, pitch, _] = setup.parameters.start.attitude;
        let tilt = attitude::rotation_euler([roll, pitch, 0.0]);
        let sensors = &setup.parameters.sensors;
        Self {
            time: start,
            key: (f64::NEG_INFINITY, Kind::Imu),
            belief: setup.process.initial(),
            imu: Stream::new(start),
            thrust: Stream::new(start),
            turning: Tracker::new(sensors.heading_sigma.max(sensors.tilt_sigma)),
            before: Interval::default(),
            interval: Interval { end: start, tilt, ..Interval::default() },
            records: [Record { newest: f64::NEG_INFINITY, ..Record::default() }; CHANNELS],
            effectiveness: [1.0; 8],
            aligned: setup.parameters.start.heading_sigma < 0.5,
            hidden: None,
            monitor,
        }
    }

    /// As at the start, but with unknown position and heading.
    pub(super) fn lost<P: Process<N>>(setup: &Setup<P>, start: f64) -> Self {
        let mut track = Self { aligned: false, ..Self::new(setup, start) };
        (0..2).for_each(|i| track.belief.decouple(i, LOST_SIGMA * LOST_SIGMA));
        track
    }

    /// Takes an event that is not earlier than any previous one.
    pub(super) fn take<P: Process<N>>(
        &mut self,
        setup: &Setup<P>,
        event: &Event,
        ahead: impl Fn() -> Ahead + Copy,
        witness: &mut impl Witness<N>,
    ) {
        self.advance(setup, event.time, ahead, witness);
        self.key = event.key();
        match event.kind {
            Kind::Imu => self.imu.push(event.time, event.cut()),
            Kind::Thrust => self.thrust.push(event.time, event.cut()),
            Kind::Ahrs => {
                self.predict_to(setup, event.time, ahead, witness);
                if self.interval.inertial.is_some() {
                    self.turning.stand_by(event.time, event.cut());
                } else {
                    self.turning.hear(event.time, event.cut());
                    self.interval.turning = self.turning.newest();
                }
                self.fuse_attitude(setup, event.cut(), witness);
            }
            Kind::Depth => {
                self.predict_to(setup, event.time, ahead, witness);
                let observe = |m: &Kinematics<N>| setup.depth.observe(&event.cut(), m);
                self.fuse(setup, Channel::Depth, observe, witness);
            }
            Kind::Dvl => {
                self.predict_to(setup, event.time, ahead, witness);
                let observe = |m: &Kinematics<N>| setup.dvl.observe(&event.cut(), m);
                self.fuse(setup, Channel::Dvl, observe, witness);
            }
            Kind::Fix => {
                self.predict_to(setup, event.time, ahead, witness);
                let observe = |m: &Kinematics<N>| setup.fix.observe(&event.cut(), m);
                self.fuse(setup, Channel::Fix, observe, witness);
            }
            Kind::Effectiveness => self.effectiveness = event.value,
            Kind::Displacement => {
                let [by_north, by_east, north, east] = event.cut();
                let mut within = Column::<N>::zeros();
                (within[0], within[1]) = (north, east);
                self.belief.mean[0] += by_north;
                self.belief.mean[1] += by_east;
                self.belief.widen(&within);
            }
        }
    }

    /// Predicts to every multiple of the longest interval before `time`.
    pub(super) fn advance<P: Process<N>>(
        &mut self,
        setup: &Setup<P>,
        time: f64,
        ahead: impl Fn() -> Ahead + Copy,
        witness: &mut impl Witness<N>,
    ) {
        if time - self.time <= SAME {
            return;
        }
        let grid = setup.parameters.interval;
        loop {
            let next = (libm::floor(self.time / grid + 1e-6) + 1.0) * grid;
            if next >= time - SAME {
                return;
            }
            self.predict_to(setup, next, ahead, witness);
        }
    }

    /// Predicts to an instant.
    pub(super) fn predict_to<P: Process<N>>(
        &mut self,
        setup: &Setup<P>,
        time: f64,
        ahead: impl Fn() -> Ahead + Copy,
        witness: &mut impl Witness<N>,
    ) {
        // An event at an instant of the grid is processed there, to the last bit, whichever comes
        // first.
        let grid = setup.parameters.interval;
        let nearest = libm::round(time / grid) * grid;
        let time = if (time - nearest).abs() < SAME { nearest } else { time };
        let dt = time - self.time;
        if dt < SAME {
            return;
        }
        let ahead = ahead();
        let imu = self.imu.close(time, ahead.imu);
        let thrust = self.thrust.close(time, ahead.thrust);
        self.before = self.interval;
        self.interval = Interval {
            end: time,
            dt,
            inertial: imu.map(|mean| {
                let [a, b, c, p, q, r] = mean.value;
                let rate = [p, q, r];
                let force = self.at_centre(setup, [a, b, c], rate, dt);
                Inertial {
                    specific_force: force,
                    rate,
                    rate_end: [mean.end[3], mean.end[4], mean.end[5]],
                }
            }),
            thrust: thrust.map(|mean| {
                let effective =
                    |f: [f64; 8]| core::array::from_fn(|i| f[i] * self.effectiveness[i]);
                Thrusts { mean: effective(mean.value), rising: effective(mean.rising) }
            }),
            turning: match imu {
                Some(_) => None,
                None => self.turning.until(time, ahead.attitude),
            },
            tilt: self.before.tilt,
        };
        let process = &setup.process;
        let mut witness = Both(&mut self.monitor, witness);
        process.predict(&mut self.belief, &self.interval, &mut witness);
        process.aid(&mut self.belief, &self.before, &self.interval, &mut witness);
        if let Some(f) = self.belief.confine() {
            witness.given_up(&f);
        }
        self.time = time;
        if let Some(alarm) = self.monitor.judge(time) {
            process.correct(&mut self.belief, &alarm.correction);
            self.belief.widen(&alarm.widening);
            self.effectiveness[alarm.thruster] *= 1.0 - alarm.share;
        }
    }

    /// The specific force at the centre of gravity, without the effect of rotation at the inertial
    /// unit.
    fn at_centre<P>(&self, setup: &Setup<P>, force: [f64; 3], rate: [f64; 3], dt: f64) -> [f64; 3] {
        let lever = Vector3::from(setup.parameters.mounting.imu);
        if lever == Vector3::zeros() {
            return force;
        }
        let omega = Vector3::from(rate);
        let angular = match &self.interval.inertial {
            Some(last) => (omega - Vector3::from(last.rate)) * (2.0 / (dt + self.interval.dt)),
            None => Vector3::zeros(),
        };
        let spin = skew(&omega);
        (Vector3::from(force) - angular.cross(&lever) - spin * spin * lever).into()
    }

    /// Uses the first attitude for the start, if the start does not define the heading.
    pub(super) fn align<P: Process<N>>(&mut self, setup: &Setup<P>, euler: [f64; 3]) {
        if !self.aligned {
            setup.process.align(&mut self.belief, euler);
            self.aligned = true;
        }
    }

    fn fuse_attitude<P: Process<N>>(
        &mut self,
        setup: &Setup<P>,
        euler: [f64; 3],
        witness: &mut impl Witness<N>,
    ) {
        self.align(setup, euler);
        if setup.process.tilt_is_input() {
            self.interval.tilt = attitude::rotation_euler([euler[0], euler[1], 0.0]);
        } else {
            self.fuse(setup, Channel::Tilt, |m| setup.tilt.observe(&euler, m), witness);
        }
        self.fuse(setup, Channel::Heading, |m| setup.heading.observe(&euler, m), witness);
    }

    fn fuse<P: Process<N>>(
        &mut self,
        setup: &Setup<P>,
        channel: Channel,
        observe: impl Fn(&Kinematics<N>) -> Observation<N>,
        witness: &mut impl Witness<N>,
    ) {
        let process = &setup.process;
        let motion = process.kinematics(&self.belief, &self.interval);
        let observation = observe(&motion);
        let mut witness = Both(&mut self.monitor, witness);
        let states = motion.sensors.of_dvl();
        let coasting = channel == Channel::Dvl && process.coasts(&self.interval);
        let before =
            if coasting { hidden(process.velocity(), &observation.rows, &states) } else { None };
        let last = if channel == Channel::Dvl { self.hidden.take() } else { None };
        if let (Some(last), Some(before)) = (&last, &before) {
            let f = follow_unobservable(process.velocity(), [last, before], &states);
            self.belief.propagate(&f);
            witness.predicted(&f);
        }
        let gate = if setup.parameters.gated { GATE[observation.size - 1] } else { f64::INFINITY };
        let mut verdict = Verdict::new();
        verdict.judge(&self.belief, &observation, gate);
        let record = &mut self.records[channel as usize];
        record.note(&observation, &verdict, self.time);
        if record.agreement.hear(channel, &observation, verdict.is_limited()) {
            record.agreement = Agreement::default();
            if channel == Channel::Heading && motion.sensors.heading_bias.is_some() {
                // The measurement has defined the bias; it contains no further information.
                witness.given_up(&hand_to_bias(&mut self.belief, &motion, &observation));
                return;
            }
            let f = reacquire(&mut self.belief, channel, process.velocity(), &observation);
            witness.given_up(&f);
            let observation = observe(&process.kinematics(&self.belief, &self.interval));
            let correction = fuse(&mut self.belief, &observation, f64::INFINITY, &mut witness);
            process.correct(&mut self.belief, &correction);
            return;
        }
        if verdict.is_limited()
            && channel == Channel::Heading
            && motion.sensors.heading_bias.is_some()
        {
            // More likely a disturbed compass than a wrong heading: it will be attributed to the
            // bias.
            return;
        }
        let correction = absorb(&mut self.belief, &observation, &mut verdict, &mut witness);
        process.correct(&mut self.belief, &correction);
        if let Some(before) = &before {
            let after = observe(&process.kinematics(&self.belief, &self.interval));
            self.hidden = hidden(process.velocity(), &after.rows, &states);
            if let Some(after) = &self.hidden {
                let f = follow_unobservable(process.velocity(), [before, after], &states);
                self.belief.propagate(&f);
                witness.predicted(&f);
            }
        }
    }

    /// The motion at an instant after the track's, from the newest samples.
    pub(super) fn motion_at<P: Process<N>>(&self, setup: &Setup<P>, now: f64) -> Motion {
        let interval = &self.interval;
        let motion = match self.imu.so_far() {
            None => setup.process.motion(&self.belief, interval),
            Some(mean) => {
                let [a, b, c, p, q, r] = mean.value;
                let rate = [p, q, r];
                let force = self.at_centre(setup, [a, b, c], rate, interval.dt);
                let rate_end = [mean.end[3], mean.end[4], mean.end[5]];
                let inertial = Some(Inertial { specific_force: force, rate, rate_end });
                setup.process.motion(&self.belief, &Interval { inertial, ..*interval })
            }
        };
        let lag = now - self.time;
        if lag > SAME { motion.after(lag) } else { motion }
    }
}

impl Record {
    fn note<const N: usize>(&mut self, o: &Observation<N>, verdict: &Verdict<N>, time: f64) {
        self.innovation = [0.0; 3];
        self.innovation[..o.size].copy_from_slice(&o.innovation[..o.size]);
        self.nis = verdict.nis;
        self.used = self.used.saturating_add(1);
        self.rejected = self.rejected.saturating_add(u32::from(verdict.is_limited()));
        self.limited_share +=
            (f64::from(u8::from(verdict.is_limited())) - self.limited_share) / 20.0;
        self.newest = time;
        self.sigma = verdict.sigma;
    }
}
