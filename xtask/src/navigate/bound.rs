//! The posterior Cramér-Rao bound of the nominal missions.

use anyhow::Context;
use cosim::Recording;
use cosim::report::{mean, quantile};
use nalgebra::Matrix3;
use rexrov::attitude::rotation_euler;
use rexrov::estimation::NavigationParameters;
use rexrov::estimation::bound::{InertialBound, TrueMotion};

use super::mission::{INTERVAL, tilt_sigma};
use super::score::SETTLED;

/// Samples of the inertial unit a second (Hz), and of the velocity log.
const IMU_HZ: f64 = 50.0;
const DVL_HZ: f64 = 50.0 / 7.0;

/// How many missions of an estimator at the bound are drawn.
const SAMPLES: usize = 400;

/// The horizontal position of an estimator that reaches the bound, after settling.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bound {
    /// The smallest root mean square error (m).
    pub(crate) rms: f64,
    /// The root mean square error that a mission exceeds with 5 % probability (m).
    pub(crate) high: f64,
}

/// Along a mission with the nominal sensors.
pub(crate) fn of(recording: &Recording, grade: &str) -> anyhow::Result<Bound> {
    let mut p = NavigationParameters::default();
    p.sensors.heading_bias_sigma = 0.0;
    // Five samples between two rows contain as much information as one of this.
    p.sensors.tilt_sigma = tilt_sigma(grade) / (IMU_HZ * INTERVAL).sqrt();
    let mut bound = InertialBound::new(&p, IMU_HZ)?.with_samples(SAMPLES, 1);
    let motions = motions(recording)?;
    let (mut variances, mut squares) = (Vec::new(), vec![0.0; SAMPLES]);
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
            for (sum, [x, y, _]) in squares.iter_mut().zip(bound.position_errors()) {
                *sum += x * x + y * y;
            }
        }
        bound.predict(motion, INTERVAL);
    }
    let instants = variances.len() as f64;
    let errors: Vec<f64> = squares.iter().map(|sum| (sum / instants).sqrt()).collect();
    Ok(Bound { rms: mean(&variances).sqrt(), high: quantile(&errors, 0.95) })
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
