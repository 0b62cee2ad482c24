//! What an instance requires of the object it simulates: the interface between the FMI rules and
//! the mathematics.
//!
//! [`Component`](crate::Component)s implement it through
//! [`ComponentModel`](super::adapter::ComponentModel). Anything else that has a variable table and
//! can be stepped (a whole system, a proxy of a remote one) would implement this trait directly.

use std::any::Any;

use crate::author::{Fault, ParameterError, Time};

use super::signal::Slopes;
use super::values::{Explicit, Values};

/// A model's memory besides its values, in a form that only the model knows.
pub type Memory = Box<dyn Any + Send>;

/// Whether the outputs are needed besides the derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outputs {
    /// They are left unchanged.
    Unread,
    /// They are computed, too.
    Wanted,
}

/// What happened when events were handled.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Events {
    /// How many time events there were.
    pub time_events: usize,
    /// Whether a state event changed something, so that another may follow at the same instant.
    pub changed: bool,
}

/// Why a step ended early; values are those of the last time that was reached.
#[derive(Clone, Debug, PartialEq)]
pub struct Halt {
    /// Time up to which the step succeeded (s).
    pub reached_s: f64,
    /// What happened there.
    pub cause: Cause,
}

/// The cause that ended a step.
#[derive(Clone, Debug, PartialEq)]
pub enum Cause {
    /// The component cannot continue: an error.
    Fault(Fault),
    /// The Real with this value reference would not be finite: the step is discarded.
    NotFinite(usize),
    /// The step takes more integration steps and events than one call may: it is discarded.
    Work,
    /// The integrator cannot meet its tolerance: the step is discarded.
    Accuracy {
        /// Error of the shortest step, relative to the tolerance.
        error: f64,
        /// The tolerance.
        tolerance: f64,
    },
}

/// A model that works on the flat values of an instance; object safe.
///
/// The instance calls [`configure`](Model::configure) first, then
/// [`initialize`](Model::initialize), then anything.
pub trait Model: Send {
    /// Sets the parameters that have not been set, checks all, derives constants. `tolerance` is
    /// that of `SetupExperiment`.
    ///
    /// # Errors
    /// Names the parameter that is wrong.
    fn configure(
        &mut self,
        values: &mut Values,
        explicit: &Explicit,
        tolerance: Option<f64>,
    ) -> Result<(), ParameterError>;

    /// Sets the states at the start time from parameters and inputs.
    ///
    /// # Errors
    /// Why the simulation cannot start.
    fn initialize(&mut self, start: Time, values: &mut Values) -> Result<(), Fault>;

    /// Computes the outputs at `t` seconds.
    fn outputs(&self, t: f64, values: &mut Values);

    /// Computes the derivatives at `t` seconds.
    fn derivatives(&self, t: f64, values: &mut Values);

    /// Computes the event indicators at `t` seconds.
    fn indicators(&self, t: f64, values: &Values, into: &mut [f64]);

    /// The tangent-linear model at `t` seconds: reads the changes of inputs and states from
    /// `changes`, which is laid out like the Reals, and writes those of the derivatives, and of the
    /// outputs if they are `wanted`. False if there is none.
    fn tangent(&self, t: f64, values: &Values, wanted: Outputs, changes: &mut [f64]) -> bool;

    /// The same for the start, where parameters change and the states with them: reads the changes
    /// of parameters and inputs, and writes those of states, outputs and derivatives.
    fn initial_tangent(&self, t: f64, values: &Values, changes: &mut [f64]) -> bool;

    /// The next time event, if there is one.
    fn next_event(&self) -> Option<Time>;

    /// Model exchange: handles the time events due at `t` seconds, and checks for a state event.
    ///
    /// # Errors
    /// Why the simulation cannot continue.
    fn events(&mut self, t: f64, values: &mut Values) -> Result<Events, Fault>;

    /// Co-simulation: advances from `t` by `h` seconds, with inputs held or changing along
    /// `slopes`, and computes the outputs there; returns how many events there were. `fresh` says
    /// whether the outputs among the values are those of the beginning, with these inputs.
    ///
    /// # Errors
    /// How far it got and why no further.
    fn step(
        &mut self,
        t: f64,
        h: f64,
        slopes: Option<&Slopes>,
        fresh: bool,
        values: &mut Values,
    ) -> Result<usize, Halt>;

    /// New messages for the log.
    fn notice(&mut self) -> Option<String>;

    /// Copies the memory, into an earlier copy if there is one.
    fn save(&self, into: &mut Option<Memory>);

    /// Restores a copy; false if it does not belong to this model.
    fn restore(&mut self, from: &Memory) -> bool;

    /// Maximum bytes of memory for a copy of the present memory.
    fn size(&self) -> usize;

    /// A copy as bytes.
    ///
    /// # Errors
    /// The copy does not belong to this model.
    fn pack(&self, memory: &Memory) -> Result<Vec<u8>, String>;

    /// A copy from bytes.
    ///
    /// # Errors
    /// The bytes are not the memory of this model.
    fn unpack(&self, bytes: &[u8]) -> Result<Memory, String>;
}
