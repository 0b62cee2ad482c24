//! Parameters that all navigation filters but the paper's have.

use fmu_kit::Variables;
use rexrov::ParameterError;
use rexrov::estimation::NavigationParameters;
use rexrov::sensors::ImuGrade;
use rexrov::vehicle::{self, ReducedModel};

/// Parameters of a navigation filter.
#[derive(Clone, Copy, Debug, Variables)]
pub struct Parameters {
    /// How often the inputs are looked at and the outputs renewed
    #[var(unit = "Hz", min = 1.0, max = 1e6, start = 100.0)]
    pub rate_hz: f64,
    /// Those of the mathematics.
    #[var(flatten)]
    pub filter: NavigationParameters,
}

impl Parameters {
    /// The values of a grade.
    pub fn of(imu_grade: ImuGrade) -> Self {
        Self { filter: NavigationParameters::of(imu_grade), ..Self::default() }
    }

    /// The grade that was chosen.
    pub fn imu_grade(&self) -> ImuGrade {
        self.filter.sensors.imu_grade
    }
}

/// Checks the parameter `model`, the vehicle inside a filter.
///
/// # Errors
/// Names the parameter that is out of range.
pub fn reduced(model: &vehicle::Parameters) -> Result<ReducedModel, ParameterError> {
    ReducedModel::new(model).map_err(|error| error.within("model"))
}
