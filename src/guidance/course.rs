//! A course: corner points joined by straights, the corners rounded by arcs.
//!
//! A corner of turning angle phi and radius R takes `R tan(|phi|/2)` of both legs; radius 0 leaves
//! it sharp. Arc length s runs from 0 at the first point to the length of the course at the last.

use super::segment::{Segment, Vec2};
use core::f64::consts::FRAC_PI_2;
use core::fmt;

/// A corner of a course.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Waypoint {
    /// North (m).
    pub x: f64,
    /// East (m).
    pub y: f64,
    /// Radius of the corner (m); 0: sharp. Without meaning at the first and the last point.
    pub radius: f64,
}

/// Where a course is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The course as a whole.
    Course,
    /// Point of this index, from zero.
    Point(usize),
    /// Line of this number, from one.
    Line(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Course => write!(f, "course"),
            Self::Point(index) => write!(f, "point {index}"),
            Self::Line(number) => write!(f, "line {number}"),
        }
    }
}

/// A course that cannot be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {reason}")]
pub struct CourseError {
    /// Where.
    pub place: Place,
    /// Why, and what to do.
    pub reason: String,
}

impl CourseError {
    pub(super) fn new(place: Place, reason: impl Into<String>) -> Self {
        Self { place, reason: reason.into() }
    }
}

/// A path of straights and arcs.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    segments: Vec<Segment>,
    /// Arc length at the start of each segment, and the whole length at last.
    starts: Vec<f64>,
}

/// Farthest coordinate and largest radius (m): beyond, metres have no decimals worth having.
const FARTHEST: f64 = 1e9;
/// Rounding that legs completely used up by their corners are allowed, relative.
const TOLERANCE: f64 = 1e-9;

impl Course {
    /// Joins corner points.
    ///
    /// # Errors
    /// Fewer than two points, coincident neighbours, values that are not finite, a negative radius,
    /// or one too large for the legs beside it.
    pub fn new(points: &[Waypoint]) -> Result<Self, CourseError> {
        check_points(points)?;
        let legs: Vec<Leg> = points.windows(2).map(|w| Leg::new(w[0], w[1])).collect();
        let cuts = corner_cuts(points, &legs)?;
        let mut segments = Vec::with_capacity(2 * legs.len());
        for (i, leg) in legs.iter().enumerate() {
            if i > 0 && cuts[i] > 0.0 {
                segments.push(leg.arc_from(&legs[i - 1], cuts[i], points[i].radius));
            }
            let straight = leg.length - cuts[i] - cuts[i + 1];
            if straight > TOLERANCE * leg.length {
                let start = leg.point(cuts[i]);
                segments.push(Segment::Straight {
                    start,
                    direction: leg.direction,
                    length: straight,
                });
            }
        }
        let mut starts = vec![0.0];
        for segment in &segments {
            starts.push(starts[starts.len() - 1] + segment.length());
        }
        Ok(Self { segments, starts })
    }

    /// Length (m).
    #[must_use]
    pub fn length(&self) -> f64 {
        self.starts[self.segments.len()]
    }

    /// The point `[x, y]` at arc length `s`; beyond the ends the course goes on straight.
    #[must_use]
    pub fn point(&self, s: f64) -> [f64; 2] {
        let inside = s.clamp(0.0, self.length());
        let (point, course) = self.at(inside);
        let (sin, cos) = libm::sincos(course);
        [point[0] + (s - inside) * cos, point[1] + (s - inside) * sin]
    }

    /// The course (rad, clockwise from north) at arc length `s`.
    #[must_use]
    pub fn heading(&self, s: f64) -> f64 {
        self.at(s.clamp(0.0, self.length())).1
    }

    /// Arc length of the point nearest to `p` among those between arc lengths `from` and `to`.
    #[must_use]
    pub fn nearest(&self, p: [f64; 2], from: f64, to: f64) -> f64 {
        let (from, to) = (from.clamp(0.0, self.length()), to.clamp(0.0, self.length()));
        let mut best = (f64::INFINITY, from);
        for (segment, bounds) in self.segments.iter().zip(self.starts.windows(2)) {
            let (low, high) = (from.max(bounds[0]), to.min(bounds[1]));
            if low <= high {
                let s = bounds[0] + segment.nearest(p, low - bounds[0], high - bounds[0]);
                let distance = distance(self.point(s), p);
                if distance < best.0 {
                    best = (distance, s);
                }
            }
        }
        best.1
    }

    /// Distance of `p` from the point at arc length `s`, positive to starboard of the course.
    #[must_use]
    pub fn cross_track(&self, p: [f64; 2], s: f64) -> f64 {
        let (point, course) = self.at(s.clamp(0.0, self.length()));
        let (sin, cos) = libm::sincos(course);
        let starboard = cos * (p[1] - point[1]) - sin * (p[0] - point[0]);
        distance(point, p).copysign(starboard)
    }

