//! The points of a course, and errors in them.

use super::segment::Vec2;
use core::fmt;

/// A corner of a course, or one of its ends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Waypoint {
    /// North (m).
    pub x: f64,
    /// East (m).
    pub y: f64,
    /// Radius of the corner (m); 0: sharp. Ignored at the first and the last point.
    pub radius: f64,
    /// Depth (m), given for every point of a course or for none.
    pub z: Option<f64>,
}

/// Location of an error in a course.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The course as a whole.
    Course,
    /// The point with this index, from zero.
    Point(usize),
    /// The line with this number, from one.
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

/// An invalid course.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {reason}")]
pub struct CourseError {
    /// The location.
    pub place: Place,
    /// The reason, and what to do.
    pub reason: String,
}

impl CourseError {
    pub(super) fn new(place: Place, reason: impl Into<String>) -> Self {
        Self { place, reason: reason.into() }
    }
}

/// Largest coordinate and radius (m): beyond this, metres lose their decimals.
const FARTHEST: f64 = 1e9;
/// Relative rounding error allowed for legs completely used up by their corners.
pub(super) const TOLERANCE: f64 = 1e-9;

pub(super) fn distance(a: Vec2, b: Vec2) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}

/// Checks the points one by one.
pub(super) fn check(points: &[Waypoint]) -> Result<(), CourseError> {
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
        if p.z.is_some() != points[0].z.is_some() {
            let reason = match p.z {
                Some(_) => "has a depth z, but the first point has none",
                None => "has no depth z, but the first point has one",
            };
            let reason = format!("{reason}; give one for every point or for none");
            return Err(CourseError::new(place, reason));
        }
        if let Some(z) = p.z.filter(|z| !z.is_finite() || z.abs() > FARTHEST) {
            let reason = format!("depth z = {z} must be a number within {FARTHEST:e} m");
            return Err(CourseError::new(place, reason));
        }
        if i > 0 && distance([p.x, p.y], [points[i - 1].x, points[i - 1].y]) < TOLERANCE {
            let reason = format!("({}, {}) repeats the point before; remove it", p.x, p.y);
            return Err(CourseError::new(place, reason));
        }
    }
    Ok(())
}
