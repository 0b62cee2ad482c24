//! The Cramér-Rao bound along a mission.

use super::SETTLED;
use crate::mission::{Data, Options, fly};
use crate::scoring::parameters;
use crate::statistics::mean;
use nalgebra::{Matrix3, Vector3};
use rexrov::attitude::rotation;
use rexrov::estimation::bound::{InertialBound, Limits, TrueMotion};

/// The bound at each tenth of a second.
pub fn bound(options: &Options) -> Vec<Limits> {
    let mission = fly(&Options { ideal: true, ..*options });
    let mut p = parameters(options, [0.0; 2]);
    p.sensors.heading_bias_sigma = 0.0;
    let mut bound = InertialBound::new(&p, 50.0).unwrap();
    let mut force = Vector3::new(0.0, 0.0, -p.gravity);
    let mut time = 0.0;
    let mut limits = Vec::new();
    let mut events = mission.events.iter().peekable();
    for truth in &mission.truth {
        let (r, [u, v, w, ..]) = (rotation(truth.quaternion), truth.nu);
        let motion = |specific_force| TrueMotion {
            rotation: Matrix3::from_fn(|i, j| r[i][j]),
            velocity: Vector3::new(u, v, w),
            specific_force,
        };
        while let Some(event) = events.next_if(|e| e.stamp <= truth.time + 1e-9) {
            if event.stamp > time {
                bound.predict(&motion(force), event.stamp - time);
                time = event.stamp;
            }
            match event.data {
                Data::Imu { specific_force, .. } => force = specific_force.into(),
                Data::Thrust(_) => {}
                Data::Ahrs(_) => bound.attitude(&motion(force)),
                Data::Dvl(_) => bound.dvl(&motion(force)),
                Data::Fix(_) => bound.fix(&motion(force)),
                Data::Depth(_) => bound.depth(&motion(force)),
            }
        }
        limits.push(bound.limits(&motion(force)));
    }
    limits
}

/// Root mean square over the instants from [`SETTLED`] on.
pub fn late_rms<T>(instants: &[T], f: impl Fn(&T) -> f64) -> f64 {
    let late = instants.iter().skip((SETTLED * 10.0) as usize);
    mean(&late.map(|x| f(x).powi(2)).collect::<Vec<_>>()).sqrt()
}
