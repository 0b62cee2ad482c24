//! Pressure sensor: absolute pressure at its own position, and the corresponding depth.
//!
//! `p = p_0 + gradient (z + (R r)_z) + bias + noise`, `depth = (p - p_0) / gradient`; depth is that
//! of the sensor, not of the centre of gravity.

use super::errors::Outliers;
use super::noise::{Gaussian, Stream};
use crate::ParameterError;
use crate::attitude;
use crate::error::{each, finite, non_negative, positive};
use crate::sampling::Rate;
use crate::vector::mul;
use serde::{Deserialize, Serialize};

/// Parameters of a pressure sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressureParameters {
    /// Samples a second (Hz).
    pub rate_hz: f64,
    /// Seed of its noise.
    pub seed: u64,
    /// Position, body (m).
    pub position: [f64; 3],
    /// Standard deviation (Pa).
    pub sigma_pa: f64,
    /// Standard deviation of a constant error, drawn once (Pa).
    pub bias_sigma_pa: f64,
    /// Outlier samples (Pa).
    pub outlier: Outliers,
    /// Pressure at the surface (Pa).
    pub surface_pressure_pa: f64,
    /// Increase with depth (Pa/m).
    pub gradient_pa_per_m: f64,
}

impl Default for PressureParameters {
    fn default() -> Self {
        Self {
            rate_hz: 10.0,
            seed: 4,
            position: [-1.32, -0.5, -0.85],
            sigma_pa: 3000.0,
            bias_sigma_pa: 0.0,
            outlier: Outliers::default(),
            surface_pressure_pa: 101_325.0,
            gradient_pa_per_m: 9806.38,
        }
    }
}

/// True pose at a sample instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PressureTruth {
    /// Depth of the centre of gravity, NED z (m).
    pub z: f64,
    /// Roll, pitch, yaw (rad).
    pub euler: [f64; 3],
}

/// Outputs of the sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PressureSample {
    /// Absolute pressure (Pa).
    pub pressure_pa: f64,
    /// Depth of the sensor (m).
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
        let rate = Rate::new(p.rate_hz)?;
        each("position", &p.position, finite)?;
        non_negative("sigma_pa", p.sigma_pa)?;
        non_negative("bias_sigma_pa", p.bias_sigma_pa)?;
        p.outlier.check("outlier")?;
        non_negative("surface_pressure_pa", p.surface_pressure_pa)?;
        positive("gradient_pa_per_m", p.gradient_pa_per_m)?;
        Ok(Self { rate, p: *p })
    }

    /// The memory at switch-on.
    #[must_use]
    pub fn memory(&self) -> PressureMemory {
        let stream = |stream| Gaussian::new(self.p.seed, stream);
        PressureMemory {
            white: stream(Stream::Pressure),
            outliers: stream(Stream::PressureOutliers),
            bias: self.p.bias_sigma_pa * stream(Stream::PressureBias).draw(),
        }
    }

    /// The next sample.
    pub fn sample(&self, memory: &mut PressureMemory, truth: &PressureTruth) -> PressureSample {
        let r_nb = attitude::rotation_euler(truth.euler);
        let [outlier] = self.p.outlier.draw(&mut memory.outliers);
        let noise = self.p.sigma_pa * memory.white.draw() + memory.bias + outlier;
        let gauge = self.p.gradient_pa_per_m * (truth.z + mul(&r_nb, self.p.position)[2]) + noise;
        PressureSample {
            pressure_pa: self.p.surface_pressure_pa + gauge,
            depth: gauge / self.p.gradient_pa_per_m,
        }
    }
}
