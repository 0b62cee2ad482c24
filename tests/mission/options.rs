//! The options of a mission.

use rexrov::sensors::{BiasNoise, ImuParameters};

/// Depth at the start (m).
pub const START_DEPTH: f64 = 20.0;
/// Three turns of radius 6 m to starboard; with a [`Dive`] of 0.35 times the speed a helix.
pub const CIRCLES: &str = "0,0\n6,0,6\n6,12,6\n-6,12,6\n-6,0,6\n6,0,6\n6,12,6\n-6,12,6\n-6,0,6\n\
    6,0,6\n6,12,6\n-6,12,6\n-6,0,6\n0,0\n";

/// Commanded speed along the course (m/s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    Constant(f64),
    /// `high` for a period, `low` for the next, and so on.
    Switching {
        high: f64,
        low: f64,
        period_s: f64,
    },
}

impl Speed {
    pub fn at(&self, time: f64) -> f64 {
        match *self {
            Self::Constant(speed) => speed,
            Self::Switching { high, low, period_s } => {
                // A nanosecond: the switch is at the instant, whatever the rounding of the
                // quotient.
                let periods = ((time + 1e-9) / period_s).floor();
                if periods % 2.0 == 0.0 { high } else { low }
            }
        }
    }
}

/// A change of depth at a constant rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dive {
    /// When it begins (s).
    pub start_s: f64,
    /// Positive down (m/s).
    pub rate: f64,
    /// How long it takes (s).
    pub duration_s: f64,
}

/// Class of the inertial measurement unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grade {
    /// ADIS16448, the default of [`ImuParameters`].
    Adis,
    Industrial,
    Tactical,
}

impl Grade {
    /// Errors of the accelerometers and of the gyros.
    pub fn noise(self) -> (BiasNoise, BiasNoise) {
        let ImuParameters { accelerometer, gyro, .. } = ImuParameters::default();
        let with = |base: BiasNoise, noise_density, random_walk, turn_on_sigma| BiasNoise {
            noise_density,
            random_walk,
            turn_on_sigma,
            ..base
        };
        match self {
            Self::Adis => (accelerometer, gyro),
            Self::Industrial => {
                (with(accelerometer, 1e-3, 2.5e-4, 0.03), with(gyro, 1e-4, 5e-6, 1e-3))
            }
            Self::Tactical => {
                (with(accelerometer, 5e-4, 2e-5, 0.005), with(gyro, 3e-5, 1e-6, 2e-5))
            }
        }
    }

    /// Standard deviation of roll and pitch (rad).
    pub fn tilt_sigma(self) -> f64 {
        match self {
            Self::Adis => 0.01,
            Self::Industrial => 0.003,
            Self::Tactical => 0.0005,
        }
    }
}

/// A mission to fly. A rate of zero switches a sensor off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Corner points as [`rexrov::guidance::Course::parse`] reads them.
    pub course: &'static str,
    pub seed: u64,
    pub speed: Speed,
    /// North and east (m/s).
    pub current: [f64; 2],
    pub dive: Option<Dive>,
    /// Factor on the plant's mass and inertia; weight minus buoyancy stays as it is.
    pub mass_scale: f64,
    /// Factor on all the plant's damping.
    pub damping_scale: f64,
    /// Height of the plant's centre of buoyancy above its centre of gravity (m).
    pub metacentre: f64,
    /// Time constant of the plant's rotors (s).
    pub rotor_lag: f64,
    /// Standard deviation of each thruster's constant gain error (1).
    pub thrust_gain_sigma: f64,
    /// Standard deviations of the disturbance: force on X, Y and Z (N), moment on N (N.m);
    /// Ornstein-Uhlenbeck processes of 5 s.
    pub disturbance: [f64; 2],
    /// The same for the moments on K and M (N.m).
    pub tilt_disturbance: f64,
    pub imu: Grade,
    /// North and east (m).
    pub fix_sigma: f64,
    pub fix_hz: f64,
    /// Each axis (m/s).
    pub dvl_sigma: f64,
    pub dvl_hz: f64,
    /// Relative error of the DVL's velocity.
    pub dvl_scale: f64,
    /// Yaw of the AHRS (rad).
    pub heading_sigma: f64,
    /// Roll and pitch of the AHRS (rad).
    pub tilt_sigma: f64,
    /// Constant error of the yaw of the AHRS (rad).
    pub heading_bias: f64,
    pub ahrs_hz: f64,
    /// (m)
    pub depth_sigma: f64,
    pub depth_hz: f64,
    /// Ends the mission at this time (s), if it has not reached the end of the course.
    pub duration_s: f64,
    /// Thruster that loses its propeller, and when (s): the rotor turns as before.
    pub lost_thruster: Option<(usize, f64)>,
    /// Fraction of its thrust that the lost thruster loses.
    pub lost_fraction: f64,
    /// Thruster whose rotor stops, and when (s).
    pub dead_thruster: Option<(usize, f64)>,
    /// When (s) the true position jumps by 10 m, in a direction drawn from the seed.
    pub kidnap: Option<f64>,
    /// Sensors without noise and bias; `heading_bias` and `dvl_scale` still act.
    pub ideal: bool,
}

impl Options {
    /// Speed 0.3 m/s without a current; position fix 0.5 m, 1 Hz; DVL 0.01 m/s, every 0.14 s;
    /// AHRS 0.01 rad and depth 0.306 m, 10 Hz; ADIS16448; thrusters 3 %; disturbance 20 N, 10 N.m.
    pub fn nominal(course: &'static str, seed: u64) -> Self {
        Self {
            course,
            seed,
            speed: Speed::Constant(0.3),
            current: [0.0; 2],
            dive: None,
            mass_scale: 1.0,
            damping_scale: 1.0,
            metacentre: 0.3,
            rotor_lag: 0.05,
            thrust_gain_sigma: 0.03,
            disturbance: [20.0, 10.0],
            tilt_disturbance: 0.0,
            imu: Grade::Adis,
            fix_sigma: 0.5,
            fix_hz: 1.0,
            dvl_sigma: 0.01,
            dvl_hz: 50.0 / 7.0,
            dvl_scale: 0.0,
            heading_sigma: 0.01,
            tilt_sigma: Grade::Adis.tilt_sigma(),
            heading_bias: 0.0,
            ahrs_hz: 10.0,
            depth_sigma: 0.306,
            depth_hz: 10.0,
            duration_s: f64::INFINITY,
            lost_thruster: None,
            lost_fraction: 1.0,
            dead_thruster: None,
            kidnap: None,
            ideal: false,
        }
    }

    /// With another inertial measurement unit and the corresponding tilt.
    pub fn with_imu(self, imu: Grade) -> Self {
        Self { imu, tilt_sigma: imu.tilt_sigma(), ..self }
    }

    /// Commanded depth (m) and its rate (m/s).
    pub fn depth_at(&self, time: f64) -> (f64, f64) {
        let Some(Dive { start_s, rate, duration_s }) = self.dive else {
            return (START_DEPTH, 0.0);
        };
        let since = time - start_s;
        let moving = (0.0..duration_s).contains(&since);
        let depth = START_DEPTH + rate * since.clamp(0.0, duration_s);
        (depth, if moving { rate } else { 0.0 })
    }
}
