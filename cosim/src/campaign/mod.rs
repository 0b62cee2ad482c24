//! Campaigns: many runs of systems, with other components, faults, parameters and seeds, and what
//! they say with confidence.
//!
//! A file says which runs there are ([`Campaign`]); a [`Bench`] makes any of them, alone from the
//! file and the run's number; a [`Folder`] keeps a row of each; a [`Judgement`] is what all rows say.
//! Who makes runs at the same time, and in which order, decides nothing.

mod bench;
mod change;
mod design;
mod figure;
mod file;
mod folder;
mod judgement;
mod keep;
mod report;
mod row;
mod score;
mod statistics;
mod table;
mod trajectory;

pub use bench::Bench;
pub use change::{Change, Meaning, changes};
pub use file::Campaign;
pub use folder::{Contents, Folder};
pub use judgement::{Compared, Consistency, FigureOfCell, Judgement, Verdict};
pub use keep::kept;
pub use report::{Report, report};
pub use row::{Number, Row, Status};
pub use score::Figures;
pub use statistics::{Answer, Estimate};

/// What a campaign is, in a word: of its [`Bench::identity`].
pub fn fingerprint(identity: &[String]) -> String {
    crate::digest::sha256(identity.join("\n"))
}
