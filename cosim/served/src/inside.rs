//! What is inside of an FMU that `cosim` writes: a whole system, or one that is computed elsewhere.

use cosim::Result;
use cosim::fmi::Message;
use cosim::proxy::calls::{Basic, Values};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// What the importer said in `fmi2SetupExperiment`, in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Experiment {
    /// Relative tolerance, if there is one.
    pub tolerance: Option<f64>,
    /// First instant.
    pub start_s: f64,
    /// Last instant, if it is known.
    pub stop_s: Option<f64>,
}

/// What is inside. It is asked only what is legal; a failure leaves it as FMI has it after one.
pub trait Inside: Sized + Send + 'static {
    /// Its saved state.
    type Kept: Clone + Serialize + DeserializeOwned + Send + 'static;

    /// Whether it decides itself what to do with Reals that are not finite.
    const TAKES_ANY_REAL: bool = false;

    /// The identity of the FMU.
    fn guid(&self) -> &str;

    /// What was said inside since this was asked last.
    fn messages(&mut self) -> Vec<Message>;

    /// Asks for debug messages, or not.
    fn debug(&mut self, on: bool, categories: &[&str]) -> Result<()>;

    /// Back to the beginning.
    fn reset(&mut self) -> Result<()>;

    /// Enters initialization mode.
    fn enter(&mut self, experiment: &Experiment) -> Result<()>;

    /// Leaves initialization mode; gives what was odd.
    fn exit(&mut self) -> Result<Vec<String>>;

    /// Ends the simulation.
    fn terminate(&mut self) -> Result<()>;

    /// Makes the step from `t` by `h`.
    fn step(&mut self, t: f64, h: f64) -> Result<()>;

    /// Reals between steps that only need copying; `None` if it is not so simple.
    fn at_hand(&self, references: &[u32], into: &mut [f64]) -> Option<()>;

    /// Reads variables.
    fn get(&mut self, basic: Basic, references: &[u32]) -> Result<Values>;

    /// Sets all of these variables or none.
    fn set(&mut self, references: &[u32], values: Values) -> Result<()>;

    /// How unknowns change at once along a direction of knowns; without an answer the FMU does
    /// not declare that it has one.
    fn slope(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        along: &[f64],
    ) -> Option<Result<Vec<f64>>>;

    /// The present state.
    fn save(&mut self) -> Result<Self::Kept>;

    /// Back to a state.
    fn restore(&mut self, kept: &Self::Kept) -> Result<()>;
}
