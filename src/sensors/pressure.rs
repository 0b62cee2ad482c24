//! Pressure sensor: absolute pressure at its own position, and the corresponding depth.
//!
//! `p = p_0 + gradient (z + (R r)_z) + bias + noise`, `depth = (p - p_0) / gradient`; depth is that
//! of the sensor, not of the centre of gravity.

use super::Stream;
use super::errors::Outliers;
use super::instrument::Instrument;
use super::noise::Gaussian;
use crate::ParameterError;
use crate::attitude;
use crate::axes;
use crate::error::declared;
use crate::sampling::Rate;
use crate::vector::mul;
use fmu_quantity::Variables;
use serde::{Deserialize, Serialize};

/// Parameters of a pressure sensor.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct PressureParameters {
    /// What all sensors have.
    #[var(flatten, start = Instrument::new(10.0, 4))]
    pub instrument: Instrument,
    /// Place in the body frame
    #[var(rename = "mounting", unit = "m", elements = axes::BODY, start = [-1.32, -0.5, -0.85])]
    pub position: [f64; 3],
    /// Standard deviation
    #[var(unit = "Pa", min = 0.0, nominal = 1000.0, start = 3000.0)]
    pub sigma_pa: f64,
    /// Standard deviation of a constant error, drawn once
    #[var(unit = "Pa", min = 0.0, nominal = 1000.0)]
    pub bias_sigma_pa: f64,
    /// Samples that are far off
    #[var(unit = "Pa")]
    pub outlier: Outliers,
    /// Pressure at the surface
    #[var(unit = "Pa", min = 0.0, nominal = 1e5, start = 101_325.0)]
    pub surface_pressure_pa: f64,
    /// Increase of pressure with depth
    #[var(unit = "Pa/m", min = 1.0, nominal = 1e4, start = 9806.38)]
    pub gradient_pa_per_m: f64,
}

/// True pose at a sample instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Variables)]
pub struct PressureTruth {
    /// Pose of the centre of gravity: down
    #[var(rename = "pose.z", unit = "m")]
    pub z: f64,
    /// Pose of the centre of gravity
    ///
    /// Its part roll and pitch.
    #[var(rename = "pose", elements = axes::TILT)]
    pub tilt: [f64; 2],
}

/// Outputs of the sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Variables)]
pub struct PressureSample {
    /// Absolute pressure at the sensor
    #[var(rename = "pressure", unit = "Pa", nominal = 1e5)]
    pub pressure_pa: f64,
    /// Depth of the sensor that this pressure stands for
    #[var(unit = "m")]
    pub depth: f64,
}

/// Noise generators and bias.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PressureMemory {
    white: Gaussian,
    outliers: Gaussian,
    /// For the pressure (Pa).
    bias: f64,
}

/// A pressure sensor, with its parameters checked.
#[derive(Clone, Debug, PartialEq)]
pub struct PressureSensor {
    /// How often it samples.
    pub rate: Rate,
    p: PressureParameters,
}

impl PressureSensor {
    /// Checks the parameters.
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(p: &PressureParameters) -> Result<Self, ParameterError> {
        declared(p)?;
        Ok(Self { rate: p.instrument.rate()?, p: *p })
    }

    /// The memory at switch-on.
    #[must_use]
    pub fn memory(&self) -> PressureMemory {
        let stream = |stream| self.p.instrument.noise(stream);
        PressureMemory {
            white: stream(Stream::Pressure),
            outliers: stream(Stream::PressureOutliers),
            bias: self.p.bias_sigma_pa * stream(Stream::PressureBias).draw(),
        }
    }

    /// The next sample.
    pub fn sample(&self, memory: &mut PressureMemory, truth: &PressureTruth) -> PressureSample {
        let [roll, pitch] = truth.tilt;
        let r_nb = attitude::rotation_euler([roll, pitch, 0.0]);
        let [outlier] = self.p.outlier.draw(&mut memory.outliers);
        let noise = self.p.sigma_pa * memory.white.draw() + memory.bias + outlier;
        let gauge = self.p.gradient_pa_per_m * (truth.z + mul(&r_nb, self.p.position)[2]) + noise;
        PressureSample {
            pressure_pa: self.p.surface_pressure_pa + gauge,
            depth: gauge / self.p.gradient_pa_per_m,
        }
    }
}
