//! Campaigns: many runs of systems, with other components, faults, parameters and seeds, and what
//! they say with confidence.
//!
//! A file says which runs there are ([`Campaign`]); a [`Bench`] makes any of them, alone from the
//! file and the run's number; a [`Folder`] keeps a row of each; a [`Judgement`] is what all rows say.
//! Who makes runs at the same time, and in which order, decides nothing.

mod bench;
mod design;
mod figure;
mod file;
mod folder;
mod judgement;
mod report;
mod row;
mod statistics;
mod trajectory;

pub use bench::Bench;
pub use file::Campaign;
pub use folder::{Contents, Folder};
pub use judgement::{Compared, FigureOfCell, Judgement, Verdict};
pub use report::{Report, report};
pub use row::{Row, Status};
pub use statistics::{Answer, Estimate};

/// What a campaign is, in a word: of its [`Bench::identity`].
pub fn fingerprint(identity: &[String]) -> String {
    crate::digest::sha256(identity.join("\n"))
}
