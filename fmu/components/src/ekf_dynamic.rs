//! The dynamic filter of the paper: acceleration from the reduced model, eqs (27) to (30).

use crate::navigation_parameters::reduced;
use crate::navigator::Navigator;
use fmu_kit::{Info, Variables};
use rexrov::ParameterError;
use rexrov::estimation::paper::{Acceleration, Ekf, EkfParameters};
use rexrov::vehicle::{self, ParameterSet};

/// Parameters of the dynamic filter.
#[derive(Clone, Debug, Default, Variables)]
pub struct Parameters {
    /// What both filters have.
    #[var(flatten)]
    pub filter: EkfParameters,
    /// Named set that gives every coefficient of the model not set otherwise
    pub parameter_set: ParameterSet,
    /// Model
    pub model: vehicle::Parameters,
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
        let model = vehicle::Parameters::preset(selected.parameter_set);
        Parameters { model, ..Parameters::default() }
    }

    fn filter(p: &Parameters) -> Result<Ekf, ParameterError> {
        Ekf::new(&p.filter, Acceleration::Dynamic(reduced(&p.model)?))
    }

    fn rate_hz(p: &Parameters) -> f64 {
        p.filter.rate_hz
    }
}
