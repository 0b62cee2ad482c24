//! A system computed by several processes, on one machine or many.
//!
//! ```text
//!  cosim run ──────── Coordinator ── Fabric ─┐      one message each way per group and level
//!                      order of the engine   │
//!                                            │ Zenoh (or, in tests, a queue)
//!  cosim worker ───── Supervisor             │
//!                      └─ child process: ────┴── Host ── Engine ── FMUs
//! ```
//!
//! * `layout` says which component is where, and who waits for whom;
//! * `wire` is the form of the messages, `setup` what a host is told first;
//! * `host` computes a group with the engine of an ordinary run;
//! * `coordinator` drives the groups, `recovery` and `member` what happens when one is lost;
//! * `fabric` is what carries messages; `net` does so over Zenoh, `session` opens it, `present` knows
//!   who is there;
//! * `worker` lends a machine, `child` is the process in which FMUs run, `fate` how it ended;
//! * `own` starts workers for one run.

mod child;
mod coordinator;
mod distribute;
mod fabric;
mod failure;
mod fate;
mod host;
mod keys;
mod layout;
#[cfg(test)]
mod local;
mod member;
mod net;
mod options;
mod own;
mod placement;
mod pool;
mod present;
mod recovery;
mod run;
mod session;
mod setup;
#[cfg(test)]
mod tests;
mod wire;
mod worker;

pub use child::serve as serve_group;
pub use options::Options;
pub use pool::{Order, WorkerInfo, default_name};
pub use run::{Cluster, workers};
pub use session::{Access, Credentials, DEFAULT_ENDPOINT};
pub use worker::Worker;
