//! The dynamic filter of the paper: acceleration from the reduced model, eqs (27) to (30).

use crate::coefficients::{Coefficients, ParameterSet};
use crate::ekf_parameters::FilterParameters;
use crate::navigator::Navigator;
use fmu_kit::{Info, Variables};
use rexrov::ParameterError;
use rexrov::estimation::paper::{Acceleration, Ekf, EkfParameters};
use rexrov::vehicle::ReducedModel;

/// Parameters of the dynamic filter.
#[derive(Clone, Debug, Variables)]
pub struct Parameters {
    /// What both filters have.
    #[var(flatten)]
    pub filter: FilterParameters,
    /// Named set that gives every coefficient of the model not set otherwise
    pub parameter_set: ParameterSet,
    /// Model
    pub model: Coefficients,
}

impl Default for Parameters {
    fn default() -> Self {
        let parameter_set = ParameterSet::default();
        Self {
            filter: FilterParameters::default(),
            parameter_set,
            model: Coefficients::preset(parameter_set),
        }
    }
}

/// The dynamic filter.
pub struct EkfDynamic;

impl Navigator for EkfDynamic {
    const INFO: Info = crate::info(
        "EkfDynamic",
        "Extended Kalman filter of x, y, z, yaw driven by the vehicle's equations of motion",
    );
    type Parameters = Parameters;
    type Filter = Ekf;

    fn preset(selected: &Parameters) -> Parameters {
        Parameters { model: Coefficients::preset(selected.parameter_set), ..Parameters::default() }
    }

    fn filter(p: &Parameters) -> Result<Ekf, ParameterError> {
        let model = ReducedModel::new(&p.model.checked()?)?;
        Ekf::new(&EkfParameters::from(&p.filter), Acceleration::Dynamic(model))
    }

    fn rate_hz(p: &Parameters) -> f64 {
        p.filter.rate_hz
    }
}
