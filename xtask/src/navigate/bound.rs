//! The posterior Cramér-Rao bound of the nominal missions.

use anyhow::Context;
use cosim::Recording;
use cosim::report::mean;
use nalgebra::Matrix3;
use rexrov::attitude::rotation_euler;
use rexrov::estimation::NavigationParameters;
use rexrov::estimation::bound::{InertialBound, TrueMotion};

use super::mission::{INTERVAL, tilt_sigma};
use super::score::SETTLED;

/// Samples of the inertial unit a second (Hz), and of the velocity log.
const IMU_HZ: f64 = 50.0;
const DVL_HZ: f64 = 50.0 / 7.0;

/// The smallest root mean square error of the horizontal position after settling (m), along a
/// mission with the nominal sensors.
pub(crate) fn of(recording: &Recording, grade: &str) -> anyhow::Result<f64> {
    let mut p = NavigationParameters::default();
    p.sensors.heading_bias_sigma = 0.0;
    // Five samples between two rows contain as much information as one of this.
    p.sensors.tilt_sigma = tilt_sigma(grade) / (IMU_HZ * INTERVAL).sqrt();
    let mut bound = InertialBound::new(&p, IMU_HZ)?;
    let motions = motions(recording)?;
    let mut variances = Vec::new();
    let mut pings = 0.0;
    for (motion, time) in motions.iter().zip(recording.time()) {
        bound.attitude(motion);
        bound.depth(motion);
        if pings / DVL_HZ <= time + 1e-9 {
            pings += 1.0;
            bound.dvl(motion);
        }
        if (time - time.round()).abs() < 1e-9 {
            bound.fix(motion);
        }
        if *time >= SETTLED {
            let [x, y, _] = bound.limits(motion).position;
            variances.push(x * x + y * y);
        }
        bound.predict(motion, INTERVAL);
    }
    Ok(mean(&variances).sqrt())
}

fn motions(recording: &Recording) -> anyhow::Result<Vec<TrueMotion>> {
    let columns = |group: &str, names: [&str; 3]| -> anyhow::Result<Vec<[f64; 3]>> {
        let [a, b, c] = names.map(|name| recording.column(&format!("vehicle.{group}.{name}")));
        Ok(a?.iter().zip(b?).zip(c?).map(|((a, b), c)| [*a, *b, *c]).collect())
    };
    let euler = columns("pose", ["roll", "pitch", "yaw"])?;
    let velocity = columns("velocity", ["u", "v", "w"])?;
    let force = columns("specific_force", ["x", "y", "z"])?;
    let all = euler.into_iter().zip(velocity).zip(force);
    let motions: Vec<_> = all
        .map(|((euler, velocity), force)| {
            let r = rotation_euler(euler);
            TrueMotion {
                rotation: Matrix3::from_fn(|i, j| r[i][j]),
                velocity: velocity.into(),
                specific_force: force.into(),
            }
        })
        .collect();
    motions.first().context("the mission has no rows")?;
    Ok(motions)
}
