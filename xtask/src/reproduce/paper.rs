//! The numbers printed in the paper's Tables 7, 8 and 9.

use super::case::{Course, Filter};

/// One column of one table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Printed {
    /// Total, m.
    pub(crate) total: f64,
    /// X-Kalman, m.
    pub(crate) x: f64,
    /// Y-Kalman, m by the table, "MSE" by the text.
    pub(crate) y: f64,
}

/// The printed numbers for a course and a filter.
pub(crate) fn printed(course: Course, filter: Filter) -> Printed {
    let (total, x, y) = match (course, filter) {
        (Course::Be1, Filter::Dynamic) => (0.1166, 0.0825, 0.2665),
        (Course::Be1, Filter::Kinematic) => (0.0988, 0.3432, 1.024),
        (Course::Be2, Filter::Dynamic) => (0.1659, 0.1213, 0.3682),
        (Course::Be2, Filter::Kinematic) => (0.2482, 0.39145, 4.336),
        (Course::Be3, Filter::Dynamic) => (0.0738, 0.2462, 0.4003),
        (Course::Be3, Filter::Kinematic) => (0.1965, 0.4028, 4.0014),
    };
    Printed { total, x, y }
}
