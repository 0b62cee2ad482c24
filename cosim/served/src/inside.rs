//! The inner implementation of an FMU that `cosim` writes: a complete system, or a remote one.

use cosim_base::Result;
use cosim_import::Basic;
use cosim_import::Message;
use cosim_import::calls::Values;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The arguments of `fmi2SetupExperiment`, in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Experiment {
    /// Relative tolerance, if there is one.
    pub tolerance: Option<f64>,
    /// Start time.
    pub start_s: f64,
    /// Stop time, if it is known.
    pub stop_s: Option<f64>,
}

/// The inner implementation. It gets only legal calls; a failure leaves it in the state that FMI
/// defines.
pub trait Inside: Sized + Send + 'static {
    /// Its saved state.
    type Kept: Clone + Serialize + DeserializeOwned + Send + 'static;

    /// Whether it decides itself how to handle Reals that are not finite.
    const TAKES_ANY_REAL: bool = false;

    /// The GUID of the FMU.
    fn guid(&self) -> &str;

    /// Messages since the last call.
    fn messages(&mut self) -> Vec<Message>;

    /// Switches debug messages on or off.
    fn debug(&mut self, on: bool, categories: &[&str]) -> Result<()>;

    /// Back to the start.
    fn reset(&mut self) -> Result<()>;

    /// Enters initialization mode.
    fn enter(&mut self, experiment: &Experiment) -> Result<()>;

    /// Leaves initialization mode; returns warnings.
    fn exit(&mut self) -> Result<Vec<String>>;

    /// Ends the simulation.
    fn terminate(&mut self) -> Result<()>;

    /// Makes the step from `t` by `h`.
    fn step(&mut self, t: f64, h: f64) -> Result<()>;

    /// Reals that only need copying between steps; `None` if that is not possible.
    fn at_hand(&self, references: &[u32], into: &mut [f64]) -> Option<()>;

    /// Reads variables.
    fn get(&mut self, basic: Basic, references: &[u32]) -> Result<Values>;

    /// Sets all of these variables or none.
    fn set(&mut self, references: &[u32], values: Values) -> Result<()>;

    /// How unknowns change along a direction of knowns, without delay; if this is not implemented,
    /// the FMU must not declare it.
    fn slope(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        along: &[f64],
    ) -> Option<Result<Vec<f64>>>;

    /// The current state.
    fn save(&mut self) -> Result<Self::Kept>;

    /// Restores a state.
    fn restore(&mut self, kept: &Self::Kept) -> Result<()>;
}
