//! A distributed run gives the bits of an ordinary one, whatever happens to its messages.

mod bits;
mod decoder;
mod faults;
mod fmu;
mod levels;
mod placement;
mod systems;
