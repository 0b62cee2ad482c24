//! What the master steps: an FMU here, prepared signals, later something remote.

use crate::error::Result;
use crate::time::Time;

/// A component as the master sees it. Which variables [`Slave::set`], [`Slave::get`] and
/// [`Slave::read`] carry, and in which order, is agreed when the slave is made; all values are
/// `f64`, which holds every FMI Integer and Boolean exactly.
///
/// Calls come in this order: `enter_initialization`, then `set` and `get` in turns,
/// `exit_initialization`, then `set`, `step`, `get` once per step; `read` at output instants.
pub trait Slave {
    /// Gives the experiment and enters initialization mode.
    fn enter_initialization(&mut self, start: Time, stop: Time) -> Result<()>;

    /// Leaves initialization mode.
    fn exit_initialization(&mut self) -> Result<()>;

    /// Sets all connected inputs.
    fn set(&mut self, values: &[f64]) -> Result<()>;

    /// Advances from `start` by `step`.
    fn step(&mut self, start: Time, step: Time) -> Result<()>;

    /// Reads all connected outputs.
    fn get(&mut self, values: &mut [f64]) -> Result<()>;

    /// Reads the variables that are only recorded.
    fn read(&mut self, values: &mut [f64]) -> Result<()>;

    /// What the slave had to say since this was asked last.
    fn messages(&mut self) -> Vec<String>;

    /// Keeps the present state for [`Slave::restore`].
    fn save(&mut self) -> Result<()>;

    /// Goes back to the state kept last, which was that of the instant `time`.
    fn restore(&mut self, time: Time) -> Result<()>;
}
