//! The co-simulation stepper over the model-exchange view: integrates from event to event.
//!
//! Time events in (t, t + h] are handled in integer nanoseconds; if a component does not advance
//! past an instant, that is an error, not an endless loop. A state event is where the sign of an
//! indicator at the end of an integration step differs from its sign after the last event; the step
//! is halved until the crossing is known to [`RESOLUTION_S`], and the event is handled just after
//! it. A component that has [`CROWD`] state events within [`CROWD_S`] is stopped as chattering.
//! Indicators that mark kinks of the inputs are ignored while inputs are held.

use fmu_ode::{is_positive, resolution, step_factor};
use serde::{Deserialize, Serialize};

use crate::author::{Component, Fault, Ports, Time, Variables};

use super::integrator::{Integrator, IntegratorMethod, dormand_prince, weighed};
use super::model::{Cause, Halt};
use super::signal::Signal;
use super::values::{first_not_finite, is_finite, read};

/// Slack of one part in 10^9 when counting steps: h may be an ulp longer than n steps.
const SLACK: f64 = 1e-9;
/// Width to which a crossing is located (s).
const RESOLUTION_S: f64 = 1e-13;
/// State events counted as chattering …
const CROWD: usize = 1000;
/// … if they lie within this time (s).
const CROWD_S: f64 = 1e-6;
/// Maximum calls of `state_event` at one instant before it must have settled.
const ITERATIONS: usize = 100;
/// Maximum work of one call by the importer: integration steps and events, so that every call
/// returns in bounded time, whatever its times and the component's parameters are.
pub(crate) const MOST_WORK: u32 = 1_000_000;
/// The cost of locating a state event, in integration steps.
const CROSSING_WORK: u32 = 64;

/// Everything about a running component that is neither a constant nor a value of its table.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct Progress<M> {
    pub(crate) memory: M,
    /// Next step of the adaptive integrator; 0: none yet.
    pub(crate) proposed_s: f64,
    /// Which indicators were positive after the last event, one bit each.
    pub(crate) signs: u64,
}

impl<M: Clone> Clone for Progress<M> {
    fn clone(&self) -> Self {
        Self { memory: self.memory.clone(), ..*self }
    }

    /// Directly into its place: the derived implementation makes a copy and moves that.
    #[inline]
    fn clone_from(&mut self, from: &Self) {
        self.memory.clone_from(&from.memory);
        (self.proposed_s, self.signs) = (from.proposed_s, from.signs);
    }
}

/// How to integrate.
pub(crate) struct Scheme<X> {
    pub(crate) integrator: Integrator,
    /// Nominal values of the states.
    pub(crate) nominal: X,
}

/// What is being stepped.
pub(crate) struct Stepper<'a, C: Component, S> {
    pub(crate) component: &'a C,
    pub(crate) scheme: &'a Scheme<C::States>,
    pub(crate) progress: &'a mut Progress<C::Memory>,
    pub(crate) signal: &'a S,
    /// The outputs at the beginning, if they are known: only until something happens.
    pub(crate) known: Option<&'a [f64]>,
    /// Remaining work.
    pub(crate) work: u32,
}

