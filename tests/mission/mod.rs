//! Simulated missions for tests of estimators: the full vehicle follows a course on its true pose
//! and velocity, so that its path does not depend on a filter, and every sensor is recorded.
//!
//! Each random quantity draws from its own stream: changing one option leaves the noise of
//! everything else as it was. All instants are exact to the nanosecond.
#![allow(
    dead_code,
    unreachable_pub,
    unused_imports,
    reason = "each test binary uses a part of this module"
)]

mod faults;
mod flight;
mod instruments;
mod options;
mod plant;

pub use faults::*;
pub use flight::fly;
pub use options::*;

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Position of the DVL, body (m).
pub const DVL_POSITION: [f64; 3] = [-1.4, 0.0, 0.312];
/// Position of the pressure sensor, body (m).
pub const DEPTH_POSITION: [f64; 3] = [-1.32, -0.5, -0.85];

/// True motion of the centre of gravity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// (s)
    pub time: f64,
    /// NED (m).
    pub position: [f64; 3],
    /// Roll, pitch, yaw (rad).
    pub euler: [f64; 3],
    /// Body to NED, of unit length.
    pub quaternion: [f64; 4],
    /// Velocity over ground, body (m/s, rad/s).
    pub nu: [f64; 6],
    /// North and east (m/s).
    pub current: [f64; 2],
}

/// The output of a sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Data {
    /// At the centre of gravity, body (m/s2, rad/s), 50 Hz.
    Imu { specific_force: [f64; 3], rate: [f64; 3] },
    /// Thrusts by the measured rotor speeds (N), at the instants of the IMU.
    Thrust([f64; 8]),
    /// Roll, pitch, yaw (rad).
    Ahrs([f64; 3]),
    /// Velocity over ground at [`DVL_POSITION`], body axes (m/s).
    Dvl([f64; 3]),
    /// North and east of the centre of gravity (m).
    Fix([f64; 2]),
    /// Of the sensor at [`DEPTH_POSITION`] (m).
    Depth(f64),
}

/// Which sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Imu,
    Thrust,
    Ahrs,
    Dvl,
    Fix,
    Depth,
}

impl Data {
    pub fn kind(&self) -> Kind {
        match self {
            Self::Imu { .. } => Kind::Imu,
            Self::Thrust(_) => Kind::Thrust,
            Self::Ahrs(_) => Kind::Ahrs,
            Self::Dvl(_) => Kind::Dvl,
            Self::Fix(_) => Kind::Fix,
            Self::Depth(_) => Kind::Depth,
        }
    }
}

/// A sample on its way to the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// The time of measurement according to the sensor (s).
    pub stamp: f64,
    /// When the filter sees it (s): the stamp, unless a fault changes either.
    pub arrival: f64,
    pub data: Data,
}

/// A completed mission.
#[derive(Clone, Debug, PartialEq)]
pub struct Mission {
    /// At t = 0, 0.1 s, ...
    pub truth: Vec<Truth>,
    /// By arrival, then stamp; of the same instant in the order of [`Data`].
    pub events: Vec<Event>,
    /// Initial error of a filter's position (m), north and east: 0.5 m each.
    pub initial_error: [f64; 2],
    /// The end of the course was reached.
    pub finished: bool,
}

impl Mission {
    /// The truth at a multiple of 0.1 s.
    pub fn truth_at(&self, time: f64) -> &Truth {
        let truth = &self.truth[(time * 10.0).round() as usize];
        assert!((truth.time - time).abs() < 1e-9, "no truth is recorded at {time} s");
        truth
    }
}

/// `run` for each seed over two threads, results in the order of the seeds.
pub fn parallel<T: Send>(
    seeds: impl IntoIterator<Item = u64>,
    run: impl Fn(u64) -> T + Sync,
) -> Vec<T> {
    let seeds: Vec<u64> = seeds.into_iter().collect();
    let results = Mutex::new(Vec::new());
    let next = AtomicUsize::new(0);
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(&seed) = seeds.get(index) else { break };
            let result = run(seed);
            results.lock().unwrap().push((index, result));
        }
    };
    std::thread::scope(|scope| {
        scope.spawn(work);
        work();
    });
    let mut results = results.into_inner().unwrap();
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}
