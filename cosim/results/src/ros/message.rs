//! The messages. Messages with a value that is not finite are skipped, because no tool can show
//! them.

use super::WORLD;
use super::cdr::Cdr;
use super::frames::{self, of_body, orientation, place, pose, pose_covariance, variances};
use crate::roles::{Axes, Body, Roles, Sensor};
use cosim_base::time::Time;

/// A message type and its content.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Odometry,
    Transforms,
    Imu,
    Fix,
    Pressure,
    Log,
}

impl Kind {
    /// The type name in ROS.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Odometry => "nav_msgs/msg/Odometry",
            Self::Transforms => "tf2_msgs/msg/TFMessage",
            Self::Imu => "sensor_msgs/msg/Imu",
            Self::Fix => "geometry_msgs/msg/PoseWithCovarianceStamped",
            Self::Pressure => "sensor_msgs/msg/FluidPressure",
            Self::Log => "geometry_msgs/msg/TwistWithCovarianceStamped",
        }
    }

    /// The last part of the topic's name.
    pub(super) fn topic(self) -> &'static str {
        match self {
            Self::Odometry => "odometry",
            Self::Transforms => "tf",
            Self::Imu => "data",
            Self::Fix => "pose",
            Self::Pressure => "fluid_pressure",
            Self::Log => "twist",
        }
    }

    /// The possible measurements of a sensor.
    pub(super) fn of(sensor: &Sensor) -> Vec<Self> {
        let inertial = sensor.specific_force.is_there() && sensor.rate.is_there();
        let all = [
            (inertial || sensor.attitude.is_there(), Self::Imu),
            (sensor.position.is_there(), Self::Fix),
            (sensor.pressure.is_some(), Self::Pressure),
            (sensor.velocity.is_there(), Self::Log),
        ];
        all.into_iter().filter(|(there, _)| *there).map(|(_, kind)| kind).collect()
    }
}

fn finite(values: &[f64]) -> bool {
    values.iter().all(|value| value.is_finite())
}

pub(super) fn odometry(
    cdr: &mut Cdr<'_>,
    axes: Axes,
    body: &Body,
    frame: &str,
    now: Time,
    row: &[f64],
) -> bool {
    let [u, v, w, p, q, r] = body.velocity.values(row);
    let (Some(pose), true) = (pose(axes, body, row), finite(&[u, v, w, p, q, r])) else {
        return false;
    };
    cdr.header(now, WORLD);
    cdr.string(frame);
    cdr.float64s(&pose.position);
    cdr.float64s(&pose.orientation);
    cdr.float64s(&pose_covariance(axes, body, row));
    cdr.float64s(&of_body(axes, [u, v, w]));
    cdr.float64s(&of_body(axes, [p, q, r]));
    let sigmas = body.velocity_sigma.values(row);
    let known = |axis: usize| body.velocity_sigma.has([axis]).then_some(sigmas[axis]);
    cdr.float64s(&variances(std::array::from_fn(known)));
    true
}

pub(super) fn transforms(
    cdr: &mut Cdr<'_>,
    roles: &Roles,
    frames: &[String],
    now: Time,
    row: &[f64],
) -> bool {
    let bodies = roles.bodies.iter().zip(frames);
    let poses = bodies.filter_map(|(body, frame)| Some((pose(roles.axes, body, row)?, frame)));
    let poses: Vec<_> = poses.collect();
    cdr.uint32(poses.len() as u32);
    for (pose, frame) in &poses {
        cdr.header(now, WORLD);
        cdr.string(frame);
        cdr.float64s(&pose.position);
        cdr.float64s(&pose.orientation);
    }
    !poses.is_empty()
}

/// The measurement of a sensor; its axes are those of the vehicle.
pub(super) fn measured(
    cdr: &mut Cdr<'_>,
    kind: Kind,
    axes: Axes,
    sensor: &Sensor,
    stamp: Time,
    row: &[f64],
) -> bool {
    match kind {
        Kind::Imu => imu(cdr, axes, sensor, stamp, row),
        Kind::Fix => fix(cdr, axes, sensor, stamp, row),
        Kind::Pressure => {
            let pressure = sensor.pressure.map_or(f64::NAN, |place| place.value(row));
            cdr.header(stamp, BODY);
            cdr.float64s(&[pressure, 0.0]);
            pressure.is_finite()
        }
        Kind::Log => {
            let velocity = sensor.velocity.values(row);
            cdr.header(stamp, BODY);
            cdr.float64s(&of_body(axes, velocity));
            cdr.float64s(&[0.0; 3]);
            cdr.float64s(&[0.0; 36]);
            finite(&velocity)
        }
        Kind::Odometry | Kind::Transforms => false,
    }
}

/// The frame of sensors.
const BODY: &str = "base_link";

/// The covariance of a quantity that an inertial unit does not measure.
const NOT_MEASURED: [f64; 9] = [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];

fn imu(cdr: &mut Cdr<'_>, axes: Axes, sensor: &Sensor, stamp: Time, row: &[f64]) -> bool {
    let covariance = |there: bool| if there { [0.0; 9] } else { NOT_MEASURED };
    let (attitude, rate) = (sensor.attitude.values(row), sensor.rate.values(row));
    let force = sensor.specific_force.values(row);
    let there = sensor.attitude.is_there();
    cdr.header(stamp, BODY);
    cdr.float64s(&if there { orientation(axes, attitude) } else { [0.0, 0.0, 0.0, 1.0] });
    cdr.float64s(&covariance(there));
    cdr.float64s(&of_body(axes, rate));
    cdr.float64s(&covariance(sensor.rate.is_there()));
    cdr.float64s(&of_body(axes, force));
    cdr.float64s(&covariance(sensor.specific_force.is_there()));
    finite(&attitude) && finite(&rate) && finite(&force)
}

fn fix(cdr: &mut Cdr<'_>, axes: Axes, sensor: &Sensor, stamp: Time, row: &[f64]) -> bool {
    let position = sensor.position.values(row);
    let sigma = sensor.sigma.map(|place| place.value(row));
    cdr.header(stamp, WORLD);
    cdr.float64s(&place(axes, position));
    cdr.float64s(&[0.0, 0.0, 0.0, 1.0]);
    let up = sigma.filter(|_| sensor.position.has([2]));
    cdr.float64s(&frames::variances([sigma, sigma, up, None, None, None]));
    finite(&position)
}