impl<C: Component, S: Signal<C>> Stepper<'_, C, S> {
    /// Advances the states from `t` by `h` seconds; returns how many events were handled.
    #[inline]
    pub(crate) fn advance(&mut self, x: &mut C::States, t: f64, h: f64) -> Result<usize, Halt> {
        let (mut t, mut rest, mut events) = (t, h, 0);
        if watches::<C, S>() {
            let signs = self.signs(x, t);
            if C::KINKS_OF_INPUTS {
                self.progress.signs = signs;
            } else if signs != self.progress.signs {
                self.settle(x, t)?;
                events += 1;
            }
        }
        while let Some(instant) = self.next_until(t + rest) {
            let until = instant.seconds().min(t + rest).max(t);
            events += self.integrate(x, t, until - t)?;
            rest = (t + rest - until).max(0.0);
            t = until;
            self.spend(1, t)?;
            self.event(instant, x)?;
            events += 1;
        }
        events += self.integrate(x, t, rest)?;
        Ok(events)
    }

    /// Counts work that begins at `t`.
    #[inline]
    pub(crate) fn spend(&mut self, work: u32, t: f64) -> Result<(), Halt> {
        match self.work.checked_sub(work) {
            Some(rest) => {
                self.work = rest;
                Ok(())
            }
            None => Err(Halt::too_much(t)),
        }
    }

    #[inline]
    fn next_until(&self, end_s: f64) -> Option<Time> {
        let next = self.next_event()?;
        (next <= Time::from_seconds(end_s)).then_some(next)
    }

    /// The next time event.
    pub(crate) fn next_event(&self) -> Option<Time> {
        self.component.next_event(&self.progress.memory)
    }

    /// Handles the time event of one instant, and the state event it may lead to.
    fn event(&mut self, instant: Time, x: &mut C::States) -> Result<(), Halt> {
        let t = instant.seconds();
        self.known = None;
        self.time_event(instant, x).map_err(|fault| Halt::new(t, fault))?;
        if watches::<C, S>() { self.settle(x, t) } else { Ok(()) }
    }

    /// Handles the time event of one instant.
    pub(crate) fn time_event(&mut self, instant: Time, x: &mut C::States) -> Result<(), Fault> {
        let memory = &mut self.progress.memory;
        self.signal.with(instant.seconds(), |u| self.component.event(instant, memory, x, u))?;
        match self.component.next_event(memory) {
            Some(next) if next <= instant => Err(Fault::new(format_args!(
                "after the event at {instant} the next one is announced for {next}, which is not \
                 later; event() must move next_event() on"
            ))),
            _ => Ok(()),
        }
    }

    /// Lets the component check for a state event once; returns whether it changed anything.
    pub(crate) fn state_event(&mut self, t: f64, x: &mut C::States) -> Result<bool, Fault> {
        if !has_indicators::<C>() {
            return Ok(false);
        }
        let memory = &mut self.progress.memory;
        self.signal.with(t, |u| self.component.state_event(t, memory, x, u))
    }

    /// Integrates over `h` seconds without time events; returns how many state events there were.
    #[inline]
    fn integrate(&mut self, x: &mut C::States, t: f64, h: f64) -> Result<usize, Halt> {
        if h <= 0.0 || (C::States::COUNT.reals == 0 && !watches::<C, S>()) {
            return Ok(0);
        }
        match self.smooth(x, t, h)? {
            Some(crossing) if watches::<C, S>() => self.cross(x, t, h, crossing),
            _ => Ok(0),
        }
    }

    /// Handles the state event at `crossing` and those that follow; returns how many there were.
    #[cold]
    #[inline(never)]
    fn cross(
        &mut self,
        x: &mut C::States,
        t: f64,
        h: f64,
        mut crossing: f64,
    ) -> Result<usize, Halt> {
        let (mut events, mut crowd_start) = (0, t);
        loop {
            self.spend(CROSSING_WORK, crossing)?;
            self.settle(x, crossing)?;
            events += 1;
            if events % CROWD == 0 {
                if crossing - crowd_start < CROWD_S {
                    return Err(Halt::new(crossing, self.chatters(x, crossing)));
                }
                crowd_start = crossing;
            }
            let rest = t + h - crossing;
            match if rest > 0.0 { self.smooth(x, crossing, rest)? } else { None } {
                Some(next) => crossing = next,
                None => return Ok(events),
            }
        }
    }

    /// Integrates up to the next crossing, whose time it returns, or to the end.
    #[inline]
    fn smooth(&mut self, x: &mut C::States, t: f64, h: f64) -> Result<Option<f64>, Halt> {
        match self.scheme.integrator.method {
            IntegratorMethod::RungeKutta4 => self.fixed(x, t, h),
            IntegratorMethod::DormandPrince45 => self.adaptive(x, t, h),
        }
    }

    #[inline]
    fn fixed(&mut self, x: &mut C::States, t: f64, h: f64) -> Result<Option<f64>, Halt> {
        // The common case of a single step needs no division.
        let longest = self.scheme.integrator.step;
        let longest = if S::MOVES { longest.min(C::INFO.moving_step_s) } else { longest };
        let single = h <= longest * (1.0 + SLACK);
        let steps = if single { 1.0 } else { (h / longest - SLACK).ceil() };
        let step = if single { h } else { h / steps };
        if !single {
            self.spend(steps as u32, t)?;
        }
        // The result of a single step is checked once it is stored with the outputs.
        let look = !single || watches::<C, S>() || self.next_event().is_some();
        let mut known = self.known.take();
        let advance = self.signal.step(self.component, &self.progress.memory);
        for k in 0..steps as u64 {
            let at = t + k as f64 * step;
            let outputs = known.take().map(outputs::<C>);
            if !look {
                advance(x, at, step, outputs.as_ref());
                continue;
            }
            let before = *x;
            advance(x, at, step, outputs.as_ref());
            if !is_finite(x) {
                let halt = Halt::not_finite(at, x);
                *x = before;
                return Err(halt);
            }
            if watches::<C, S>() && self.crossed(x, at + step) {
                let again = |step| elsewhere::<C>(&advance, &before, at, step);
                let (there, length) = self.locate(*x, at, step, again);
                *x = there;
                return Ok(Some(at + length));
            }
        }
        Ok(None)
    }

    #[inline(never)]
    fn adaptive(&mut self, x: &mut C::States, t: f64, h: f64) -> Result<Option<f64>, Halt> {
        let Integrator { step: first, tolerance, .. } = self.scheme.integrator;
        let mut proposed = self.progress.proposed_s;
        if proposed.is_nan() || proposed <= 0.0 {
            proposed = first;
        }
        let known = self.known.take();
        let derivatives = self.signal.derivatives(self.component, &self.progress.memory);
        let f = |t, x: &C::States| derivatives(t, x, None);
        let mut slope = derivatives(t, x, known.map(outputs::<C>).as_ref());
        let (mut elapsed, mut crossing) = (0.0, None);
        while elapsed < h && crossing.is_none() {
            let (at, rest) = (t + elapsed, h - elapsed);
            self.work = match self.work.checked_sub(1) {
                Some(rest) => rest,
                None => return Err(Halt::too_much(at)),
            };
            let last = proposed >= rest;
            let step = if last { rest } else { proposed };
            let trial = dormand_prince(&f, x, &slope, at, step);
            let error = weighed(x, &trial, &self.scheme.nominal, tolerance);
            // Not "greater", because the error may be NaN.
            if !(error <= 1.0 && is_finite(&trial.x)) {
                if step <= 16.0 * f64::EPSILON * at.abs().max(1e-3) {
                    return Err(Halt {
                        reached_s: at,
                        cause: Cause::Accuracy { error, tolerance },
                    });
                }
                proposed = step * step_factor(error, 0.2).min(0.9);
                continue;
            }
            let wanted = step * step_factor(error, 0.2);
            // A last step is short because of the interval, not because of the error.
            proposed = if last { wanted.max(proposed) } else { wanted };
            if watches::<C, S>() && self.crossed(&trial.x, at + step) {
                let again = |step| dormand_prince(&f, x, &slope, at, step).x;
                let (there, length) = self.locate(trial.x, at, step, again);
                (*x, crossing) = (there, Some(at + length));
            } else {
                (*x, slope) = (trial.x, trial.slope);
                elapsed = if last { h } else { elapsed + step };
            }
        }
        drop(derivatives);
        self.progress.proposed_s = proposed;
        Ok(crossing)
    }

    /// Halves a step that ends after a crossing at `there`; returns the states just after the
    /// crossing and the length of the step to there.
    #[cold]
    fn locate(
        &self,
        mut there: C::States,
        t: f64,
        step: f64,
        trial: impl Fn(f64) -> C::States,
    ) -> (C::States, f64) {
        let resolution = resolution(RESOLUTION_S, t);
        let (mut before, mut behind) = (0.0, step);
        while behind - before > resolution {
            let middle = 0.5 * (before + behind);
            // Kinks of inputs are located without integrating.
            let x = if C::KINKS_OF_INPUTS { there } else { trial(middle) };
            if self.crossed(&x, t + middle) {
                (behind, there) = (middle, x);
            } else {
                before = middle;
            }
        }
        if C::KINKS_OF_INPUTS {
            there = trial(behind);
        }
        (there, behind)
    }

    fn crossed(&self, x: &C::States, t: f64) -> bool {
        self.signs(x, t) != self.progress.signs
    }

    /// Which indicators are positive.
    pub(crate) fn signs(&self, x: &C::States, t: f64) -> u64 {
        let mut indicators = [0.0; 64];
        let own = indicators.get_mut(..C::INDICATORS.len()).unwrap_or_default();
        let memory = &self.progress.memory;
        self.signal.with(t, |u| self.component.indicators(t, memory, x, u, own));
        own.iter().rev().fold(0, |bits, z| bits << 1 | u64::from(is_positive(*z)))
    }

    /// Handles a state event: iterates until the component changes nothing any more.
    #[cold]
    fn settle(&mut self, x: &mut C::States, t: f64) -> Result<(), Halt> {
        self.known = None;
        for _ in 0..ITERATIONS {
            if !self.state_event(t, x).map_err(|fault| Halt::new(t, fault))? {
                self.progress.signs = self.signs(x, t);
                return Ok(());
            }
        }
        let reason = format!("state_event() still changed something after {ITERATIONS} calls");
        Err(Halt::new(t, Fault::new(reason)))
    }

    #[cold]
    fn chatters(&self, x: &C::States, t: f64) -> Fault {
        let mut indicators = [f64::INFINITY; 64];
        let own = indicators.get_mut(..C::INDICATORS.len()).unwrap_or_default();
        let memory = &self.progress.memory;
        self.signal.with(t, |u| self.component.indicators(t, memory, x, u, own));
        let nearest =
            C::INDICATORS.iter().zip(&*own).min_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        Fault::new(format_args!(
            "the component chatters: {CROWD} state events within {CROWD_S:e} s, the last of \
             \"{}\"; give it a hysteresis or a mode of its own",
            nearest.map_or("?", |(name, _)| name)
        ))
    }
}

