//! Navigation by the equations of motion: `rexrov::estimation::PlanarDynamic` as a component.

use crate::navigation_parameters::{self, reduced};
use crate::navigator::Navigator;
use fmu_kit::{Info, Variables};
use rexrov::ParameterError;
use rexrov::estimation::{Disturbances, DynamicFilter, PlanarDynamic};
use rexrov::sensors::ImuGrade;
use rexrov::vehicle::{self, ParameterSet};

/// Parameters of the filter.
#[derive(Clone, Debug, Variables)]
pub struct Parameters {
    /// What all filters have.
    #[var(flatten)]
    pub navigation: navigation_parameters::Parameters,
    /// Named set that gives every coefficient of the model not set otherwise
    pub parameter_set: ParameterSet,
    /// Model
    pub model: vehicle::Parameters,
    /// Disturbance
    pub disturbance: Disturbances,
}

impl Parameters {
    fn of(imu_grade: ImuGrade, parameter_set: ParameterSet) -> Self {
        // A better gyro reveals more of what the model omits.
        let moment_density = if imu_grade == ImuGrade::Adis16448 { 2.0 } else { 5.0 };
        Self {
            navigation: navigation_parameters::Parameters::of(imu_grade),
            parameter_set,
            model: vehicle::Parameters::preset(parameter_set),
            disturbance: Disturbances { moment_density, ..Disturbances::default() },
        }
    }
}

impl Default for Parameters {
    fn default() -> Self {
        Self::of(ImuGrade::default(), ParameterSet::default())
    }
}

/// The dynamic filter: surge, sway, heave and yaw by the model, with current and disturbances.
pub struct NavDynamic;

impl Navigator for NavDynamic {
    const INFO: Info = crate::info(
        "NavDynamic",
        "Navigation filter driven by the equations of motion in four degrees of freedom",
    );
    type Parameters = Parameters;
    type Filter = DynamicFilter;

    fn preset(selected: &Parameters) -> Parameters {
        Parameters::of(selected.navigation.imu_grade(), selected.parameter_set)
    }

    fn filter(p: &Parameters) -> Result<Self::Filter, ParameterError> {
        reduced(&p.model)?;
        let navigation = &p.navigation.filter;
        DynamicFilter::new(PlanarDynamic::new(navigation, &p.model, &p.disturbance)?, navigation)
    }

    fn rate_hz(p: &Parameters) -> f64 {
        p.navigation.rate_hz
    }
}
