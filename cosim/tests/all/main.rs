//! The master against FMUs that are not ours, and the command line as a user sees it.

mod archives;
mod checked;
mod command;
mod convert;
mod converted;
mod exchange;
mod failures;
mod formats;
mod import;
mod loops;
mod models;
mod osp;
mod scheduler;
mod ssd;
mod ssp;
mod systems;
mod units;
