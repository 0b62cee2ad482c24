//! The dynamic filter of the paper: acceleration from the reduced model, eqs (27) to (30).

use crate::coefficients::{Coefficients, ParameterSet};
use crate::ekf_parameters::FilterParameters;
use crate::ekf_ports::{Inputs, Outputs};
use crate::groups::parameter_error;
use fmu_kit::{Fault, Info, ParameterError, Resources, Sample, Time, Variables};
use rexrov::estimation::{Acceleration, Ekf, EkfMemory, EkfParameters};
use rexrov::vehicle::{ReducedModel, ThrusterMode};

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
pub struct EkfDynamic(Ekf);

impl Sample for EkfDynamic {
    const INFO: Info = crate::info(
        "EkfDynamic",
        "Extended Kalman filter of x, y, z, yaw driven by the vehicle's equations of motion",
    );
    type Parameters = Parameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Memory = EkfMemory;

    fn preset(selected: &Parameters) -> Parameters {
        Parameters { model: Coefficients::preset(selected.parameter_set), ..Parameters::default() }
    }

    fn new(p: &Parameters, _: &Resources) -> Result<Self, ParameterError> {
        // The filter is told the thrust itself: what the thruster inputs mean does not matter.
        let coefficients = p.model.with_mode(ThrusterMode::Force);
        let model = ReducedModel::new(&coefficients)
            .map_err(|error| parameter_error(error.within("model")))?;
        let ekf = Ekf::new(&EkfParameters::from(&p.filter), Acceleration::Dynamic(model));
        ekf.map(Self).map_err(parameter_error)
    }

    fn period_s(&self) -> f64 {
        self.0.rate.period()
    }

    fn memory(&self) -> EkfMemory {
        self.0.memory()
    }

    fn sample(&self, _: Time, m: &mut EkfMemory, u: &Inputs, y: &mut Outputs) -> Result<(), Fault> {
        *y = self.0.update(m, &u.into()).map_err(Fault::new)?.into();
        Ok(())
    }
}
