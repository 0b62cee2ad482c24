//! Guidance: courses of straights and arcs, and the pure pursuit that follows them.
//!
//! NED: x north, y east, z down, courses measured clockwise from north. Horizontally, section 8 of
//! the paper, eqs (54) and (55); a course may give a depth along it.

mod course;
mod parse;
mod pursuit;
mod segment;
mod waypoint;

pub use course::Course;
pub use pursuit::{Guidance, HeadingReference, PurePursuit, PursuitMemory, PursuitParameters};
pub use waypoint::{CourseError, Place, Waypoint};
