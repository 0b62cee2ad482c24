//! Watches and controls a run from a browser or from Foxglove.
//!
//! A [`Server`] listens on one port. It serves the page, whose script uses a WebSocket, and the
//! Foxglove WebSocket protocol, for Foxglove and Lichtblick. Each address contains a token, without
//! which nothing is answered.
//!
//! The run passes its samples to [`Watch`], an observer that copies them and returns: threads of
//! the server send the copies, and drop what a client does not take in time. Requests of clients
//! wait in a queue until the run checks it ([`Server::request`]) at an output instant. A run
//! therefore has the same results with and without clients; injected faults are saved as a scenario
//! ([`cosim_core::scenario::Injected`]).

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
