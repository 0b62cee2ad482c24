//! Attitude and heading reference: `rexrov::sensors::Ahrs` with FMI variables.

use crate::errors::GaussMarkov;
use crate::groups::Attitude;
use crate::instrument::{Instrument, Stamp, Switch};
use crate::sensing::Sensor;
use fmu_kit::{Info, Variables};
use rexrov::ParameterError;
use rexrov::sampling::Rate;
use rexrov::sensors::{self, AhrsMemory, AhrsParameters, AhrsTruth};
use serde::{Deserialize, Serialize};

crate::groups::group! {
    /// Coefficients of the deviation of a magnetic compass.
    Deviation = [
        /// of the sine of the heading
        #[var(rename = "B", unit = "rad")] b,
        /// of the cosine of the heading
        #[var(rename = "C", unit = "rad")] c,
        /// of the sine of twice the heading
        #[var(rename = "D", unit = "rad")] d,
        /// of the cosine of twice the heading
        #[var(rename = "E", unit = "rad")] e; 4]
}

/// Parameters of the attitude and heading reference.
#[derive(Clone, Debug, Variables)]
pub struct Parameters {
    /// What all sensors have.
    #[var(flatten)]
    pub instrument: Instrument,
    /// Standard deviation of the white noise of roll and pitch
    #[var(unit = "rad", min = 0.0, nominal = 0.01)]
    pub tilt_sigma: f64,
    /// Standard deviation of the white noise of the heading
    #[var(unit = "rad", min = 0.0, nominal = 0.01)]
    pub heading_sigma: f64,
    /// Correlated error of roll and pitch
    #[var(unit = "rad")]
    pub tilt_error: GaussMarkov,
    /// Correlated error of the heading
    #[var(unit = "rad")]
    pub heading_error: GaussMarkov,
    /// Constant error of the heading
    #[var(unit = "rad")]
    pub heading_bias: f64,
    /// Standard deviation of another constant error of the heading, drawn once
    #[var(unit = "rad", min = 0.0)]
    pub heading_bias_sigma: f64,
    /// Error of a magnetic compass on the true heading, coefficient
    pub deviation: Deviation,
}

impl Default for Parameters {
    fn default() -> Self {
        let p = AhrsParameters::default();
        Self {
            instrument: Instrument::new(p.rate_hz, p.seed),
            tilt_sigma: p.tilt_sigma,
            heading_sigma: p.heading_sigma,
            tilt_error: p.tilt_error.into(),
            heading_error: p.heading_error.into(),
            heading_bias: p.heading_bias,
            heading_bias_sigma: p.heading_bias_sigma,
            deviation: p.deviation.into(),
        }
    }
}

/// True motion.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Vehicle {
    /// Attitude
    pub pose: Attitude,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Inputs {
    /// True motion
    pub vehicle: Vehicle,
    /// What the surroundings add to the heading, as steel does to that of a compass
    #[var(unit = "rad")]
    pub disturbance: f64,
    /// Switch.
    #[var(flatten)]
    pub switch: Switch,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Outputs {
    /// Attitude of the body
    pub attitude: Attitude,
    /// Newest sample.
    #[var(flatten)]
    pub stamp: Stamp,
}

/// The attitude and heading reference.
pub struct Ahrs(sensors::Ahrs);

impl Sensor for Ahrs {
    const INFO: Info =
        crate::info("Ahrs", "Attitude and heading reference or compass, with its errors");
    type Parameters = Parameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Memory = AhrsMemory;

    fn new(p: &Parameters) -> Result<Self, ParameterError> {
        let parameters = AhrsParameters {
            rate_hz: p.instrument.rate_hz,
            seed: p.instrument.seed(),
            tilt_sigma: p.tilt_sigma,
            heading_sigma: p.heading_sigma,
            tilt_error: p.tilt_error.into(),
            heading_error: p.heading_error.into(),
            heading_bias: p.heading_bias,
            heading_bias_sigma: p.heading_bias_sigma,
            deviation: p.deviation.into(),
        };
        sensors::Ahrs::new(&parameters).map(Self)
    }

    fn instrument(p: &Parameters) -> &Instrument {
        &p.instrument
    }

    fn rate(&self) -> Rate {
        self.0.rate
    }

    fn memory(&self) -> AhrsMemory {
        self.0.memory()
    }

    fn sample(&self, stamp: Stamp, memory: &mut AhrsMemory, u: &Inputs) -> Option<Outputs> {
        let truth = AhrsTruth { euler: u.vehicle.pose.into(), disturbance: u.disturbance };
        let attitude = self.0.sample(memory, &truth).into();
        u.switch.is_on().then_some(Outputs { attitude, stamp })
    }
}
