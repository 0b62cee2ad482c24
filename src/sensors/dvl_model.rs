//! Parameters of Doppler velocity logs, and the instruments that set them.

use super::errors::{GaussMarkov, Outliers};
use crate::ParameterError;
use crate::error::{each, finite, non_negative, positive, probability, within};

/// Parameters of a DVL.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DvlParameters {
    /// Samples a second (Hz).
    pub rate_hz: f64,
    /// Seed of all its noise.
    pub seed: u64,
    /// Position, body (m).
    pub position: [f64; 3],
    /// Standard deviation of surge and sway with four beams (m/s).
    pub sigma: f64,
    /// Angle between the beams and the axis of the housing (deg).
    pub beam_angle_deg: f64,
    /// Relative error of the speed, as from a wrong speed of sound.
    pub scale_error: f64,
    /// Unknown yaw of the housing in the body frame (deg).
    pub misalignment_deg: f64,
    /// Correlated error of each axis (m/s).
    pub correlated_error: GaussMarkov,
    /// Outlier samples, in which all beams are far off independently; sigma is for surge and sway
    /// (m/s).
    pub outlier: Outliers,
    /// Probability that a sample is lost.
    pub dropout_probability: f64,
    /// Probability that a beam is lost, independently for each.
    pub beam_dropout_probability: f64,
    /// Depth of the flat seabed (m); 0: none is modelled, every beam reaches it.
    pub seabed_depth: f64,
    /// Minimum altitude for bottom lock (m). Each beam is tested by its range times the cosine of
    /// the beam angle, which is the altitude without tilt.
    pub min_altitude: f64,
    /// Maximum altitude for bottom lock (m), likewise.
    pub max_altitude: f64,
    /// Maximum tilt from the vertical for bottom lock (deg).
    pub max_tilt_deg: f64,
}

impl Default for DvlParameters {
    fn default() -> Self {
        DvlModel::default().parameters()
    }
}

impl DvlParameters {
    /// Checks all but the rate.
    pub(super) fn check(&self) -> Result<(), ParameterError> {
        each("position", &self.position, finite)?;
        non_negative("sigma", self.sigma)?;
        within("beam_angle_deg", self.beam_angle_deg, 1.0, 80.0)?;
        within("scale_error", self.scale_error, -0.5, 0.5)?;
        finite("misalignment_deg", self.misalignment_deg)?;
        self.correlated_error.check("correlated_error")?;
        self.outlier.check("outlier")?;
        probability("dropout_probability", self.dropout_probability)?;
        probability("beam_dropout_probability", self.beam_dropout_probability)?;
        non_negative("seabed_depth", self.seabed_depth)?;
        non_negative("min_altitude", self.min_altitude)?;
        positive("max_altitude", self.max_altitude)?;
        if self.max_altitude <= self.min_altitude {
            let reason = "must be greater than min_altitude";
            return Err(ParameterError::new("max_altitude", self.max_altitude, reason));
        }
        within("max_tilt_deg", self.max_tilt_deg, 0.0, 180.0)
    }
}

/// Instruments with the values of their data sheets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DvlModel {
    /// The log of UUV Simulator.
    #[default]
    UuvSimulator,
    /// Teledyne RD Instruments Workhorse Navigator, 300 kHz.
    WorkhorseNavigator300,
    /// Teledyne RD Instruments Workhorse Navigator, 600 kHz.
    WorkhorseNavigator600,
    /// Teledyne RD Instruments Workhorse Navigator, 1200 kHz.
    WorkhorseNavigator1200,
    /// Nortek DVL1000.
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
        DvlParameters {
            rate_hz,
            seed: 2,
            position: [-1.4, 0.0, 0.312],
            sigma,
            beam_angle_deg,
            scale_error: 0.0,
            misalignment_deg: 0.0,
            correlated_error: GaussMarkov::NONE,
            outlier: Outliers::default(),
            dropout_probability: 0.0,
            beam_dropout_probability: 0.0,
            seabed_depth: 0.0,
            min_altitude,
            max_altitude,
            max_tilt_deg: 90.0,
        }
    }
}
