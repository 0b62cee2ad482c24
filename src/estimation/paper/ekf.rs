//! One cycle of the filter: predict, then update with the measurements since the last cycle.
//!
//! H = I, so each measurement is a component of the state. With a diagonal R they are fused one
//! after the other, which is equivalent to eqs (50)-(53) at once.

use nalgebra::Vector4;

use super::intake::Source;
use super::memory::{EkfMemory, News, Sources};
use super::prediction::{inertial_acceleration, predict};
use super::{Acceleration, EkfParameters};
use crate::ParameterError;
use crate::attitude;
use crate::error::declared;
use crate::estimation::belief::Belief;
use crate::estimation::sensor::Observation;
use crate::estimation::{Channel, Estimate, Health, Measurements, Navigation};
use crate::sampling::Rate;
use crate::vector::{cross, mul, sub};

/// Standard deviations after the estimate was lost: x, y, z (m) and psi (rad).
const LOST: [f64; 4] = [1e4, 1e4, 1e3, core::f64::consts::PI];
/// Index of x, y, z and psi among x, y, z, roll, pitch, yaw.
const POSE: [usize; 4] = [0, 1, 2, 5];

/// A filter, with its parameters checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Ekf {
    /// How often it runs.
    pub rate: Rate,
    parameters: EkfParameters,
    source: Acceleration,
}

impl Navigation for Ekf {
    type Memory = EkfMemory;

    fn memory(&self) -> EkfMemory {
        let sigma = self.parameters.initial_sigma;
        EkfMemory { belief: self.start(sigma), ..EkfMemory::default() }
    }

    /// One cycle; the first only updates.
    fn take(&self, memory: &mut EkfMemory, now: f64, measured: &Measurements) {
        if now.is_finite() {
            memory.now = now;
        }
        let news = memory.take_new(measured);
        let before = memory.motion;
        self.observe_motion(memory, &news);
        if memory.running {
            predict(&self.parameters, &mut memory.belief, &memory.motion, &before);
        }
        memory.running = true;
        self.fuse_new(memory, &news);
        if !memory.is_finite() {
            self.begin_anew(memory);
        }
    }

    fn estimate(&self, memory: &mut EkfMemory) -> Estimate {
        Self::estimate(self, memory)
    }
}

impl Ekf {
    /// Checks the parameters.
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(parameters: &EkfParameters, source: Acceleration) -> Result<Self, ParameterError> {
        declared(parameters)?;
        let rate = Rate::new(parameters.rate_hz)?;
        Ok(Self { rate, parameters: *parameters, source })
    }

    /// The pose of the start.
    fn start(&self, sigma: [f64; 4]) -> Belief<4> {
        let [x, y, z, yaw] = self.parameters.initial_pose;
        let mean = Vector4::new(x, y, z, attitude::wrap(yaw));
        Belief::new(4, mean, &Vector4::from(sigma), [1.0, 0.0, 0.0, 0.0])
    }

    /// After an overflow: the start values, with an uncertainty that marks them as meaningless.
    fn begin_anew(&self, memory: &mut EkfMemory) {
        *memory = EkfMemory {
            belief: self.start(LOST),
            lost: memory.now,
            now: memory.now,
            sources: memory.sources,
            records: memory.records.map(|record| record.emptied()),
            ..EkfMemory::default()
        };
    }

    /// The estimate, without a cycle.
    #[must_use]
    pub fn estimate(&self, memory: &EkfMemory) -> Estimate {
        let EkfMemory { belief, motion, tilt: [roll, pitch], .. } = memory;
        let [x, y, z, yaw] = belief.mean.into();
        let mut covariance = [[0.0; 6]; 6];
        for (i, &row) in POSE.iter().enumerate() {
            for (j, &column) in POSE.iter().enumerate() {
                covariance[row][column] = belief.covariance[(i, j)];
            }
        }
        let body = |v: [f64; 4]| [v[0], v[1], v[2]];
        let sources = memory.sources.unwrap_or_else(|| Sources::new(memory.now));
        let Sources { ahrs, depth, dvl, fix, .. } = sources;
        let sources = [ahrs, ahrs, depth, dvl, fix];
        Estimate {
            position: [x, y, z],
            euler: [*roll, *pitch, yaw],
            velocity: body(motion.velocity),
            rate: memory.rate,
            acceleration: body(motion.acceleration),
            covariance,
            velocity_sigma: [self.parameters.dvl_sigma; 3],
            channels: core::array::from_fn(|i| memory.records[i].report(&sources[i])),
            health: health(memory, &dvl, &fix),
            ..Estimate::default()
        }
    }

