//! The common part of campaigns of simulated missions: runs on all cores, and verdicts on goals
//! that account for the limited number of seeds.

mod course;
mod interval;
mod threads;
mod verdict;

pub(crate) use course::mean_distance;
pub(crate) use interval::bootstrap;
pub(crate) use threads::{default_threads, on_threads};
pub(crate) use verdict::Verdict;
