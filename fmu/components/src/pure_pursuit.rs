//! Guidance: `rexrov::guidance::PurePursuit` with FMI variables.

use crate::course;
use crate::groups::{Pose4, Position, Velocity4, parameter_error};
use fmu_kit::{Enumeration, Fault, Info, ParameterError, Resources, Sample, Time, Variables};
use rexrov::guidance::{self, PursuitMemory, PursuitParameters};
use serde::{Deserialize, Serialize};

/// What the heading is compared with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Enumeration)]
pub enum HeadingReference {
    /// the bearing of the target from the vehicle
    #[default]
    Target,
    /// the course of the segment, as printed: no feedback of the distance from the course
    Segment,
}

/// Parameters of the path follower.
#[derive(Clone, Debug, Variables)]
pub struct Parameters {
    /// Course: BE1, BE2, BE3, DIVE, HELIX, or a file of lines x,y,radius,z (north, east, fillet radius,
    /// depth in m), the last two optional
    pub course: String,
    /// Cycles a second
    #[var(unit = "Hz", min = 0.001, max = 1e6)]
    pub rate_hz: f64,
    /// Distance of the target ahead of the nearest point, along the course
    #[var(unit = "m", min = 1e-9)]
    pub lookahead: f64,
    /// Vehicle length of eq (55)
    #[var(unit = "m", min = 1e-9)]
    pub vehicle_length: f64,
    /// Turn rate over steering angle
    #[var(unit = "1/s", min = 1e-9)]
    pub gain: f64,
    /// Speed along the course, horizontal
    #[var(unit = "m/s")]
    pub speed: f64,
    /// Depth to hold on a course without depths
    #[var(unit = "m")]
    pub depth: f64,
    /// Heave velocity over depth error
    #[var(unit = "1/s", min = 0.0)]
    pub depth_gain: f64,
    /// Limit of the heave velocity that corrects a depth error
    #[var(unit = "m/s", min = 0.0)]
    pub heave_limit: f64,
    /// Limit of the whole heave velocity on a course with depths
    #[var(unit = "m/s", min = 0.0)]
    pub total_heave_limit: f64,
    /// How close to its end the course counts as finished
    #[var(unit = "m", min = 0.0)]
    pub finish_tolerance: f64,
    /// How far back along the course the nearest point may move in a cycle
    #[var(unit = "m", min = 0.0)]
    pub search_back: f64,
    /// How far ahead along the course the nearest point may move in a cycle
    #[var(unit = "m", min = 1e-9)]
    pub search_ahead: f64,
    /// What the heading is compared with
    pub heading_reference: HeadingReference,
}

impl Default for Parameters {
    fn default() -> Self {
        let p = PursuitParameters::default();
        Self {
            course: "BE1".into(),
            rate_hz: p.rate_hz,
            lookahead: p.lookahead,
            vehicle_length: p.vehicle_length,
            gain: p.gain,
            speed: p.speed,
            depth: p.depth,
            depth_gain: p.depth_gain,
            heave_limit: p.heave_limit,
            total_heave_limit: p.total_heave_limit,
            finish_tolerance: p.finish_tolerance,
            search_back: p.search_back,
            search_ahead: p.search_ahead,
            heading_reference: HeadingReference::default(),
        }
    }
}

impl From<&Parameters> for PursuitParameters {
    fn from(p: &Parameters) -> Self {
        Self {
            rate_hz: p.rate_hz,
            lookahead: p.lookahead,
            vehicle_length: p.vehicle_length,
            gain: p.gain,
            speed: p.speed,
            depth: p.depth,
            depth_gain: p.depth_gain,
            heave_limit: p.heave_limit,
            total_heave_limit: p.total_heave_limit,
            finish_tolerance: p.finish_tolerance,
            search_back: p.search_back,
            search_ahead: p.search_ahead,
            heading_reference: match p.heading_reference {
                HeadingReference::Target => guidance::HeadingReference::Target,
                HeadingReference::Segment => guidance::HeadingReference::Segment,
            },
        }
    }
}

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Inputs {
    /// Estimated pose
    pub pose: Pose4,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Outputs {
    /// Velocity demanded, body frame
    pub command: Velocity4,
    /// Point steered to
    pub target: Position,
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
        guidance::PurePursuit::new(&p.into(), course).map(Self).map_err(parameter_error)
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
        let guidance = self.0.update(memory, u.pose.into());
        *y = Outputs {
            command: guidance.command.into(),
            target: guidance.target.into(),
            cross_track: guidance.cross_track,
            vertical_track: guidance.vertical_track,
            distance: guidance.distance,
            finished: f64::from(u8::from(guidance.finished)),
        };
        Ok(())
    }
}
