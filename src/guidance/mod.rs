//! Guidance: courses of straights and arcs, and the pure pursuit that follows them.
//!
//! Horizontal plane, NED: x north, y east, courses measured clockwise from north. Section 8 of the
//! paper, eqs (54) and (55).

mod course;
mod parse;
mod pursuit;
mod segment;

pub use course::{Course, CourseError, Place, Waypoint};
pub use pursuit::{Guidance, HeadingReference, PurePursuit, PursuitMemory, PursuitParameters};
