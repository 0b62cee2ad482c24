//! Model-aided inertial navigation with a monitor for the thrusters.
//!
//! The monitor runs on its own dynamic filter, whose innovations show a lost thrust for seconds,
//! whereas the inertial filter would at once attribute it to a disturbance. A detection becomes an
//! event of the aided filter: thruster i gives this share of its thrust from now on.

use serde::{Deserialize, Serialize};

use super::estimate::Estimate;
use super::family::{DynamicFilter, UnmonitoredAidedFilter};
use super::filter::{Memory, Navigation};
use super::measurement::Measurements;
use super::monitor::ThrusterMonitor;
use super::parameters::{Disturbances, ModelErrors, NavigationParameters};
use super::process::inertial::InertialProcess;
use super::process::model_aid::ModelAid;
use super::process::planar_dynamic::PlanarDynamic;
use super::smoother::{Recording, Smoothed, Smoothing};
use crate::ParameterError;
use crate::vehicle::Parameters;

/// Capacity for the states of the inertial, dynamic and constant-acceleration filters: 15 and the
/// sensor states.
pub const BASIC_STATES: usize = 20;
/// Capacity for the states of the model-aided filter: 29 and the sensor states. Like the other one a
/// multiple of four, for whole vectors.
pub const AIDED_STATES: usize = 36;

/// Model-aided inertial navigation.
#[derive(Clone, Debug)]
pub struct AidedFilter {
    filter: UnmonitoredAidedFilter,
    watch: DynamicFilter,
}

/// Its memory.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AidedMemory {
    filter: Memory<AIDED_STATES>,
    watch: Memory<BASIC_STATES, ThrusterMonitor<BASIC_STATES>>,
    effectiveness: [f64; 8],
}

impl Clone for AidedMemory {
    fn clone(&self) -> Self {
        Self { filter: self.filter.clone(), watch: self.watch.clone(), ..*self }
    }

    fn clone_from(&mut self, from: &Self) {
        self.filter.clone_from(&from.filter);
        self.watch.clone_from(&from.watch);
        self.effectiveness = from.effectiveness;
    }
}

/// The white yaw moment that the monitor's dynamic filter needs (N.m/sqrt(Hz)): it has no inertial
/// noise that could hide a loss. With less, what the model omits looks like a loss.
const WATCH_MOMENT_DENSITY: f64 = 3.0;

impl AidedFilter {
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(
        p: &NavigationParameters,
        vehicle: &Parameters,
        errors: &ModelErrors,
    ) -> Result<Self, ParameterError> {
        let aid = ModelAid::new(vehicle, errors)?;
        let moment_density = errors.disturbances.moment_density.min(WATCH_MOMENT_DENSITY);
        let watched = Disturbances { moment_density, ..errors.disturbances };
        Ok(Self {
            filter: UnmonitoredAidedFilter::new(InertialProcess::new(p, Some(aid))?, p)?,
            watch: DynamicFilter::new(PlanarDynamic::new(p, vehicle, &watched)?, p)?,
        })
    }
}

impl Navigation for AidedFilter {
    type Memory = AidedMemory;

    fn memory(&self) -> AidedMemory {
        let (filter, watch) = (self.filter.memory(), self.watch.memory());
        AidedMemory { filter, watch, effectiveness: [1.0; 8] }
    }

    fn take(&self, memory: &mut AidedMemory, now: f64, measured: &Measurements) {
        self.watch.take(&mut memory.watch, now, measured);
        let effectiveness = memory.watch.effectiveness();
        if effectiveness != memory.effectiveness {
            memory.effectiveness = effectiveness;
            memory.filter.assume(effectiveness);
        }
        self.filter.take(&mut memory.filter, now, measured);
    }

    fn estimate(&self, memory: &mut AidedMemory) -> Estimate {
        self.filter.estimate(&mut memory.filter)
    }
}

impl Smoothing for AidedFilter {
    fn recording(&self) -> Recording {
        self.filter.recording()
    }

    fn smooth(&self, recording: &Recording) -> Vec<Smoothed> {
        let mut watched = recording.clone();
        self.watch.0.watch(&mut watched);
        self.filter.smooth(&watched)
    }
}
