//! Campaigns: many runs of systems with different components, faults, parameters and seeds, and
//! their statistics with confidence.
//!
//! A file defines the runs ([`Campaign`]); a [`Bench`] makes any of them from the file and the
//! number of the run alone; a [`Folder`] stores a row of each; a [`Judgement`] evaluates all rows.
//! Parallel execution and the order of runs have no effect on the results.

mod bench;
mod change;
mod columns;
mod contents;
mod design;
mod figure;
mod file;
mod folder;
mod judgement;
mod keep;
mod log;
mod merge;
mod report;
mod rotation;
mod row;
mod rows;
mod score;
mod statistics;
mod table;
mod trajectory;

pub use bench::Bench;
pub use change::{Change, Meaning, changes};
pub use contents::Contents;
pub use file::Campaign;
pub use folder::Folder;
pub use judgement::{Compared, Consistency, Errors, FigureOfCell, Judgement, Verdict};
pub use keep::kept;
pub use report::{Report, report};
pub use row::{Number, Row, RowDigest, Status};
pub use rows::Rows;
pub use score::Figures;
pub use statistics::{Answer, Estimate};

/// A short form of the identity of a campaign ([`Bench::identity`]).
pub fn fingerprint(identity: &[String]) -> String {
    cosim_base::sha256(identity.join("\n"))
}
