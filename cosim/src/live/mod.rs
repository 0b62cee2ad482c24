//! Watching a run, and acting on it, from a browser or from Foxglove.
//!
//! A [`Server`] listens on one port. It serves the page, whose script talks to it by WebSocket, and the
//! Foxglove WebSocket protocol, for Foxglove and Lichtblick. Each address has a token, without which
//! nothing is answered.
//!
//! The run gives its samples to [`Watch`], an observer that copies what it keeps and goes on: threads
//! of the server's send it, and drop what a client does not take in time. What clients ask for waits
//! in a queue until the run looks at it ([`Server::wish`]), at an output instant. So a run has the same
//! results with clients and without; faults that are injected are kept as a scenario
//! ([`crate::scenario::Injected`]).

mod batch;
mod client;
mod foxglove;
mod http;
mod hub;
mod page;
mod server;
mod watch;

pub use hub::{Playing, Request};
pub use server::Server;
pub use watch::Watch;