    /// Velocity from DVL (transferred to the centre of gravity) and gyro, acceleration from the
    /// source. Without new values the last ones are used.
    fn observe_motion(&self, memory: &mut EkfMemory, news: &News) {
        let p = &self.parameters;
        let before = memory.motion;
        if let Some([roll, pitch, _]) = news.ahrs {
            memory.tilt = [roll, pitch];
            memory.count(Channel::Tilt);
        }
        if let Some([.., p, q, r]) = news.imu {
            memory.rate = [p, q, r];
            memory.motion.velocity[3] = r;
        }
        if let Some(velocity) = news.dvl {
            // Four degrees of freedom: p and q are zero in the model, and including them would add
            // a gyro bias larger than the correction.
            let lever = cross([0.0, 0.0, memory.motion.velocity[3]], p.mounting.dvl);
            memory.motion.velocity[..3].copy_from_slice(&sub(velocity, lever));
            memory.count(Channel::Dvl);
        }
        let velocity = memory.motion.velocity;
        match (&self.source, news.imu) {
            (Acceleration::Dynamic(model), _) => {
                if let Some(thrust) = &memory.thrust {
                    memory.motion.acceleration = model.acceleration(velocity, thrust);
                }
            }
            (Acceleration::Kinematic, Some([x, y, z, ..])) => {
                let v = [velocity[0], velocity[1], velocity[2]];
                let a = inertial_acceleration(p, [x, y, z], memory.rate, memory.tilt, v);
                memory.motion.acceleration[..3].copy_from_slice(&a);
                let turned = if memory.running { velocity[3] - before.velocity[3] } else { 0.0 };
                memory.motion.acceleration[3] = turned * p.rate_hz;
            }
            (Acceleration::Kinematic, None) => {}
        }
    }

    fn fuse_new(&self, memory: &mut EkfMemory, news: &News) {
        let p = &self.parameters;
        let [roll, pitch] = memory.tilt;
        let r_nb = attitude::rotation_euler([roll, pitch, memory.belief.mean[3]]);
        if let Some([north, east, reported]) = news.fix {
            let lever = mul(&r_nb, p.mounting.fix);
            let pose = &memory.belief.mean;
            let innovation = [north - lever[0] - pose[0], east - lever[1] - pose[1]];
            let sigma = if reported > 0.0 { reported } else { p.fix_sigma };
            memory.fuse(Channel::Fix, &direct(0, innovation, sigma));
        }
        if let Some([depth]) = news.depth {
            let innovation = depth - mul(&r_nb, p.mounting.pressure)[2] - memory.belief.mean[2];
            memory.fuse(Channel::Depth, &direct(2, [innovation], p.depth_sigma));
        }
        if let Some([.., heading]) = news.ahrs {
            let innovation = attitude::wrap(heading - memory.belief.mean[3]);
            memory.fuse(Channel::Heading, &direct(3, [innovation], p.heading_sigma));
        }
    }
}

/// A measurement of the state's components, starting with `first`.
fn direct<const K: usize>(first: usize, innovation: [f64; K], sigma: f64) -> Observation<4> {
    let mut observation = Observation::empty(K);
    for i in 0..K {
        observation.innovation[i] = innovation[i];
        observation.variance[i] = sigma * sigma;
        observation.rows[i][first + i] = 1.0;
    }
    observation
}

fn health(memory: &EkfMemory, dvl: &Source, fix: &Source) -> Health {
    let now = memory.now;
    if now - memory.lost < 30.0 {
        return Health::Diverged;
    }
    if memory.records.iter().any(|record| record.surprises > 0.5) {
        return Health::Inconsistent;
    }
    if now - dvl.arrived > 5.0 && now - fix.arrived > 10.0 {
        return Health::Starved;
    }
    Health::Good
}
