//! Inertial navigation aided by the equations of motion: `rexrov::estimation::AidedFilter` as a
//! component.

use crate::navigation_parameters::{self, reduced};
use crate::navigator::Navigator;
use fmu_kit::{Info, Variables};
use rexrov::ParameterError;
use rexrov::estimation::{AidedFilter, ModelErrors};
use rexrov::sensors::ImuGrade;
use rexrov::vehicle::{self, ParameterSet};

/// Parameters of the filter.
#[derive(Clone, Debug, Default, Variables)]
pub struct Parameters {
    /// What all filters have.
    #[var(flatten)]
    pub navigation: navigation_parameters::Parameters,
    /// Named set that gives every coefficient of the model not set otherwise
    pub parameter_set: ParameterSet,
    /// Model
    pub model: vehicle::Parameters,
    /// Disturbance
    pub disturbance: ModelErrors,
}

impl Parameters {
    fn of(imu_grade: ImuGrade, parameter_set: ParameterSet) -> Self {
        Self {
            navigation: navigation_parameters::Parameters::of(imu_grade),
            parameter_set,
            model: vehicle::Parameters::preset(parameter_set),
            disturbance: ModelErrors::default(),
        }
    }
}

/// The model-aided filter: inertial navigation, and balances of force and yaw moment as measurements.
pub struct NavModelAided;

impl Navigator for NavModelAided {
    const INFO: Info = crate::info(
        "NavModelAided",
        "Inertial navigation in three dimensions, aided by the equations of motion and all sensors",
    );
    type Parameters = Parameters;
    type Filter = AidedFilter;

    fn preset(selected: &Parameters) -> Parameters {
        Parameters::of(selected.navigation.imu_grade(), selected.parameter_set)
    }

    fn filter(p: &Parameters) -> Result<Self::Filter, ParameterError> {
        reduced(&p.model)?;
        AidedFilter::new(&p.navigation.filter, &p.model, &p.disturbance)
    }

    fn rate_hz(p: &Parameters) -> f64 {
        p.navigation.rate_hz
    }
}
