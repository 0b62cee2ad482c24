//! Doppler velocity log: `rexrov::sensors::Dvl` with FMI variables.

use crate::errors::{GaussMarkov, Outliers};
use crate::groups::{DepthAndTilt, LinearVelocity, Vector, Velocity};
use crate::instrument::{Instrument, Stamp, Switch};
use crate::sensing::Sensor;
use fmu_kit::{Enumeration, Info, Variables};
use rexrov::ParameterError;
use rexrov::sampling::Rate;
use rexrov::sensors::{self, DvlMemory, DvlParameters, DvlTruth};
use serde::{Deserialize, Serialize};

/// Instruments with the values of their data sheets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Enumeration)]
pub enum DvlModel {
    /// the log of UUV Simulator
    #[default]
    UuvSimulator,
    /// Teledyne RD Instruments Workhorse Navigator, 300 kHz
    WorkhorseNavigator300,
    /// Teledyne RD Instruments Workhorse Navigator, 600 kHz
    WorkhorseNavigator600,
    /// Teledyne RD Instruments Workhorse Navigator, 1200 kHz
    WorkhorseNavigator1200,
    /// Nortek DVL1000
    NortekDvl1000,
}

impl From<DvlModel> for sensors::DvlModel {
    fn from(model: DvlModel) -> Self {
        match model {
            DvlModel::UuvSimulator => Self::UuvSimulator,
            DvlModel::WorkhorseNavigator300 => Self::WorkhorseNavigator300,
            DvlModel::WorkhorseNavigator600 => Self::WorkhorseNavigator600,
            DvlModel::WorkhorseNavigator1200 => Self::WorkhorseNavigator1200,
            DvlModel::NortekDvl1000 => Self::NortekDvl1000,
        }
    }
}

/// Parameters of the velocity log.
#[derive(Clone, Debug, Variables)]
pub struct Parameters {
    /// Instrument that gives every value not set otherwise
    pub model: DvlModel,
    /// What all sensors have.
    #[var(flatten)]
    pub instrument: Instrument,
    /// Place in the body frame
    #[var(unit = "m")]
    pub mounting: Vector,
    /// Standard deviation of surge and sway with four beams
    #[var(unit = "m/s", min = 0.0)]
    pub sigma: f64,
    /// Angle between the beams and the axis of the housing
    #[var(unit = "deg", min = 1.0, max = 80.0)]
    pub beam_angle_deg: f64,
    /// Relative error of the speed, as from a wrong speed of sound
    #[var(unit = "1", min = -0.5, max = 0.5)]
    pub scale_error: f64,
    /// Yaw of the housing in the body frame
    #[var(unit = "deg")]
    pub misalignment_deg: f64,
    /// Correlated error of each axis
    #[var(unit = "m/s")]
    pub correlated_error: GaussMarkov,
    /// Samples whose beams are far off, each on its own; sigma is that of surge and sway
    #[var(unit = "m/s")]
    pub outlier: Outliers,
    /// Probability that a sample is lost
    #[var(unit = "1", min = 0.0, max = 1.0)]
    pub dropout_probability: f64,
    /// Probability that a beam is lost, each on its own
    #[var(unit = "1", min = 0.0, max = 1.0)]
    pub beam_dropout_probability: f64,
    /// Depth of the flat seabed; 0: none is modelled, every beam reaches it
    #[var(unit = "m", min = 0.0)]
    pub seabed_depth: f64,
    /// Least altitude for bottom lock, beam by beam
    #[var(unit = "m", min = 0.0)]
    pub min_altitude: f64,
    /// Greatest altitude for bottom lock, beam by beam; above the least
    #[var(unit = "m")]
    pub max_altitude: f64,
    /// Greatest tilt from the vertical for bottom lock
    #[var(unit = "deg", min = 0.0, max = 180.0)]
    pub max_tilt_deg: f64,
}

