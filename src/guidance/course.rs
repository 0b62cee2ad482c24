//! A course: corner points joined by straights, the corners rounded by arcs.
//!
//! A corner of turning angle phi and radius R takes `R tan(|phi|/2)` of both legs; radius 0 keeps
//! it sharp. Arc length s runs from 0 at the first point to the length of the course at the last.
//!
//! All of this is horizontal. Depth, if the points have one, is linear in s from waypoint to
//! waypoint; a rounded corner has the depth of its waypoint in the middle of its arc.

use super::segment::{Segment, Vec2};
use super::waypoint::{CourseError, Place, TOLERANCE, Waypoint, check, distance};
use core::f64::consts::FRAC_PI_2;

/// A path of straights and arcs.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    segments: Vec<Segment>,
    /// Arc length at the start of each segment, and the total length as the last element.
    starts: Vec<f64>,
    /// Arc length and depth `[s, z]` at each waypoint; empty if the course has no depths.
    depths: Vec<[f64; 2]>,
}

impl Course {
    /// Joins corner points.
    ///
    /// # Errors
    /// Fewer than two points, coincident neighbours, values that are not finite, a negative radius
    /// or one too large for the adjacent legs, or depths at only some of the points.
    pub fn new(points: &[Waypoint]) -> Result<Self, CourseError> {
        check(points)?;
        let legs: Vec<Leg> = points.windows(2).map(|w| Leg::new(w[0], w[1])).collect();
        let cuts = corner_cuts(points, &legs)?;
        let mut course = Self { segments: Vec::new(), starts: vec![0.0], depths: Vec::new() };
        for (i, leg) in legs.iter().enumerate() {
            let mut waypoint = course.length();
            if i > 0 && cuts[i] > 0.0 {
                course.push(leg.arc_from(&legs[i - 1], cuts[i], points[i].radius));
                waypoint = 0.5 * (waypoint + course.length());
            }
            course.depths.extend(points[i].z.map(|z| [waypoint, z]));
            let straight = leg.length - cuts[i] - cuts[i + 1];
            if straight > TOLERANCE * leg.length {
                let (start, direction) = (leg.point(cuts[i]), leg.direction);
                course.push(Segment::Straight { start, direction, length: straight });
            }
        }
        course.depths.extend(points[legs.len()].z.map(|z| [course.length(), z]));
        Ok(course)
    }

    fn push(&mut self, segment: Segment) {
        self.starts.push(self.length() + segment.length());
        self.segments.push(segment);
    }

    /// Length (m).
    #[must_use]
    pub fn length(&self) -> f64 {
        self.starts[self.segments.len()]
    }

    /// The point `[x, y]` at arc length `s`; beyond the ends the course continues straight.
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

    /// The depth (m) at arc length `s`, if the course has depths; beyond an end, the depth at that
    /// end.
    #[must_use]
    pub fn depth(&self, s: f64) -> Option<f64> {
        let next = self.depths.partition_point(|&[start, _]| start <= s);
        let before = next.checked_sub(1).and_then(|last| self.depths.get(last));
        match (before, self.depths.get(next)) {
            (Some([a, z]), Some([b, end])) => Some(z + (s - a) / (b - a) * (end - z)),
            (Some([_, z]), None) | (None, Some([_, z])) => Some(*z),
            (None, None) => None,
        }
    }

    /// Mean slope of the depth over the stretch of length `span` (m) around arc length `s`.
    ///
    /// It is continuous, also where the depth has a kink: there it changes over one `span`.
    #[must_use]
    pub fn slope(&self, s: f64, span: f64) -> Option<f64> {
        Some((self.depth(s + 0.5 * span)? - self.depth(s - 0.5 * span)?) / span)
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

    /// Sine and cosine of the turn from the previous leg to this one, positive to starboard.
    fn turn_from(&self, before: &Leg) -> (f64, f64) {
        let (a, b) = (before.direction, self.direction);
        (a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1])
    }

    /// The arc that joins the previous leg, `cut` ahead of the corner, to this one.
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

/// The length each corner takes of the adjacent legs; zero at the ends and where legs are in line.
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
            // Report the corner that takes more; of equal ones, the first.
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
