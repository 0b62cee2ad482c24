//! Pressure sensor: absolute pressure at its own place, and the depth it stands for.
//!
//! `p = p_0 + gradient (z + (R r)_z) + noise`, `depth = (p - p_0) / gradient`; depth is that of
//! the sensor, not of the centre of gravity.

use super::noise::Gaussian;
use crate::ParameterError;
use crate::attitude;
use crate::error::{each, finite, non_negative, positive};
use crate::sampling::Rate;
use crate::vector::{Vec3, mul};
use serde::{Deserialize, Serialize};

/// Parameters of a pressure sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressureParameters {
    /// Samples a second (Hz).
    pub rate_hz: f64,
    /// Seed of its noise.
    pub seed: u64,
    /// Place, body (m).
    pub position: [f64; 3],
    /// Standard deviation (Pa).
    pub sigma_pa: f64,
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

/// What the sensor shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PressureSample {
    /// Absolute pressure (Pa).
    pub pressure_pa: f64,
    /// Depth of the sensor (m).
    pub depth: f64,
}

/// Noise generator.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PressureMemory {
    noise: Gaussian,
}

/// A pressure sensor, its parameters checked.
#[derive(Clone, Debug, PartialEq)]
pub struct PressureSensor {
    /// How often it samples.
    pub rate: Rate,
    seed: u64,
    position: Vec3,
    sigma_pa: f64,
    surface_pressure_pa: f64,
    gradient_pa_per_m: f64,
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
        non_negative("surface_pressure_pa", p.surface_pressure_pa)?;
        positive("gradient_pa_per_m", p.gradient_pa_per_m)?;
        Ok(Self {
            rate,
            seed: p.seed,
            position: p.position,
            sigma_pa: p.sigma_pa,
            surface_pressure_pa: p.surface_pressure_pa,
            gradient_pa_per_m: p.gradient_pa_per_m,
        })
    }

    /// The memory at switch-on.
    #[must_use]
    pub fn memory(&self) -> PressureMemory {
        PressureMemory { noise: Gaussian::new(self.seed, 0) }
    }

    /// The next sample.
    pub fn sample(&self, memory: &mut PressureMemory, truth: &PressureTruth) -> PressureSample {
        let r_nb = attitude::rotation_euler(truth.euler);
        let gauge = self.gradient_pa_per_m * (truth.z + mul(&r_nb, self.position)[2])
            + self.sigma_pa * memory.noise.draw();
        PressureSample {
            pressure_pa: self.surface_pressure_pa + gauge,
            depth: gauge / self.gradient_pa_per_m,
        }
    }
}
