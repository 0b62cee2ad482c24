//! The processes at random means.

use super::compare::*;
use super::draw::*;
use super::oracle::*;
use super::{Check, SMALL};
use num_dual::Dual64;
use proptest::prelude::*;
use rexrov::estimation::belief::Belief;
use rexrov::estimation::interval::Interval;
use rexrov::estimation::process::Process;
use rexrov::estimation::*;

pub(super) const INERTIAL: [(usize, f64); 5] = [(3, 50.0), (3, 2.0), (3, 0.0), (3, 0.3), (3, 0.05)];
pub(super) const AIDED: [(usize, f64); 7] =
    [(2, 0.5), (3, 30.0), (3, 10.0), (1, 20.0), (3, 0.1), (1, 0.01), (1, 0.01)];
pub(super) const PLANAR: [(usize, f64); 6] =
    [(3, 50.0), (1, 3.1), (3, 2.0), (1, 1.0), (2, 0.5), (1, 0.05)];
pub(super) const OU: (usize, f64) = (4, 20.0);
pub(super) const MOVING: [(usize, f64); 5] = [(3, 50.0), (3, 0.0), (3, 2.0), (3, 1.0), (3, 1.0)];

/// An inertial filter, plain or with its aid, at a random mean.
pub(super) struct Strapdown<const N: usize> {
    pub(super) p: NavigationParameters,
    pub(super) process: InertialProcess,
    pub(super) aid: ModelAid,
    pub(super) hull: Hull,
    pub(super) times: Option<[f64; 2]>,
    pub(super) belief: Belief<N>,
    pub(super) order: usize,
    pub(super) before: Interval,
    pub(super) interval: Interval,
}

impl<const N: usize> Strapdown<N> {
    pub(super) fn new(numbers: &[f64], aided: bool, imu: bool) -> Self {
        let mut draw = Draw(numbers.iter());
        let (p, vehicle) = (draw.parameters(), draw.vehicle());
        let errors = ModelErrors::default();
        let aid = ModelAid::new(&vehicle, &errors).unwrap();
        let process = InertialProcess::new(&p, aided.then(|| aid.clone())).unwrap();
        let order = BASE + 4 + if aided { AID } else { 0 };
        let mut sizes = INERTIAL.to_vec();
        if aided {
            sizes.extend(AIDED);
        }
        sizes.push(OF_SENSORS);
        let mut interval = draw.interval();
        let before = draw.interval();
        if !imu {
            interval.inertial = None;
        }
        let times = aided.then_some([errors.disturbances.correlation_time, errors.slow_force_time]);
        let belief = draw.belief(order, &sizes);
        let hull = Hull::new(&vehicle);
        Self { p, process, aid, hull, times, belief, order, before, interval }
    }

    pub(super) fn mean(&self) -> Point<f64, N> {
        point(&self.belief, Some(6))
    }

    pub(super) fn prediction(&self) -> Check {
        let (mut predicted, mut tape) = (self.belief, Tape::default());
        self.process.predict(&mut predicted, &self.interval, &mut tape);
        let mut mean = self.mean();
        let mut transitions = tape.transitions.iter();
        if self.times.is_some() {
            let f = transitions.next().unwrap();
            close_rows("renewal", &rows_of(f), &mean.transition(renew), self.order)?;
            mean = renew(&mean);
        }
        let forward =
            |m: &Point<Dual64, N>| inertial(m, &self.interval, self.p.gravity, self.times);
        let f = transitions.next().unwrap();
        prop_assert!(transitions.next().is_none());
        close_points(
            &predicted,
            &inertial(&mean, &self.interval, self.p.gravity, self.times),
            None,
        )?;
        close_rows("F", &rows_of(f), &mean.transition(forward), self.order)
    }

    pub(super) fn sensors(&self) -> Check {
        let motion = self.process.kinematics(&self.belief, &self.interval);
        let base = self.order - 4;
        let restated =
            |m: &Point<Dual64, N>| inertial_motion(m, &self.interval, self.p.gravity, base);
        kinematics(&motion, self.order, &self.mean(), restated)?;
        sensors(&self.p, false, &motion, self.order, &self.mean(), restated)
    }
}

/// The planar filter at a random mean.
pub(super) struct Planar {
    pub(super) p: NavigationParameters,
    pub(super) d: Disturbances,
    pub(super) process: PlanarDynamic,
    pub(super) hull: Hull,
    pub(super) belief: Belief<SMALL>,
    pub(super) interval: Interval,
}

impl Planar {
    pub(super) fn new(numbers: &[f64], thrust: bool) -> Self {
        let mut draw = Draw(numbers.iter());
        let (p, vehicle, d) = (draw.parameters(), draw.vehicle(), Disturbances::default());
        let process = PlanarDynamic::new(&p, &vehicle, &d).unwrap();
        let belief = draw.belief(SMALL, &[&PLANAR[..], &[OU, OF_SENSORS]].concat());
        let mut interval = draw.interval();
        if !thrust {
            interval.thrust = None;
        }
        Self { p, d, process, hull: Hull::new(&vehicle), belief, interval }
    }

    pub(super) fn mean(&self) -> Point<f64, SMALL> {
        Point { q: [1.0, 0.0, 0.0, 0.0], ..point(&self.belief, None) }
    }

    pub(super) fn motion(&self) -> impl Fn(&Point<Dual64, SMALL>) -> Motion<Dual64> {
        |m| self.hull.planar_motion(m, &self.interval)
    }

    pub(super) fn sensors(&self) -> Check {
        let motion = self.process.kinematics(&self.belief, &self.interval);
        kinematics(&motion, SMALL, &self.mean(), self.motion())?;
        sensors(&self.p, true, &motion, SMALL, &self.mean(), self.motion())
    }
}

pub(super) struct Constant {
    pub(super) p: NavigationParameters,
    pub(super) process: ConstantAcceleration,
    pub(super) belief: Belief<SMALL>,
    pub(super) interval: Interval,
}

impl Constant {
    pub(super) fn new(numbers: &[f64]) -> Self {
        let mut draw = Draw(numbers.iter());
        let p = draw.parameters();
        let process = ConstantAcceleration::new(&p).unwrap();
        let belief = draw.belief(SMALL, &[&MOVING[..], &[OF_SENSORS]].concat());
        let interval = draw.interval();
        Self { p, process, belief, interval }
    }

    pub(super) fn mean(&self) -> Point<f64, SMALL> {
        point(&self.belief, Some(3))
    }

    pub(super) fn sensors(&self) -> Check {
        let motion = self.process.kinematics(&self.belief, &self.interval);
        kinematics(&motion, SMALL, &self.mean(), constant_acceleration_motion)?;
        sensors(&self.p, false, &motion, SMALL, &self.mean(), constant_acceleration_motion)
    }
}
