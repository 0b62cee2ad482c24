//! The master against FMUs that are not ours, and the command line as a user sees it.

mod archives;
mod command;
mod exchange;
mod failures;
mod flags;
mod hostile;
mod import;
mod logging;
mod loops;
mod models;
mod mutations;
mod rawzip;
mod scheduler;
mod ssd;
mod systems;
