//! Constant acceleration, as in robot_localization: `rexrov::estimation::ConstantAcceleration` as a
//! component.

use crate::navigation_parameters::Parameters;
use crate::navigator::Navigator;
use fmu_kit::Info;
use rexrov::ParameterError;
use rexrov::estimation::{ConstantAcceleration, ConstantAccelerationFilter};

/// The constant-acceleration filter: no vehicle model, no biases of the inertial unit.
pub struct NavConstantAcceleration;

impl Navigator for NavConstantAcceleration {
    const INFO: Info = crate::info(
        "NavConstantAcceleration",
        "Navigation filter of a vehicle whose acceleration and angular rate wander",
    );
    type Parameters = Parameters;
    type Filter = ConstantAccelerationFilter;

    fn preset(selected: &Parameters) -> Parameters {
        Parameters::of(selected.imu_grade())
    }

    fn filter(p: &Parameters) -> Result<Self::Filter, ParameterError> {
        ConstantAccelerationFilter::new(ConstantAcceleration::new(&p.filter)?, &p.filter)
    }

    fn rate_hz(p: &Parameters) -> f64 {
        p.rate_hz
    }
}
