//! What the master steps: an FMU in this process or prepared signals.

use cosim_base::error::Result;
use cosim_base::time::Time;
use cosim_import::guard::Float;
use cosim_import::{Direct, Place, Scalar, Unusual, Value};

/// A component from the master's point of view. Which variables [`Slave::set`], [`Slave::get`] and
/// [`Slave::read`] transfer, and in which order, is fixed when the slave is created.
///
/// Calls come in this order: `enter_initialization`, then `set` and `get` alternately,
/// `exit_initialization`, then `set`, `step`, `get` once per step; `read` at output instants.
/// States are saved and restored between steps only.
pub trait Slave {
    /// Sets up the experiment and enters initialization mode.
    fn enter_initialization(&mut self, start: Time, stop: Time) -> Result<()>;

    /// Leaves initialization mode.
    fn exit_initialization(&mut self) -> Result<()>;

    /// Sets all connected inputs.
    fn set(&mut self, values: &[Scalar]) -> Result<()>;

    /// Sets all connected inputs for the start of the next step, with their time derivatives during
    /// it, which are 0 for other types than Real. Only called for slaves whose component interpolates its inputs.
    fn ramp(&mut self, values: &[Scalar], slopes: &[f64]) -> Result<()>;

    /// Advances from `start` by `step`; returns the instant reached, which is before the end if the
    /// component discarded the rest. Then it must go back before anything else.
    fn step(&mut self, start: Time, step: Time) -> Result<Time>;

    /// Reads all connected outputs.
    fn get(&mut self, values: &mut [Scalar]) -> Result<()>;

    /// The usual step: sets inputs, steps, reads outputs. One call instead of three. Nothing is
    /// called for empty arrays.
    fn advance(
        &mut self,
        inputs: &[Scalar],
        start: Time,
        step: Time,
        outputs: &mut [Scalar],
    ) -> Result<Time> {
        if !inputs.is_empty() {
            self.set(inputs)?;
        }
        let reached = self.step(start, step)?;
        // The outputs of a step that is rolled back are not read.
        if reached == start + step && !outputs.is_empty() {
            self.get(outputs)?;
        }
        Ok(reached)
    }

    /// Reads the time derivatives of all connected outputs; returns whether the slave knows them.
    fn slopes(&mut self, slopes: &mut [f64]) -> Result<bool>;

    /// How the connected outputs change immediately when the inputs change by `seed`; returns
    /// whether the slave knows that.
    fn tangent(&mut self, seed: &[f64], outputs: &mut [f64]) -> Result<bool>;

    /// Reads the variables that are only recorded.
    fn read(&mut self, values: &mut [Scalar]) -> Result<()>;

    /// Restarts with its start values at `now`, between two steps of a run that ends at `stop`.
    fn reset(&mut self, now: Time, stop: Time) -> Result<()>;

    /// Sets an unconnected input, or a parameter, to a value of its type, in initialization mode or
    /// between two steps. The variable is a position in the component's description.
    fn give(&mut self, variable: usize, value: &Value) -> Result<()>;

    /// The current value of any variable.
    fn look(&mut self, variable: usize) -> Result<Value>;

    /// Warnings since the last call.
    fn warnings(&mut self) -> Vec<String> {
        Vec::new()
    }

    /// Messages since the last call.
    fn messages(&mut self) -> Vec<String>;

    /// Saves the current state in `place` for [`Slave::restore`].
    fn save(&mut self, place: Place) -> Result<()>;

    /// Goes back to the state last saved there, which was that of the instant `time`.
    fn restore(&mut self, place: Place, time: Time) -> Result<()>;

    /// The current state as bytes.
    fn serialize(&mut self) -> Result<Vec<u8>>;

    /// Restores a state from [`Slave::serialize`], possibly of another process, which was that of
    /// the instant `time`. The slave must have left initialization.
    fn deserialize(&mut self, state: &[u8], time: Time) -> Result<()>;

    /// Switches debug messages on or off.
    fn debug(&mut self, _on: bool) -> Result<()> {
        Ok(())
    }

    /// How many steps were discarded and repeated with smaller ones.
    fn rejected(&self) -> u64 {
        0
    }

    /// The calls that [`Slave::advance`] makes after initialization, if it does nothing else (see
    /// `master::direct`).
    #[doc(hidden)]
    fn direct(&self) -> Option<DirectCalls<'_>> {
        None
    }

    /// Continues after a direct call of the step from `start` by `step` did not succeed.
    #[doc(hidden)]
    fn conclude(&mut self, _found: Unusual, _start: Time, _step: Time) -> Result<()> {
        Ok(())
    }

    /// Direct calls have brought the slave to this instant.
    #[doc(hidden)]
    fn came_to(&mut self, _now: Time) {}

    /// Undoes what the component changed in the process in `function`, and reports it in a message.
    fn check_process(&mut self, _function: &str) {}

    /// The same for the floating-point environment after a direct call.
    #[doc(hidden)]
    fn changed_float(&mut self, _before: Float) {}
}

/// The calls of a slave's step, and the value references of its inputs, of its outputs and of the
/// Reals that are only recorded.
pub struct DirectCalls<'a> {
    pub(super) calls: Direct,
    pub(super) inputs: &'a [u32],
    pub(super) outputs: &'a [u32],
    pub(super) recorded: &'a [u32],
}

/// The methods that a wrapping slave delegates, except its steps and saved states; `Result`, `Time`
/// and `Value` are the caller's.
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

/// Also its steps and saved states; `Place` is the caller's.
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
