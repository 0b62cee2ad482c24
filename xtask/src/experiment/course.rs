//! How closely a course was followed.

use cosim::report::mean;
use rexrov::guidance::Course;

/// Mean horizontal distance of a path from the course (m).
pub(crate) fn mean_distance(course: &Course, x: &[f64], y: &[f64]) -> f64 {
    let distance = |(x, y): (&f64, &f64)| {
        let nearest = course.point(course.nearest([*x, *y], 0.0, course.length()));
        (x - nearest[0]).hypot(y - nearest[1])
    };
    mean(&x.iter().zip(y).map(distance).collect::<Vec<_>>())
}
