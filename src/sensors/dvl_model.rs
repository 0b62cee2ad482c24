//! Parameters of Doppler velocity logs, and the instruments that set them.

use super::errors::{GaussMarkov, Outliers};
use super::instrument::Instrument;
use crate::ParameterError;
use crate::axes;
use crate::error::declared;
use fmu_quantity::{Enumeration, Variables};

/// Parameters of a DVL.
///
/// Start values are those of the log of UUV Simulator.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct DvlParameters {
    /// Instrument that gives every value not set otherwise
    ///
    /// Only [`DvlModel::parameters`] uses it.
    pub model: DvlModel,
    /// What all sensors have.
    #[var(flatten, start = Instrument::new(7.0, 2))]
    pub instrument: Instrument,
    /// Place in the body frame
    #[var(rename = "mounting", unit = "m", elements = axes::BODY, start = [-1.4, 0.0, 0.312])]
    pub position: [f64; 3],
    /// Standard deviation of surge and sway with four beams
    #[var(unit = "m/s", min = 0.0, start = 0.001)]
    pub sigma: f64,
    /// Angle between the beams and the axis of the housing
    #[var(unit = "deg", min = 1.0, max = 80.0, start = 30.0)]
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
    ///
    /// Each beam is tested by its range times the cosine of the beam angle, which is the altitude
    /// without tilt.
    #[var(unit = "m", min = 0.0, start = 0.7)]
    pub min_altitude: f64,
    /// Greatest altitude for bottom lock, beam by beam; above the least
    #[var(unit = "m", start = 90.0)]
    pub max_altitude: f64,
    /// Greatest tilt from the vertical for bottom lock
    #[var(unit = "deg", min = 0.0, max = 180.0, start = 90.0)]
    pub max_tilt_deg: f64,
}

impl DvlParameters {
    pub(super) fn check(&self) -> Result<(), ParameterError> {
        declared(self)?;
        if self.max_altitude <= self.min_altitude {
            let reason = "must be greater than min_altitude";
            return Err(ParameterError::new("max_altitude", self.max_altitude, reason));
        }
        Ok(())
    }
}

/// Instruments with the values of their data sheets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
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

impl DvlModel {
    /// Rate, noise of a single ping, beam angle and altitudes of its data sheet; no other errors.
    #[must_use]
    pub fn parameters(self) -> DvlParameters {
        let (rate_hz, sigma, beam_angle_deg, min_altitude, max_altitude) = match self {
            Self::UuvSimulator => (7.0, 0.001, 30.0, 0.7, 90.0),
            Self::WorkhorseNavigator300 => (7.0, 0.003, 30.0, 1.0, 200.0),
            Self::WorkhorseNavigator600 => (7.0, 0.003, 30.0, 0.7, 90.0),
            Self::WorkhorseNavigator1200 => (7.0, 0.003, 30.0, 0.5, 30.0),
            Self::NortekDvl1000 => (8.0, 0.005, 25.0, 0.2, 75.0),
        };
        let usual = DvlParameters::default();
        DvlParameters {
            model: self,
            instrument: Instrument { rate_hz, ..usual.instrument },
            sigma,
            beam_angle_deg,
            min_altitude,
            max_altitude,
            ..usual
        }
    }
}
