//! The trait an author implements.
//!
//! A component is described once, in its model-exchange nature
//!
//! ```text
//! dx/dt = derivatives(t, m, x, u)      continuous states x, held discrete memory m
//! y     = outputs(t, m, x, u)
//! (m, x) := event(t, m, x, u)          at the instants next_event announces
//! (m, x) := state_event(t, m, x, u)    where one of indicators(t, m, x, u) changes its sign
//! ```
//!
//! and the kernel makes both FMI interfaces from it: model exchange hands these functions to the
//! importer's solver, co-simulation runs the kernel's own stepper over them.

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{Fault, Info, ParameterError, Resources, Time, Variables, runge_kutta};

/// Variables of a port group: plain values, so no `String`. Inputs and outputs are `f64`, `i32`,
/// `bool` and enumerations; states are Real only (checked when the component is compiled).
pub trait Ports: Variables + Copy + Default + Send {}

impl<T: Variables + Copy + Default + Send> Ports for T {}

/// The continuous states of a component that has none.
pub type NoStates = ();

/// An FMI component: implement this and name the type in [`export!`](crate::export).
///
/// The value itself holds what [`new`](Component::new) derived from the parameters (an inverted
/// mass matrix, a parsed course); everything that changes during a simulation lives in `States`
/// and `Memory`, so that the kernel can save, restore and probe it.
///
/// All functions must be deterministic: the same arguments give the same bits. They must neither
/// allocate nor lock in `derivatives`, `outputs` and `event`.
pub trait Component: Sized + Send + 'static {
    /// Name, description, default experiment.
    const INFO: Info;
    /// Names of the event indicators, at most 64; none if the component has no state events.
    const INDICATORS: &'static [&'static str] = &[];
    /// Whether the indicators follow from the inputs alone and only mark kinks of the right-hand
    /// side, so that there is nothing to do at a crossing but to start the integration anew there.
    /// Co-simulation then looks at them in those steps only in which inputs move.
    const KINKS_OF_INPUTS: bool = false;
    /// Whether inputs may be anything, infinities and what is not a number among them: for components
    /// that judge what they are given. Otherwise the kernel refuses such values.
    const ANY_INPUT: bool = false;
    /// What a `Memory` may allocate at most besides what it holds, in bytes: room that it keeps for
    /// later. Memory is asked for before states are copied, so that a host without it gets an error.
    const ROOM: usize = 32 << 10;
    /// Whether [`tangent`](Component::tangent) is there.
    const TANGENT: bool = false;
    /// Parameters: of any variable type, fixed once initialization is over. Those that say
    /// `#[var(tunable)]` may change later, too: [`new`](Component::new) then derives the constants
    /// anew, states and memory stay.
    type Parameters: Variables + Default;
    /// Inputs. Their `Default` is the start value. Those that are no Reals are discrete.
    type Inputs: Ports;
    /// Outputs. Their `Default` is what is read before anything could be computed.
    type Outputs: Ports;
    /// Continuous states (Real only), [`NoStates`] if there are none.
    type States: Ports;
    /// Discrete state: next sample instant, filter state, random number generator.
    type Memory: Clone + Default + Send + Serialize + DeserializeOwned + 'static;

    /// The values of the parameters the user left alone, given those that were set.
    ///
    /// Override it to offer named parameter sets: `selected.parameter_set` names one, the result
    /// is that set. What the user set explicitly wins over it, in whatever order it was set.
    fn preset(selected: &Self::Parameters) -> Self::Parameters {
        let _ = selected;
        Self::Parameters::default()
    }

    /// Checks the parameters and derives constants from them.
    ///
    /// # Errors
    /// Names the offending variable, what is wrong with it and what would be right. Declared
    /// `min` and `max` are checked by the kernel already.
    fn new(parameters: &Self::Parameters, resources: &Resources) -> Result<Self, ParameterError>;

    /// States and memory at the start time, given the inputs; the `Default` of both unless you
    /// override it.
    ///
    /// Called again whenever a parameter or an input changes before initialization ends.
    ///
    /// # Errors
    /// A [`Fault`] says why the simulation cannot start from these inputs.
    fn initial(
        &self,
        start: Time,
        inputs: &Self::Inputs,
    ) -> Result<(Self::States, Self::Memory), Fault> {
        let _ = (start, inputs);
        Ok((Self::States::default(), Self::Memory::default()))
    }

    /// Time derivatives of the states (in a `States` of their own, unit per second). Whoever has
    /// continuous states overrides this; the default serves [`NoStates`].
    fn derivatives(
        &self,
        t: f64,
        memory: &Self::Memory,
        states: &Self::States,
        inputs: &Self::Inputs,
    ) -> Self::States {
        let _ = (t, memory, states, inputs);
        Self::States::default()
    }

    /// [`derivatives`](Component::derivatives) as a function of time and states while memory and
    /// inputs are held, for the stages of an integration step.
    ///
    /// Where the outputs of that very point are known, as at the beginning of most steps, they come
    /// along. Only their time may be another by rounding.
    ///
    /// Override it where part of the work depends on the inputs alone and need not be done again
    /// for each stage, or stands among the outputs already; it must give the same bits.
    fn held_derivatives(
        &self,
        memory: &Self::Memory,
        inputs: &Self::Inputs,
    ) -> impl Fn(f64, &Self::States, Option<&Self::Outputs>) -> Self::States {
        move |t, states, _| self.derivatives(t, memory, states, inputs)
    }

    /// A step of the fixed-step method while memory and inputs are held: it advances the states by `h`
    /// seconds from `t`. The outputs there come along where they are known.
    ///
    /// Override the classical Runge-Kutta method where a part of the states has a closed form, such as the
    /// lag of a held command, which then need not limit the step.
    fn held_step(
        &self,
        memory: &Self::Memory,
        inputs: &Self::Inputs,
    ) -> impl Fn(&mut Self::States, f64, f64, Option<&Self::Outputs>) {
        let slope = self.held_derivatives(memory, inputs);
        move |states, t, h, known| {
            let first = slope(t, states, known);
            runge_kutta(&|t, states: &Self::States| slope(t, states, None), first, states, t, h);
        }
    }

    /// The outputs at time `t` in seconds.
    fn outputs(
        &self,
        t: f64,
        memory: &Self::Memory,
        states: &Self::States,
        inputs: &Self::Inputs,
    ) -> Self::Outputs;

    /// The next instant at which [`event`](Component::event) wants to run, if there is one.
    fn next_event(&self, memory: &Self::Memory) -> Option<Time> {
        let _ = memory;
        None
    }

    /// Handles the time event of the instant `now`; must move `next_event` past `now`.
    ///
    /// # Errors
    /// A [`Fault`] says why the simulation cannot go on; the kernel reports it and stops.
    fn event(
        &self,
        now: Time,
        memory: &mut Self::Memory,
        states: &mut Self::States,
        inputs: &Self::Inputs,
    ) -> Result<(), Fault> {
        let _ = (now, memory, states, inputs);
        Ok(())
    }

    /// Fills in the event indicators, as many as [`INDICATORS`](Component::INDICATORS) has names.
    ///
    /// Where one of them crosses zero, the right-hand side changes its form: a height at which
    /// something bounces, the distance to a limit. Let them depend on the mode in `memory` so that
    /// they are well off zero after the event (a limit that has been reached is left by another
    /// condition than it was reached); that is what keeps a component from chattering.
    fn indicators(
        &self,
        t: f64,
        memory: &Self::Memory,
        states: &Self::States,
        inputs: &Self::Inputs,
        indicators: &mut [f64],
    ) {
        let _ = (t, memory, states, inputs, indicators);
    }

    /// Brings mode and states into line where an indicator may have changed its sign; tells
    /// whether it changed anything. It is called again until it has not.
    ///
    /// Solvers stop a little before or a little behind the crossing and also come for other
    /// reasons, so look at the values and do nothing if there is nothing to do.
    ///
    /// # Errors
    /// A [`Fault`] says why the simulation cannot go on.
    fn state_event(
        &self,
        t: f64,
        memory: &mut Self::Memory,
        states: &mut Self::States,
        inputs: &Self::Inputs,
    ) -> Result<bool, Fault> {
        let _ = (t, memory, states, inputs);
        Ok(false)
    }

    /// A line for the log, taken out of the memory so that it is written once.
    ///
    /// The kernel asks after initialization and after events;
    /// while there is nothing new to say this must not allocate.
    fn notice(memory: &mut Self::Memory) -> Option<String> {
        let _ = memory;
        None
    }

    /// The tangent-linear model: how derivatives and outputs change, to first order, when the
    /// states change by `dx` and the inputs by `du`. Set [`TANGENT`](Component::TANGENT) if you
    /// write it, and let neither derivatives nor outputs depend on time other than through states
    /// and inputs: the time derivatives of the outputs are made from it, too.
    fn tangent(
        &self,
        t: f64,
        memory: &Self::Memory,
        states: &Self::States,
        inputs: &Self::Inputs,
        dx: &Self::States,
        du: &Self::Inputs,
    ) -> (Self::States, Self::Outputs) {
        let _ = (t, memory, states, inputs, dx, du);
        (Self::States::default(), Self::Outputs::default())
    }

    /// The rest of the tangent-linear model at the start, where parameters may still change by `dp`
    /// and inputs by `du`: the change of the states that [`initial`](Component::initial) gives, and
    /// the changes of derivatives and outputs that the parameters make by themselves, at these
    /// states and inputs. The kernel adds what [`tangent`](Component::tangent) says of the change
    /// of states and inputs.
    ///
    /// `parameters` are the ones in force, `dp` holds changes in its Reals and the same values as
    /// they in all else. Whoever writes `tangent` and has Real parameters, or an initial state that
    /// follows from the inputs, writes this too.
    fn initial_tangent(
        &self,
        states: &Self::States,
        inputs: &Self::Inputs,
        parameters: &Self::Parameters,
        dp: &Self::Parameters,
        du: &Self::Inputs,
    ) -> (Self::States, Self::States, Self::Outputs) {
        let _ = (states, inputs, parameters, dp, du);
        (Self::States::default(), Self::States::default(), Self::Outputs::default())
    }
}
