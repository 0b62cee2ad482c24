//! Guidance: `rexrov::guidance::PurePursuit` as a component.

use crate::{course, parameter_error};
use fmu_kit::{Fault, Info, ParameterError, Resources, Sample, Time, Variables};
use rexrov::axes;
use rexrov::guidance::{self, PursuitMemory, PursuitParameters};
use serde::{Deserialize, Serialize};

/// Parameters of the path follower.
#[derive(Clone, Debug, Variables)]
pub struct Parameters {
    /// Course: BE1, BE2, BE3, DIVE, HELIX, or a file of lines x,y,radius,z (north, east, fillet radius,
    /// depth in m), the last two optional
    #[var(start = "BE1")]
    pub course: String,
    /// Those of the mathematics.
    #[var(flatten)]
    pub pursuit: PursuitParameters,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Inputs {
    /// Estimated pose
    #[var(elements = axes::POSE4)]
    pub pose: [f64; 4],
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Outputs {
    /// Velocity demanded, body frame
    #[var(elements = axes::VELOCITY4)]
    pub command: [f64; 4],
    /// Point steered to
    #[var(elements = axes::NED)]
    pub target: [f64; 3],
    /// Horizontal distance from the course, positive to starboard
    #[var(unit = "m")]
    pub cross_track: f64,
    /// Depth below the course
    #[var(unit = "m")]
    pub vertical_track: f64,
    /// Distance along the course
    #[var(unit = "m")]
    pub distance: f64,
    /// 1 once the end is reached, 0 before
    #[var(min = 0.0, max = 1.0)]
    pub finished: f64,
}

/// The path follower.
pub struct PurePursuit(guidance::PurePursuit);

impl Sample for PurePursuit {
    const INFO: Info = crate::info(
        "PurePursuit",
        "Follows a course at constant speed, at constant depth or along its depths",
    );
    type Parameters = Parameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Memory = PursuitMemory;

    fn new(p: &Parameters, resources: &Resources) -> Result<Self, ParameterError> {
        let course = course::load(&p.course, resources)?;
        guidance::PurePursuit::new(&p.pursuit, course).map(Self).map_err(parameter_error)
    }

    fn period_s(&self) -> f64 {
        self.0.rate.period()
    }

    fn memory(&self) -> PursuitMemory {
        PursuitMemory::default()
    }

    fn sample(
        &self,
        _: Time,
        memory: &mut PursuitMemory,
        u: &Inputs,
        y: &mut Outputs,
    ) -> Result<(), Fault> {
        let guidance = self.0.update(memory, u.pose);
        *y = Outputs {
            command: guidance.command,
            target: guidance.target,
            cross_track: guidance.cross_track,
            vertical_track: guidance.vertical_track,
            distance: guidance.distance,
            finished: f64::from(u8::from(guidance.finished)),
        };
        Ok(())
    }
}
