//! Inertial navigation aided by the equations of motion: `rexrov::estimation::ModelAid` with FMI
//! variables.

use crate::coefficients::{Coefficients, ParameterSet};
use crate::filter_disturbances::ModelErrors;
use crate::imu_errors::ImuGrade;
use crate::navigation_parameters;
use crate::navigator::Navigator;
use fmu_kit::{Info, Variables};
use rexrov::ParameterError;
use rexrov::estimation::AidedFilter;

/// Parameters of the filter.
#[derive(Clone, Debug, Variables)]
pub struct Parameters {
    /// What all filters have.
    #[var(flatten)]
    pub navigation: navigation_parameters::Parameters,
    /// Named set that gives every coefficient of the model not set otherwise
    pub parameter_set: ParameterSet,
    /// Model
    pub model: Coefficients,
    /// Disturbance
    pub disturbance: ModelErrors,
}

impl Parameters {
    fn of(imu_grade: ImuGrade, parameter_set: ParameterSet) -> Self {
        Self {
            navigation: navigation_parameters::Parameters::of(imu_grade),
            parameter_set,
            model: Coefficients::preset(parameter_set),
            disturbance: ModelErrors::default(),
        }
    }
}

impl Default for Parameters {
    fn default() -> Self {
        Self::of(ImuGrade::default(), ParameterSet::default())
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
        Parameters::of(selected.navigation.imu_grade, selected.parameter_set)
    }

    fn filter(p: &Parameters) -> Result<Self::Filter, ParameterError> {
        let navigation = (&p.navigation).into();
        AidedFilter::new(&navigation, &p.model.checked()?, &p.disturbance.into())
    }

    fn rate_hz(p: &Parameters) -> f64 {
        p.navigation.rate_hz
    }
}
