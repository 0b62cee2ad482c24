//! The filters of the family as types without parameters: their code is compiled once, with this
//! crate, and not again in each crate that uses them.

use super::aided::{AIDED_STATES, BASIC_STATES};
use super::estimate::Estimate;
use super::filter::{Filter, Memory, Navigation};
use super::measurement::Measurements;
use super::monitor::ThrusterMonitor;
use super::parameters::NavigationParameters;
use super::process::constant_acceleration::ConstantAcceleration;
use super::process::inertial::InertialProcess;
use super::process::planar_dynamic::PlanarDynamic;
use super::smoother::{Recording, Smoothed, Smoothing};
use crate::ParameterError;

macro_rules! filters {
    ($($(#[$doc:meta])* $name:ident = $process:ty, $states:expr, $monitor:ty;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Debug)]
        pub struct $name(pub(super) Filter<$process, $states, $monitor>);

        impl $name {
            /// # Errors
            /// Names the parameter that is out of range.
            pub fn new(process: $process, p: &NavigationParameters) -> Result<Self, ParameterError> {
                Filter::new(process, p).map(Self)
            }
        }

        impl Navigation for $name {
            type Memory = Memory<$states, $monitor>;

            fn memory(&self) -> Self::Memory {
                self.0.memory()
            }

            fn take(&self, memory: &mut Self::Memory, now: f64, measured: &Measurements) {
                self.0.take(memory, now, measured);
            }

            fn estimate(&self, memory: &mut Self::Memory) -> Estimate {
                self.0.estimate(memory)
            }
        }

        impl Smoothing for $name {
            fn recording(&self) -> Recording {
                self.0.recording()
            }

            fn smooth(&self, recording: &Recording) -> Vec<Smoothed> {
                self.0.smooth(recording)
            }
        }
    )*};
}

filters! {
    /// Acceleration and angular rate wander.
    ConstantAccelerationFilter = ConstantAcceleration, BASIC_STATES, ();
    /// The equations of motion, with a thruster monitor.
    DynamicFilter = PlanarDynamic, BASIC_STATES, ThrusterMonitor<BASIC_STATES>;
    /// The same without a monitor.
    UnmonitoredDynamicFilter = PlanarDynamic, BASIC_STATES, ();
    /// Inertial navigation.
    InertialFilter = InertialProcess, BASIC_STATES, ();
    /// Inertial navigation, with room for a model that aids it.
    UnmonitoredAidedFilter = InertialProcess, AIDED_STATES, ();
}