impl Parameters {
    /// The values of an instrument.
    fn of(model: DvlModel) -> Self {
        let p = sensors::DvlModel::from(model).parameters();
        Self {
            model,
            instrument: Instrument::new(p.rate_hz, p.seed),
            mounting: p.position.into(),
            sigma: p.sigma,
            beam_angle_deg: p.beam_angle_deg,
            scale_error: p.scale_error,
            misalignment_deg: p.misalignment_deg,
            correlated_error: p.correlated_error.into(),
            outlier: p.outlier.into(),
            dropout_probability: p.dropout_probability,
            beam_dropout_probability: p.beam_dropout_probability,
            seabed_depth: p.seabed_depth,
            min_altitude: p.min_altitude,
            max_altitude: p.max_altitude,
            max_tilt_deg: p.max_tilt_deg,
        }
    }
}

impl Default for Parameters {
    fn default() -> Self {
        Self::of(DvlModel::default())
    }
}

/// True motion.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Vehicle {
    /// Velocity over ground, body frame
    pub velocity: Velocity,
    /// Pose of the centre of gravity
    pub pose: DepthAndTilt,
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

/// One beam.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Beam {
    /// velocity along the beam, positive towards the seabed; 0 where it lost the bottom
    #[var(unit = "m/s")]
    pub velocity: f64,
    /// 1 with bottom lock, 0 without
    #[var(min = 0.0, max = 1.0)]
    pub valid: f64,
}

impl From<Option<f64>> for Beam {
    fn from(beam: Option<f64>) -> Self {
        beam.map_or_else(Self::default, |velocity| Self { velocity, valid: 1.0 })
    }
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Outputs {
    /// Velocity over ground at the instrument, body axes
    pub velocity: LinearVelocity,
    /// Disagreement of the four beams, with the noise of surge and sway; 0 with three
    #[var(unit = "m/s")]
    pub error_velocity: f64,
    /// Height over the seabed; 0 if none is modelled
    #[var(unit = "m")]
    pub altitude: f64,
    /// Beam towards 45, 135, 225, 315 deg from forward
    pub beam: [Beam; 4],
    /// Newest sample.
    #[var(flatten)]
    pub stamp: Stamp,
}

/// The velocity log.
pub struct Dvl(sensors::Dvl);

impl Sensor for Dvl {
    const INFO: Info =
        crate::info("Dvl", "Doppler velocity log with four beams, bottom lock and lever arm");
    type Parameters = Parameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Memory = DvlMemory;

    fn preset(selected: &Parameters) -> Parameters {
        Parameters::of(selected.model)
    }

    fn new(p: &Parameters) -> Result<Self, ParameterError> {
        let parameters = DvlParameters {
            rate_hz: p.instrument.rate_hz,
            seed: p.instrument.seed(),
            position: p.mounting.into(),
            sigma: p.sigma,
            beam_angle_deg: p.beam_angle_deg,
            scale_error: p.scale_error,
            misalignment_deg: p.misalignment_deg,
            correlated_error: p.correlated_error.into(),
            outlier: p.outlier.into(),
            dropout_probability: p.dropout_probability,
            beam_dropout_probability: p.beam_dropout_probability,
            seabed_depth: p.seabed_depth,
            min_altitude: p.min_altitude,
            max_altitude: p.max_altitude,
            max_tilt_deg: p.max_tilt_deg,
        };
        sensors::Dvl::new(&parameters).map(Self)
    }

    fn instrument(p: &Parameters) -> &Instrument {
        &p.instrument
    }

    fn rate(&self) -> Rate {
        self.0.rate
    }

    fn memory(&self) -> DvlMemory {
        self.0.memory()
    }

    fn sample(&self, stamp: Stamp, memory: &mut DvlMemory, u: &Inputs) -> Option<Outputs> {
        let DepthAndTilt { z, roll, pitch } = u.vehicle.pose;
        let truth = DvlTruth { nu: u.vehicle.velocity.into(), z, euler: [roll, pitch, 0.0] };
        let ping = self.0.sample(memory, &truth).filter(|_| u.switch.is_on())?;
        Some(Outputs {
            velocity: ping.sample.velocity.into(),
            error_velocity: ping.error_velocity,
            altitude: ping.altitude,
            beam: ping.beams.map(Into::into),
            stamp,
        })
    }
}
