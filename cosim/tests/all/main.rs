//! The master against FMUs that are not ours, and the command line as a user sees it.

mod algorithms;
mod archives;
mod clock;
mod command;
mod exchange;
mod failures;
mod import;
mod loops;
mod manipulations;
mod models;
mod results;
mod scheduler;
mod snapshots;
mod ssd;
mod stepping;
mod systems;
