//! Pure pursuit: steer towards a point of the course a little ahead.
//!
//! `kappa = 2 sin(alpha) / L_d`, `r = gain atan(kappa L)`: eqs (54) and (55). alpha is the bearing
//! of the target minus the heading. As printed, alpha is the course of the segment minus the
//! heading, which ignores the cross-track error; that is kept as an option. Speed is constant.
//!
//! Depth: `w = speed dz/ds + depth_gain (z_course - z)`, with z_course the depth at the nearest
//! point and dz/ds the mean slope over one look-ahead distance around it, so that a kink in the
//! depth changes the heave velocity gradually. A course without depths is level, and w is the
//! second term alone.

use super::course::Course;
use crate::ParameterError;
use crate::attitude::wrap;
use crate::error::declared;
use crate::sampling::Rate;
use core::f64::consts::FRAC_PI_2;
use fmu_quantity::{Enumeration, Variables};
use serde::{Deserialize, Serialize};

/// What the heading is compared with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
pub enum HeadingReference {
    /// the bearing of the target from the vehicle
    #[default]
    Target,
    /// the course of the segment, as printed: no feedback of the distance from the course
    Segment,
}

/// Parameters of the path follower.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct PursuitParameters {
    /// Cycles a second
    #[var(unit = "Hz", min = 0.001, max = 1e6, start = 10.0)]
    pub rate_hz: f64,
    /// Distance of the target ahead of the nearest point, along the course
    ///
    /// L_d of eq (54).
    #[var(unit = "m", min = 1e-9, start = 1.0)]
    pub lookahead: f64,
    /// Vehicle length of eq (55)
    #[var(unit = "m", min = 1e-9, start = 1.0)]
    pub vehicle_length: f64,
    /// Turn rate over steering angle
    #[var(unit = "1/s", min = 1e-9, start = 0.3)]
    pub gain: f64,
    /// Speed along the course, horizontal
    #[var(unit = "m/s", start = 0.3)]
    pub speed: f64,
    /// Depth to hold on a course without depths
    #[var(unit = "m", start = 20.0)]
    pub depth: f64,
    /// Heave velocity over depth error
    #[var(unit = "1/s", min = 0.0, start = 0.2)]
    pub depth_gain: f64,
    /// Limit of the heave velocity that corrects a depth error
    #[var(unit = "m/s", min = 0.0, start = 0.1)]
    pub heave_limit: f64,
    /// Limit of the whole heave velocity on a course with depths
    #[var(unit = "m/s", min = 0.0, start = 0.3)]
    pub total_heave_limit: f64,
    /// How close to its end the course counts as finished
    ///
    /// Measured along the course.
    #[var(unit = "m", min = 0.0, start = 0.05)]
    pub finish_tolerance: f64,
    /// How far back along the course the nearest point may move in a cycle
    #[var(unit = "m", min = 0.0, start = 1.0)]
    pub search_back: f64,
    /// How far ahead along the course the nearest point may move in a cycle
    #[var(unit = "m", min = 1e-9, start = 1.0)]
    pub search_ahead: f64,
    /// What the heading is compared with
    pub heading_reference: HeadingReference,
}

/// How far along the course the vehicle is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PursuitMemory {
    distance: f64,
    finished: bool,
}

/// Outputs of the path follower.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Guidance {
    /// Velocity command `[u, v, w, r]`, body (m/s, rad/s); at the end only the depth is held.
    pub command: [f64; 4],
    /// The target point, `[x, y, z]` (m).
    pub target: [f64; 3],
    /// Horizontal distance from the course, positive to starboard (m).
    pub cross_track: f64,
    /// Depth below the course (m).
    pub vertical_track: f64,
    /// Arc length of the nearest point (m).
    pub distance: f64,
    /// The end has been reached; stays true.
    pub finished: bool,
}

/// A path follower on its course.
#[derive(Clone, Debug, PartialEq)]
pub struct PurePursuit {
    /// How often it runs.
    pub rate: Rate,
    parameters: PursuitParameters,
    course: Course,
}

impl PurePursuit {
    /// Checks the parameters.
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(p: &PursuitParameters, course: Course) -> Result<Self, ParameterError> {
        declared(p)?;
        let rate = Rate::new(p.rate_hz)?;
        Ok(Self { rate, parameters: *p, course })
    }

    /// The course that is followed.
    #[must_use]
    pub fn course(&self) -> &Course {
        &self.course
    }

    /// One cycle, from an estimated pose `[x, y, z, yaw]`.
    ///
    /// The nearest point is searched only around the last one, so that a course may come close to
    /// itself or cross itself.
    pub fn update(&self, memory: &mut PursuitMemory, [x, y, z, yaw]: [f64; 4]) -> Guidance {
        let p = &self.parameters;
        let (from, to) = (memory.distance - p.search_back, memory.distance + p.search_ahead);
        memory.distance = self.course.nearest([x, y], from, to);
        memory.finished |= memory.distance >= self.course.length() - p.finish_tolerance;

        let ahead = memory.distance + p.lookahead;
        let [north, east] = self.course.point(ahead);
        let reference = match p.heading_reference {
            HeadingReference::Target => libm::atan2(east - y, north - x),
            HeadingReference::Segment => self.course.heading(ahead),
        };
        let (speed, turn_rate) = match memory.finished {
            true => (0.0, 0.0),
            false => (p.speed, self.turn_rate(wrap(reference - yaw))),
        };
        Guidance {
            command: [speed, 0.0, self.heave(memory.distance, speed, z), turn_rate],
            target: [north, east, self.depth(ahead)],
            cross_track: self.course.cross_track([x, y], memory.distance),
            vertical_track: z - self.depth(memory.distance),
            distance: memory.distance,
            finished: memory.finished,
        }
    }

    fn depth(&self, s: f64) -> f64 {
        self.course.depth(s).unwrap_or(self.parameters.depth)
    }

    fn heave(&self, s: f64, speed: f64, z: f64) -> f64 {
        let p = &self.parameters;
        let correction = p.depth_gain * (self.depth(s) - z);
        let correction = correction.clamp(-p.heave_limit, p.heave_limit);
        self.course.slope(s, p.lookahead).map_or(correction, |slope| {
            (speed * slope + correction).clamp(-p.total_heave_limit, p.total_heave_limit)
        })
    }

    fn turn_rate(&self, alpha: f64) -> f64 {
        let p = &self.parameters;
        // With the target astern the sine would go to zero; use the tightest turn instead.
        let sin = libm::sin(alpha.clamp(-FRAC_PI_2, FRAC_PI_2));
        p.gain * libm::atan(2.0 * sin / p.lookahead * p.vehicle_length)
    }
}