/// A step from a state that is kept, in separate storage: for the search for an event.
#[cold]
#[inline(never)]
fn elsewhere<C: Component>(
    advance: &impl Fn(&mut C::States, f64, f64, Option<&C::Outputs>),
    x: &C::States,
    t: f64,
    h: f64,
) -> C::States {
    let mut there = *x;
    advance(&mut there, t, h, None);
    there
}

#[inline(always)]
fn outputs<C: Component>(reals: &[f64]) -> C::Outputs {
    read(reals, &(0..reals.len()))
}

const fn has_indicators<C: Component>() -> bool {
    !C::INDICATORS.is_empty()
}

/// Whether an indicator may change its sign within a step, or there is something to do if it has
/// changed since the last one.
const fn watches<C: Component, S: Signal<C>>() -> bool {
    has_indicators::<C>() && (S::MOVES || !C::KINKS_OF_INPUTS)
}

impl Halt {
    /// The component cannot continue.
    pub(crate) fn new(reached_s: f64, fault: Fault) -> Self {
        Self { reached_s, cause: Cause::Fault(fault) }
    }

    /// From here on it would be more than [`MOST_WORK`].
    #[cold]
    fn too_much(reached_s: f64) -> Self {
        Self { reached_s, cause: Cause::Work }
    }

    /// With a value reference instead of the index of a state.
    pub(crate) fn in_table(self, states_start: usize) -> Self {
        match self.cause {
            Cause::NotFinite(state) => {
                Self { cause: Cause::NotFinite(states_start + state), ..self }
            }
            _ => self,
        }
    }

    /// The step from `reached_s` led to these states.
    #[cold]
    fn not_finite<X: Ports>(reached_s: f64, states: &X) -> Self {
        Self { reached_s, cause: Cause::NotFinite(first_not_finite(states).unwrap_or_default()) }
    }
}
