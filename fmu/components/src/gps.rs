//! Horizontal position fix (the paper's GPS): `rexrov::sensors::Gps` with FMI variables.

use crate::errors::Outliers;
use crate::groups::{Pose, Position, Vector};
use crate::instrument::{Instrument, Stamp, Switch};
use crate::sensing::Sensor;
use fmu_kit::{Info, Variables};
use rexrov::ParameterError;
use rexrov::sampling::Rate;
use rexrov::sensors::{self, GpsMemory, GpsParameters, GpsTruth};
use serde::{Deserialize, Serialize};

/// Parameters of the position fix.
#[derive(Clone, Debug, Variables)]
pub struct Parameters {
    /// What all sensors have.
    #[var(flatten)]
    pub instrument: Instrument,
    /// Place in the body frame
    #[var(unit = "m")]
    pub mounting: Vector,
    /// Standard deviation north and east at range zero
    #[var(unit = "m", min = 0.0)]
    pub sigma: f64,
    /// What adds to it, as a fraction of the slant range to the beacon
    #[var(unit = "1", min = 0.0, nominal = 0.01)]
    pub range_sigma: f64,
    /// Place of the transceiver in NED
    pub beacon: Position,
    /// Fixes that are far off, as by a reflected path
    #[var(unit = "m")]
    pub outlier: Outliers,
    /// Probability that a fix is lost
    #[var(unit = "1", min = 0.0, max = 1.0)]
    pub dropout_probability: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        let p = GpsParameters::default();
        Self {
            instrument: Instrument::new(p.rate_hz, p.seed),
            mounting: p.position.into(),
            sigma: p.sigma,
            range_sigma: p.range_sigma,
            beacon: p.beacon.into(),
            outlier: p.outlier.into(),
            dropout_probability: p.dropout_probability,
        }
    }
}

/// True motion.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Vehicle {
    /// Pose of the centre of gravity
    pub pose: Pose,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Inputs {
    /// True motion
    pub vehicle: Vehicle,
    /// Switch.
    #[var(flatten)]
    pub switch: Switch,
}

/// A fix.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Fix {
    /// north
    #[var(unit = "m")]
    pub x: f64,
    /// east
    #[var(unit = "m")]
    pub y: f64,
    /// standard deviation north and east that the instrument reports
    #[var(unit = "m")]
    pub sigma: f64,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Outputs {
    /// Place of the antenna or transponder
    pub position: Fix,
    /// Newest sample.
    #[var(flatten)]
    pub stamp: Stamp,
}

/// The position fix.
pub struct Gps(sensors::Gps);

impl Sensor for Gps {
    const INFO: Info =
        crate::info("Gps", "Horizontal position fix (GPS, USBL, LBL) with noise and lever arm");
    type Parameters = Parameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Memory = GpsMemory;

    fn new(p: &Parameters) -> Result<Self, ParameterError> {
        let parameters = GpsParameters {
            rate_hz: p.instrument.rate_hz,
            seed: p.instrument.seed(),
            position: p.mounting.into(),
            sigma: p.sigma,
            range_sigma: p.range_sigma,
            beacon: p.beacon.into(),
            outlier: p.outlier.into(),
            dropout_probability: p.dropout_probability,
        };
        sensors::Gps::new(&parameters).map(Self)
    }

    fn instrument(p: &Parameters) -> &Instrument {
        &p.instrument
    }

    fn rate(&self) -> Rate {
        self.0.rate
    }

    fn memory(&self) -> GpsMemory {
        self.0.memory()
    }

    fn sample(&self, stamp: Stamp, memory: &mut GpsMemory, u: &Inputs) -> Option<Outputs> {
        let [north, east, down, roll, pitch, yaw] = u.vehicle.pose.into();
        let truth = GpsTruth { p_ned: [north, east, down], euler: [roll, pitch, yaw] };
        let fix = self.0.sample(memory, &truth).filter(|_| u.switch.is_on())?;
        let [x, y] = fix.sample.position;
        Some(Outputs { position: Fix { x, y, sigma: fix.sigma }, stamp })
    }
}
