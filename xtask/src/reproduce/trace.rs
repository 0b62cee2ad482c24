//! The data kept of a run: the recorded signals, until the course is finished.

use cosim::Recording;

/// The recorded signals, in the order of the result files.
pub(crate) const SIGNALS: [&str; 31] = [
    "vehicle.pose.x",
    "vehicle.pose.y",
    "vehicle.pose.z",
    "vehicle.pose.yaw",
    "vehicle.velocity.u",
    "vehicle.acceleration.u",
    "vehicle.thruster[0].thrust",
    "vehicle.thruster[1].thrust",
    "vehicle.thruster[2].thrust",
    "vehicle.thruster[3].thrust",
    "vehicle.thruster[4].thrust",
    "vehicle.thruster[5].thrust",
    "vehicle.thruster[6].thrust",
    "vehicle.thruster[7].thrust",
    "imu.specific_force.x",
    "imu.attitude.pitch",
    "gps.position.x",
    "gps.position.y",
    "ekf.pose.x",
    "ekf.pose.y",
    "ekf.pose.z",
    "ekf.pose.yaw",
    "ekf.velocity.u",
    "ekf.acceleration.u",
    "ekf.sigma.x",
    "ekf.sigma.y",
    "ekf.sigma.z",
    "ekf.sigma.yaw",
    "pursuit.cross_track",
    "pursuit.distance",
    "pursuit.finished",
];

/// Components of a pose, in the order of the arrays below.
pub(crate) const AXES: [&str; 4] = ["x", "y", "z", "yaw"];

/// The signals of one run, all of one length.
#[derive(Debug, Clone, Default)]
pub(crate) struct Trace {
    /// Instants, s.
    pub(crate) time: Vec<f64>,
    /// True x, y, z (NED, m) and yaw (rad).
    pub(crate) truth: [Vec<f64>; 4],
    /// Estimated x, y, z and yaw.
    pub(crate) estimate: [Vec<f64>; 4],
    /// Standard deviations that the filter reports.
    pub(crate) sigma: [Vec<f64>; 4],
    /// Derivative of the surge velocity: true, m/s2.
    pub(crate) surge_acceleration: Vec<f64>,
    /// The same as estimated by the filter.
    pub(crate) filter_acceleration: Vec<f64>,
    /// The same from the IMU: specific force along x minus gravity along x at its pitch.
    pub(crate) imu_acceleration: Vec<f64>,
    /// Thrust of the thrusters, N.
    pub(crate) thrust: [Vec<f64>; 8],
    /// Whether the end of the course was reached.
    pub(crate) finished: bool,
}

impl Trace {
    /// Takes the signals from a recording, up to the instant the course is finished.
    pub(crate) fn of(recording: &Recording) -> anyhow::Result<Self> {
        let finished = recording.column("pursuit.finished")?;
        let end = finished.iter().position(|f| *f >= 0.5);
        let length = end.map_or(finished.len(), |i| i + 1);
        let column = |name: &str| -> anyhow::Result<Vec<f64>> {
            Ok(recording.column(name)?[..length].to_vec())
        };
        let pose = |prefix: &str| -> anyhow::Result<[Vec<f64>; 4]> {
            let [x, y, z, yaw] = AXES.map(|axis| column(&format!("{prefix}.{axis}")));
            Ok([x?, y?, z?, yaw?])
        };
        let mut thrust: [Vec<f64>; 8] = Default::default();
        for (i, values) in thrust.iter_mut().enumerate() {
            *values = column(&format!("vehicle.thruster[{i}].thrust"))?;
        }
        let (force, pitch) = (column("imu.specific_force.x")?, column("imu.attitude.pitch")?);
        Ok(Trace {
            time: recording.time()[..length].to_vec(),
            truth: pose("vehicle.pose")?,
            estimate: pose("ekf.pose")?,
            sigma: pose("ekf.sigma")?,
            surge_acceleration: column("vehicle.acceleration.u")?,
            filter_acceleration: column("ekf.acceleration.u")?,
            imu_acceleration: without_gravity(&force, &pitch),
            thrust,
            finished: end.is_some(),
        })
    }

    /// Error of one axis of the estimate; headings between -pi and pi.
    pub(crate) fn error(&self, axis: usize) -> Vec<f64> {
        let errors = self.estimate[axis].iter().zip(&self.truth[axis]).map(|(e, t)| e - t);
        match AXES[axis] {
            "yaw" => errors.map(rexrov::attitude::wrap).collect(),
            _ => errors.collect(),
        }
    }
}

/// Acceleration along the body's x axis: f = a - g, and gravity along x is -g sin(pitch).
fn without_gravity(force: &[f64], pitch: &[f64]) -> Vec<f64> {
    let gravity = rexrov::vehicle::Parameters::default().gravity;
    force.iter().zip(pitch).map(|(f, pitch)| f - gravity * pitch.sin()).collect()
}