    fn at(&self, s: f64) -> (Vec2, f64) {
        let last = self.segments.len() - 1;
        let index = self.starts.partition_point(|&start| start <= s).saturating_sub(1).min(last);
        self.segments[index].at(s - self.starts[index])
    }
}

/// The straight line between two neighbouring corners.
struct Leg {
    start: Vec2,
    direction: Vec2,
    length: f64,
}

impl Leg {
    fn new(a: Waypoint, b: Waypoint) -> Self {
        let length = distance([a.x, a.y], [b.x, b.y]);
        let direction = [(b.x - a.x) / length, (b.y - a.y) / length];
        Self { start: [a.x, a.y], direction, length }
    }

    fn point(&self, s: f64) -> Vec2 {
        [self.start[0] + s * self.direction[0], self.start[1] + s * self.direction[1]]
    }

    /// Sine and cosine of the turn from the leg before to this one, positive to starboard.
    fn turn_from(&self, before: &Leg) -> (f64, f64) {
        let (a, b) = (before.direction, self.direction);
        (a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1])
    }

    /// The arc that joins the leg before, `cut` ahead of the corner, to this one.
    fn arc_from(&self, before: &Leg, cut: f64, radius: f64) -> Segment {
        let (sin, cos) = self.turn_from(before);
        let turn = libm::atan2(sin, cos);
        let d = before.direction;
        let side = radius.copysign(turn);
        let start = before.point(before.length - cut);
        let inward = FRAC_PI_2.copysign(turn);
        Segment::Arc {
            centre: [start[0] - side * d[1], start[1] + side * d[0]],
            radius,
            from: libm::atan2(d[1], d[0]) - inward,
            turn,
        }
    }
}

fn distance(a: Vec2, b: Vec2) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}

fn check_points(points: &[Waypoint]) -> Result<(), CourseError> {
    if points.len() < 2 {
        let reason = format!("needs at least two points, has {}", points.len());
        return Err(CourseError::new(Place::Course, reason));
    }
    for (i, p) in points.iter().enumerate() {
        let place = Place::Point(i);
        if !(p.x.is_finite() && p.y.is_finite() && p.radius.is_finite()) {
            let reason = format!("({}, {}, {}) must be finite numbers", p.x, p.y, p.radius);
            return Err(CourseError::new(place, reason));
        }
        if [p.x, p.y, p.radius].into_iter().any(|value| value.abs() > FARTHEST) {
            let reason = format!("({}, {}, {}) is beyond {FARTHEST:e} m", p.x, p.y, p.radius);
            return Err(CourseError::new(place, reason));
        }
        if p.radius < 0.0 {
            let reason = format!("radius {} must not be negative", p.radius);
            return Err(CourseError::new(place, reason));
        }
        if i > 0 && distance([p.x, p.y], [points[i - 1].x, points[i - 1].y]) < TOLERANCE {
            let reason = format!("({}, {}) repeats the point before; remove it", p.x, p.y);
            return Err(CourseError::new(place, reason));
        }
    }
    Ok(())
}

/// What each corner takes of the legs beside it; zero at the ends and where legs are in line.
fn corner_cuts(points: &[Waypoint], legs: &[Leg]) -> Result<Vec<f64>, CourseError> {
    let mut cuts = vec![0.0; points.len()];
    for i in 1..legs.len() {
        let (sin, cos) = legs[i].turn_from(&legs[i - 1]);
        if points[i].radius > 0.0 && 1.0 + cos < TOLERANCE {
            let reason = "turns back on itself, which no radius can round; use radius 0";
            return Err(CourseError::new(Place::Point(i), reason));
        }
        cuts[i] =
            if cos < -1.0 + TOLERANCE { 0.0 } else { points[i].radius * sin.abs() / (1.0 + cos) };
    }
    for (i, leg) in legs.iter().enumerate() {
        if cuts[i] + cuts[i + 1] > leg.length * (1.0 + TOLERANCE) {
            // The corner that takes more is to blame, of equal ones the first.
            let later = cuts[i + 1] > cuts[i] * (1.0 + TOLERANCE);
            let corner = if later { i + 1 } else { i };
            let (from, to) = (points[i], points[i + 1]);
            let reason = format!(
                "radius {} is too large: the corners of the leg from ({}, {}) to ({}, {}) take \
                 {:.6} m of it, but it is only {:.6} m long",
                points[corner].radius,
                from.x,
                from.y,
                to.x,
                to.y,
                cuts[i] + cuts[i + 1],
                leg.length
            );
            return Err(CourseError::new(Place::Point(corner), reason));
        }
    }
    Ok(cuts)
}
