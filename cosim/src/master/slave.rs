//! What the master steps: an FMU here, prepared signals, later something remote.

use crate::error::Result;
use crate::fmi::guard::Float;
use crate::fmi::{Direct, Place, Unusual, Value};
use crate::time::Time;

/// A component as the master sees it. Which variables [`Slave::set`], [`Slave::get`] and
/// [`Slave::read`] carry, and in which order, is agreed when the slave is made; all values are
/// `f64`, which holds every FMI Integer and Boolean exactly.
///
/// Calls come in this order: `enter_initialization`, then `set` and `get` in turns,
/// `exit_initialization`, then `set`, `step`, `get` once per step; `read` at output instants.
/// States are kept and set back between steps only.
pub trait Slave {
    /// Gives the experiment and enters initialization mode.
    fn enter_initialization(&mut self, start: Time, stop: Time) -> Result<()>;

    /// Leaves initialization mode.
    fn exit_initialization(&mut self) -> Result<()>;

    /// Sets all connected inputs.
    fn set(&mut self, values: &[f64]) -> Result<()>;

    /// Sets all connected inputs for the beginning of the next step, with their time derivatives
    /// during it. Only slaves whose component interpolates its inputs are asked.
    fn ramp(&mut self, values: &[f64], slopes: &[f64]) -> Result<()>;

    /// Advances from `start` by `step`: the instant reached, which is less than the whole when the
    /// component discarded the rest. Then it must go back before anything else.
    fn step(&mut self, start: Time, step: Time) -> Result<Time>;

    /// Reads all connected outputs.
    fn get(&mut self, values: &mut [f64]) -> Result<()>;

    /// A step as most are: inputs set, step made, outputs read. One call instead of three. Empty
    /// arrays are left alone.
    fn advance(
        &mut self,
        inputs: &[f64],
        start: Time,
        step: Time,
        outputs: &mut [f64],
    ) -> Result<Time> {
        if !inputs.is_empty() {
            self.set(inputs)?;
        }
        let reached = self.step(start, step)?;
        // Nobody looks at the outputs of a step that is taken back.
        if reached == start + step && !outputs.is_empty() {
            self.get(outputs)?;
        }
        Ok(reached)
    }

    /// Reads the time derivatives of all connected outputs; whether the slave knows them.
    fn slopes(&mut self, slopes: &mut [f64]) -> Result<bool>;

    /// How the connected outputs change at once when the inputs change by `seed`; whether the
    /// slave knows that.
    fn tangent(&mut self, seed: &[f64], outputs: &mut [f64]) -> Result<bool>;

    /// Reads the variables that are only recorded.
    fn read(&mut self, values: &mut [f64]) -> Result<()>;

    /// Begins anew with its start values at `now`, between two steps of a run that ends at `stop`.
    fn reset(&mut self, now: Time, stop: Time) -> Result<()>;

    /// Sets an input that is not connected, or a parameter, between two steps. The variable is a
    /// position in the component's description.
    fn assign(&mut self, variable: usize, value: f64) -> Result<()>;

    /// Gives a variable that is not connected a value of its type, in initialization mode or
    /// between two steps.
    fn give(&mut self, variable: usize, value: &Value) -> Result<()>;

    /// The present value of any variable.
    fn look(&mut self, variable: usize) -> Result<Value>;

    /// What is odd since this was asked last.
    fn warnings(&mut self) -> Vec<String> {
        Vec::new()
    }

    /// What the slave had to say since this was asked last.
    fn messages(&mut self) -> Vec<String>;

    /// Keeps the present state in `place` for [`Slave::restore`].
    fn save(&mut self, place: Place) -> Result<()>;

    /// Goes back to the state kept there last, which was that of the instant `time`.
    fn restore(&mut self, place: Place, time: Time) -> Result<()>;

    /// The present state as bytes.
    fn serialize(&mut self) -> Result<Vec<u8>>;

    /// Takes on a state that [`Slave::serialize`] gave, maybe in another process, and which was
    /// that of the instant `time`. The slave has left its initialization.
    fn deserialize(&mut self, state: &[u8], time: Time) -> Result<()>;

    /// Asks for debug messages from now on, or not.
    fn debug(&mut self, _on: bool) -> Result<()> {
        Ok(())
    }

    /// How many steps were discarded and made again by smaller ones.
    fn rejected(&self) -> u64 {
        0
    }

    /// The calls that [`Slave::advance`] makes after the initialization, if these are all that it
    /// does (see `master::direct`).
    #[doc(hidden)]
    fn direct(&self) -> Option<DirectCalls<'_>> {
        None
    }

    /// Goes on after a direct call of the step from `start` by `step` did not go well.
    #[doc(hidden)]
    fn conclude(&mut self, _found: Unusual, _start: Time, _step: Time) -> Result<()> {
        Ok(())
    }

    /// Direct calls have brought the slave to this instant.
    #[doc(hidden)]
    fn came_to(&mut self, _now: Time) {}

    /// Sets back what the component changed of the process in `function`, and tells it in a message.
    fn check_process(&mut self, _function: &str) {}

    /// The same with the floating-point environment after a direct call.
    #[doc(hidden)]
    fn changed_float(&mut self, _before: Float) {}
}

/// The calls of a slave's step, and the value references of its inputs, its outputs and of the Reals
/// that are only recorded.
pub struct DirectCalls<'a> {
    pub(super) calls: Direct,
    pub(super) inputs: &'a [u32],
    pub(super) outputs: &'a [u32],
    pub(super) recorded: &'a [u32],
}

/// What a slave around another one leaves to it, but its steps and the states that it keeps; `Result`,
/// `Time` and `Value` are the caller's.
macro_rules! passes_on {
    ($inner:ident) => {
        fn enter_initialization(&mut self, start: Time, stop: Time) -> Result<()> {
            self.$inner.enter_initialization(start, stop)
        }

        fn exit_initialization(&mut self) -> Result<()> {
            self.$inner.exit_initialization()
        }

        fn reset(&mut self, now: Time, stop: Time) -> Result<()> {
            self.$inner.reset(now, stop)
        }

        fn assign(&mut self, variable: usize, value: f64) -> Result<()> {
            self.$inner.assign(variable, value)
        }

        fn give(&mut self, variable: usize, value: &Value) -> Result<()> {
            self.$inner.give(variable, value)
        }

        fn look(&mut self, variable: usize) -> Result<Value> {
            self.$inner.look(variable)
        }

        fn warnings(&mut self) -> Vec<String> {
            self.$inner.warnings()
        }

        fn messages(&mut self) -> Vec<String> {
            self.$inner.messages()
        }

        fn serialize(&mut self) -> Result<Vec<u8>> {
            self.$inner.serialize()
        }

        fn deserialize(&mut self, state: &[u8], time: Time) -> Result<()> {
            self.$inner.deserialize(state, time)
        }

        fn debug(&mut self, on: bool) -> Result<()> {
            self.$inner.debug(on)
        }

        fn check_process(&mut self, function: &str) {
            self.$inner.check_process(function)
        }

        fn rejected(&self) -> u64 {
            self.$inner.rejected()
        }
    };
}

/// Steps and the states that it keeps, too; `Place` is the caller's.
macro_rules! passes_steps_on {
    ($inner:ident) => {
        fn step(&mut self, start: Time, step: Time) -> Result<Time> {
            self.$inner.step(start, step)
        }

        fn save(&mut self, place: Place) -> Result<()> {
            self.$inner.save(place)
        }

        fn restore(&mut self, place: Place, time: Time) -> Result<()> {
            self.$inner.restore(place, time)
        }
    };
}
pub(super) use {passes_on, passes_steps_on};
