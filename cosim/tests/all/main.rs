//! The master against FMUs that are not ours, and the command line as a user sees it.

mod algorithms;
mod archives;
mod clock;
mod command;
mod exchange;
mod failures;
mod flags;
mod hostile;
mod import;
mod logging;
mod loops;
mod manipulations;
mod models;
mod mutations;
mod rawzip;
mod results;
mod scheduler;
mod snapshots;
mod ssd;
mod stepping;
mod systems;
