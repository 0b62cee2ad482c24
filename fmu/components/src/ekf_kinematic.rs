//! The kinematic filter of the paper: acceleration from the accelerometers.

use crate::ekf_parameters::FilterParameters;
use crate::ekf_ports::{Inputs, Outputs};
use crate::groups::parameter_error;
use fmu_kit::{Fault, Info, ParameterError, Resources, Sample, Time};
use rexrov::estimation::{Acceleration, Ekf, EkfMemory, EkfParameters};

/// The kinematic filter. It has the thrust inputs of the dynamic one and ignores them, so that one
/// can stand in for the other.
pub struct EkfKinematic(Ekf);

impl Sample for EkfKinematic {
    const INFO: Info = crate::info(
        "EkfKinematic",
        "Extended Kalman filter of x, y, z, yaw driven by measured acceleration",
    );
    type Parameters = FilterParameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Memory = EkfMemory;

    fn new(p: &FilterParameters, _: &Resources) -> Result<Self, ParameterError> {
        let ekf = Ekf::new(&EkfParameters::from(p), Acceleration::Kinematic);
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
