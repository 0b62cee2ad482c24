//! A piece of a course, a straight or an arc, parameterized by arc length from its start.

use crate::attitude::wrap;

/// Horizontal point or direction, `[north, east]`.
pub(super) type Vec2 = [f64; 2];

/// A straight or an arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Segment {
    Straight {
        start: Vec2,
        /// Unit vector.
        direction: Vec2,
        length: f64,
    },
    Arc {
        centre: Vec2,
        radius: f64,
        /// Direction from the centre to the start (rad).
        from: f64,
        /// Signed change of course (rad), positive to starboard; below half a turn.
        turn: f64,
    },
}

impl Segment {
    pub(super) fn length(&self) -> f64 {
        match *self {
            Self::Straight { length, .. } => length,
            Self::Arc { radius, turn, .. } => radius * turn.abs(),
        }
    }

    /// The point at arc length `s` from the start, and the course there (rad).
    pub(super) fn at(&self, s: f64) -> (Vec2, f64) {
        match *self {
            Self::Straight { start, direction: d, .. } => {
                ([start[0] + s * d[0], start[1] + s * d[1]], libm::atan2(d[1], d[0]))
            }
            Self::Arc { centre, radius, from, turn } => {
                let angle = from + (s / radius).copysign(turn);
                let (sin, cos) = libm::sincos(angle);
                let course = wrap(angle + core::f64::consts::FRAC_PI_2.copysign(turn));
                ([centre[0] + radius * cos, centre[1] + radius * sin], course)
            }
        }
    }

    /// Arc length of the point nearest to `p` between arc lengths `low` and `high`.
    pub(super) fn nearest(&self, p: Vec2, low: f64, high: f64) -> f64 {
        let s = match *self {
            Self::Straight { start, direction: d, .. } => {
                (p[0] - start[0]) * d[0] + (p[1] - start[1]) * d[1]
            }
            Self::Arc { centre, radius, from, turn } => {
                let bearing = libm::atan2(p[1] - centre[1], p[0] - centre[0]);
                let walked = if turn < 0.0 { from - bearing } else { bearing - from };
                // Counted from the middle of the range, so that each side is clamped to its own
                // end.
                let middle = 0.5 * (low + high) / radius;
                radius * (middle + wrap(walked - middle))
            }
        };
        s.clamp(low, high)
    }
}
