//! The master against FMUs that are not ours, and the command line as a user sees it.

mod algorithms;
mod archives;
mod checked;
mod clock;
mod command;
mod convert;
mod converted;
mod exchange;
mod failures;
mod formats;
mod import;
mod loops;
mod manipulations;
mod models;
mod osp;
mod results;
mod scheduler;
mod snapshots;
mod ssd;
mod ssp;
mod stepping;
mod systems;
mod units;
