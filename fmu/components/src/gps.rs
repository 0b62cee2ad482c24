//! Horizontal position fix (the paper's GPS): `rexrov::sensors::Gps` with FMI variables.

use crate::groups::{Horizontal, Pose, parameter_error};
use crate::instrument::{Instrument, Stamp, Switch};
use fmu_kit::{Fault, Info, ParameterError, Resources, Sample, Time, Variables};
use rexrov::sensors::{self, GpsMemory, GpsParameters, GpsTruth};
use serde::{Deserialize, Serialize};

/// Parameters of the position fix.
#[derive(Clone, Debug, Variables)]
pub struct Parameters {
    /// What all sensors have.
    #[var(flatten)]
    pub instrument: Instrument,
    /// Standard deviation north and east
    #[var(unit = "m", min = 0.0)]
    pub sigma: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        let p = GpsParameters::default();
        Self { instrument: Instrument::new(p.rate_hz, p.seed, p.position), sigma: p.sigma }
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

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Outputs {
    /// Place of the antenna or transponder
    pub position: Horizontal,
    /// Newest sample.
    #[var(flatten)]
    pub stamp: Stamp,
}

/// The position fix.
pub struct Gps(sensors::Gps);

impl Sample for Gps {
    const INFO: Info =
        crate::info("Gps", "Horizontal position fix (GPS, USBL, LBL) with noise and lever arm");
    type Parameters = Parameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Memory = GpsMemory;

    fn new(p: &Parameters, _: &Resources) -> Result<Self, ParameterError> {
        let parameters = GpsParameters {
            rate_hz: p.instrument.rate_hz,
            seed: p.instrument.seed(),
            position: p.instrument.mounting.into(),
            sigma: p.sigma,
        };
        sensors::Gps::new(&parameters).map(Self).map_err(parameter_error)
    }

    fn period_s(&self) -> f64 {
        self.0.rate.period()
    }

    fn memory(&self) -> GpsMemory {
        self.0.memory()
    }

    fn sample(
        &self,
        now: Time,
        memory: &mut GpsMemory,
        u: &Inputs,
        y: &mut Outputs,
    ) -> Result<(), Fault> {
        let [north, east, down, roll, pitch, yaw] = u.vehicle.pose.into();
        let truth = GpsTruth { p_ned: [north, east, down], euler: [roll, pitch, yaw] };
        let sample = self.0.sample(memory, &truth);
        if u.switch.is_on() {
            *y = Outputs { position: sample.position.into(), stamp: Stamp::at(now) };
        }
        Ok(())
    }
}
