//! What an instance needs of the thing it simulates: the seam between the FMI rules and the
//! mathematics.
//!
//! [`Component`](crate::Component)s get here through
//! [`ComponentModel`](super::adapter::ComponentModel). Anything else that has a variable table and
//! can be stepped (a whole system, a proxy of a remote one) would implement this trait directly.

use std::any::Any;

use crate::author::{Fault, ParameterError, Time};

use super::signal::Slopes;
use super::values::{Explicit, Values};

/// What a model remembers besides its values, in a form only the model knows.
pub type Memory = Box<dyn Any + Send>;

/// Whether somebody reads the outputs besides the derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outputs {
    /// They are left as they are.
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

/// Why a step ended before its end; values are those of the last time that was reached.
#[derive(Clone, Debug, PartialEq)]
pub struct Halt {
    /// Time up to which all went well (s).
    pub reached_s: f64,
    /// What happened there.
    pub cause: Cause,
}

/// What ended a step.
#[derive(Clone, Debug, PartialEq)]
pub enum Cause {
    /// The component cannot go on: an error.
    Fault(Fault),
    /// The Real of this value reference would not be finite: the step is discarded.
    NotFinite(usize),
    /// The step takes more integration steps and events than one call may: it is discarded.
    Work,
    /// The integrator cannot keep to its tolerance: the step is discarded.
    Accuracy {
        /// Error of the shortest step, in units of what is tolerated.
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
    /// Gives the parameters nobody set their values, checks all, derives constants. `tolerance`
    /// is that of `fmi2SetupExperiment`.
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
    /// `changes`, which lie there as the Reals do, and writes those of the derivatives, and of the
    /// outputs if they are `wanted`. False if there is none.
    fn tangent(&self, t: f64, values: &Values, wanted: Outputs, changes: &mut [f64]) -> bool;

    /// The same for the start, where parameters change and states with them: reads the changes of
    /// parameters and inputs, and writes those of states, outputs and derivatives.
    fn initial_tangent(&self, t: f64, values: &Values, changes: &mut [f64]) -> bool;

    /// The next time event, if there is one.
    fn next_event(&self) -> Option<Time>;

    /// Model exchange: handles the time events due at `t` seconds, and looks for a state event.
    ///
    /// # Errors
    /// Why the simulation cannot go on.
    fn events(&mut self, t: f64, values: &mut Values) -> Result<Events, Fault>;

    /// Co-simulation: advances from `t` by `h` seconds, with inputs held or moving along `slopes`,
    /// and computes the outputs there; returns how many events there were. `fresh` says whether
    /// the outputs among the values are those of the beginning, with these inputs.
    ///
    /// # Errors
    /// How far it got and why not further.
    fn step(
        &mut self,
        t: f64,
        h: f64,
        slopes: Option<&Slopes>,
        fresh: bool,
        values: &mut Values,
    ) -> Result<usize, Halt>;

    /// What there is to write into the log since the last time.
    fn notice(&mut self) -> Option<String>;

    /// Copies the memory, into the place of an earlier copy if there is one.
    fn save(&self, into: &mut Option<Memory>);

    /// Takes back a copy; false if it is not one of this model's.
    fn restore(&mut self, from: &Memory) -> bool;

    /// How many bytes of memory a copy of the present memory takes at most.
    fn size(&self) -> usize;

    /// A copy as bytes.
    ///
    /// # Errors
    /// It is not a copy of this model's.
    fn pack(&self, memory: &Memory) -> Result<Vec<u8>, String>;

    /// A copy from bytes.
    ///
    /// # Errors
    /// The bytes are not the memory of such a model.
    fn unpack(&self, bytes: &[u8]) -> Result<Memory, String>;
}
