//! Inertial navigation: `rexrov::estimation::InertialProcess` as a component.

use crate::navigation_parameters::Parameters;
use crate::navigator::Navigator;
use fmu_kit::Info;
use rexrov::ParameterError;
use rexrov::estimation::{InertialFilter, InertialProcess};

/// The inertial filter: position, velocity, attitude and the biases of the inertial unit.
pub struct NavInertial;

impl Navigator for NavInertial {
    const INFO: Info = crate::info(
        "NavInertial",
        "Inertial navigation in three dimensions, aided by the other sensors",
    );
    type Parameters = Parameters;
    type Filter = InertialFilter;

    fn preset(selected: &Parameters) -> Parameters {
        Parameters::of(selected.imu_grade())
    }

    fn filter(p: &Parameters) -> Result<Self::Filter, ParameterError> {
        InertialFilter::new(InertialProcess::new(&p.filter, None)?, &p.filter)
    }

    fn rate_hz(p: &Parameters) -> f64 {
        p.rate_hz
    }
}
