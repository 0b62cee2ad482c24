//! The kinematic filter of the paper: acceleration from the accelerometers.

use crate::navigator::Navigator;
use fmu_kit::Info;
use rexrov::ParameterError;
use rexrov::estimation::paper::{Acceleration, Ekf, EkfParameters};

/// The kinematic filter.
pub struct EkfKinematic;

impl Navigator for EkfKinematic {
    const INFO: Info = crate::info(
        "EkfKinematic",
        "Extended Kalman filter of x, y, z, yaw driven by measured acceleration",
    );
    type Parameters = EkfParameters;
    type Filter = Ekf;

    fn filter(p: &EkfParameters) -> Result<Ekf, ParameterError> {
        Ekf::new(p, Acceleration::Kinematic)
    }

    fn rate_hz(p: &EkfParameters) -> f64 {
        p.rate_hz
    }
}
