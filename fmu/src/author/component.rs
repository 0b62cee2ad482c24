//! The trait an author implements.
//!
//! A component is described once, for model exchange,
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

/// Variables of a group of inputs, outputs or states: plain values, so no `String`. Inputs and
/// outputs are `f64`, `i32`, `bool`, enumerations and [`Text`](super::Text); states are Real only (checked when the
/// component is compiled).
pub trait Ports: Variables + Copy + Default + Send {}

impl<T: Variables + Copy + Default + Send> Ports for T {}

/// The continuous states of a component without any.
pub type NoStates = ();

/// An FMI component: implement this and name the type in [`export!`](crate::export).
///
/// The value itself contains what [`new`](Component::new) derived from the parameters (an inverted
/// mass matrix, a parsed course); everything that changes during a simulation is in `States` and
/// `Memory`, so that the kernel can save, restore and probe it.
///
/// All functions must be deterministic: the same arguments give the same bits. They must neither
/// allocate nor lock in `derivatives`, `outputs` and `event`.
pub trait Component: Sized + Send + 'static {
    /// Name, description, default experiment.
    const INFO: Info;
    /// Names of the event indicators, at most 64; none if the component has no state events.
    const INDICATORS: &'static [&'static str] = &[];
    /// Whether the indicators depend on the inputs alone and only mark kinks of the right-hand
    /// side, so that a crossing only requires restarting the integration. Co-simulation then
    /// evaluates them only in steps in which inputs change.
    const KINKS_OF_INPUTS: bool = false;
    /// Whether inputs may be anything, including infinities and NaN: for components that check
    /// their inputs. Otherwise the kernel rejects such values.
    const ANY_INPUT: bool = false;
    /// The maximum that a `Memory` may allocate besides its contents, in bytes: capacity kept for
    /// later. Memory is requested before states are copied, so that a host without it gets an
    /// error.
    const ROOM: usize = 32 << 10;
    /// Whether [`tangent`](Component::tangent) is implemented.
    const TANGENT: bool = false;
    /// Parameters: of any variable type, fixed once initialization is over. Those with
    /// `#[var(tunable)]` may also change later: [`new`](Component::new) then derives the constants
    /// again, and states and memory are kept.
    type Parameters: Variables + Default;
    /// Inputs. Their `Default` is the start value. Types other than Real are discrete.
    type Inputs: Ports;
    /// Outputs. Their `Default` is the value before anything could be computed.
    type Outputs: Ports;
    /// Continuous states (Real only), [`NoStates`] if there are none.
    type States: Ports;
    /// Discrete state: next sample instant, filter state, random number generator.
    type Memory: Clone + Default + Send + Serialize + DeserializeOwned + 'static;

    /// The values of the parameters that the user did not set, given those that were set.
    ///
    /// Override it to offer named parameter sets: `selected.parameter_set` names one, and the
    /// result is that set. Values that the user set explicitly take precedence, in whatever order
    /// they were set.
    fn preset(selected: &Self::Parameters) -> Self::Parameters {
        let _ = selected;
        Self::Parameters::default()
    }

    /// Checks the parameters and derives constants from them.
    ///
    /// # Errors
    /// Names the offending variable, what is wrong with it and what would be right. The kernel has
    /// already checked declared `min` and `max`.
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

    /// Time derivatives of the states (in a separate `States`, unit per second). Components with
    /// continuous states override this; the default is for [`NoStates`].
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
    /// If the outputs of that point are known, as at the beginning of most steps, they are passed
    /// as well. Only their time may differ by rounding.
    ///
    /// Override it if part of the work depends on the inputs alone and need not be repeated for
    /// each stage, or is already contained in the outputs; it must give the same bits.
    fn held_derivatives(
        &self,
        memory: &Self::Memory,
        inputs: &Self::Inputs,
    ) -> impl Fn(f64, &Self::States, Option<&Self::Outputs>) -> Self::States {
        move |t, states, _| self.derivatives(t, memory, states, inputs)
    }

    /// A step of the fixed-step method while memory and inputs are held: it advances the states by
    /// `h` seconds from `t`. The outputs there are passed if they are known.
    ///
    /// Override the classical Runge-Kutta method if part of the states has a closed form, such as
    /// the lag of a held command, which then need not limit the step.
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

    /// The next instant at which [`event`](Component::event) must run, if there is one.
    fn next_event(&self, memory: &Self::Memory) -> Option<Time> {
        let _ = memory;
        None
    }

    /// Handles the time event of the instant `now`; must move `next_event` past `now`.
    ///
    /// # Errors
    /// A [`Fault`] says why the simulation cannot continue; the kernel reports it and stops.
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
    /// they are well off zero after the event (the condition for leaving a limit differs from the
    /// condition for reaching it); this keeps a component from chattering.
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

    /// Updates mode and states where an indicator may have changed its sign; returns whether it
    /// changed anything. It is called again until it changes nothing.
    ///
    /// Solvers stop slightly before or after the crossing and also call it for other reasons, so
    /// check the values and do nothing if there is nothing to do.
    ///
    /// # Errors
    /// A [`Fault`] says why the simulation cannot continue.
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
    /// The kernel asks after initialization and after events; while there is nothing new to report
    /// this must not allocate.
    fn notice(memory: &mut Self::Memory) -> Option<String> {
        let _ = memory;
        None
    }

    /// The tangent-linear model: how derivatives and outputs change, to first order, when the
    /// states change by `dx` and the inputs by `du`. Set [`TANGENT`](Component::TANGENT) if you
    /// implement it, and let derivatives and outputs depend on time only through states and inputs:
    /// the time derivatives of the outputs are also computed from it.
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
    /// the changes of derivatives and outputs caused directly by the parameters, at these states
    /// and inputs. The kernel adds the contribution of [`tangent`](Component::tangent) for the
    /// change of states and inputs.
    ///
    /// `parameters` are the present ones; `dp` contains changes in its Reals and the same values as
    /// `parameters` elsewhere. If you implement `tangent` and have Real parameters, or an initial
    /// state that depends on the inputs, implement this too.
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
