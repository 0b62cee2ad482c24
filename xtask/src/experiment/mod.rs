//! What the campaigns of simulated missions share: runs on all cores, and verdicts on goals that
//! know how little a number of seeds says.

mod course;
mod interval;
mod threads;
mod verdict;

pub(crate) use course::mean_distance;
pub(crate) use interval::bootstrap;
pub(crate) use threads::{default_threads, on_threads};
pub(crate) use verdict::Verdict;
