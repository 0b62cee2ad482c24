//! The co-simulation stepper over the model-exchange view: classical Runge-Kutta of fourth order
//! with a fixed step, stopping at time events.
//!
//! An interval h between events is cut into n = ceil(h / h_max) equal steps, so the step is h/n
//! and depends on nothing but the interval. Inputs are held. Events in (t, t + h] are handled in
//! integer nanoseconds; an instant whose component does not move on is an error, not a loop.

use crate::author::{Component, Fault, Time};

/// Slack of one part in 10^9 when counting steps: h may be an ulp longer than n steps.
const SLACK: f64 = 1e-9;

/// What is being stepped: a component, its memory and its held inputs.
pub(crate) struct Stepper<'a, C: Component> {
    pub(crate) component: &'a C,
    pub(crate) memory: &'a mut C::Memory,
    pub(crate) inputs: &'a C::Inputs,
}

impl<C: Component> Stepper<'_, C> {
    /// Advances the states from `t` by `h` seconds; returns how many events were handled.
    #[inline]
    pub(crate) fn advance(&mut self, x: &mut C::States, t: f64, h: f64) -> Result<usize, Fault> {
        let end = Time::from_seconds(t + h);
        let (mut t, mut rest, mut events) = (t, h, 0);
        while let Some(instant) = self
            .component
            .next_event(self.memory)
            .filter(|at| *at <= end)
        {
            let until = instant.seconds().min(t + rest).max(t);
            self.integrate(x, t, until - t);
            rest = (t + rest - until).max(0.0);
            t = until;
            self.event(instant, x)?;
            events += 1;
        }
        self.integrate(x, t, rest);
        Ok(events)
    }

    /// Handles the event of one instant.
    pub(crate) fn event(&mut self, instant: Time, x: &mut C::States) -> Result<(), Fault> {
        self.component.event(instant, self.memory, x, self.inputs)?;
        match self.component.next_event(self.memory) {
            Some(next) if next <= instant => Err(Fault::new(format_args!(
                "after the event at {instant} the next one is announced for {next}, which is not \
                 later; event() must move next_event() on"
            ))),
            _ => Ok(()),
        }
    }

    #[inline]
    fn integrate(&self, x: &mut C::States, t: f64, h: f64) {
        if x_is_empty::<C>() || h <= 0.0 {
            return;
        }
        // The common case of a single step needs neither division.
        let single = h <= C::INFO.integrator_step_s * (1.0 + SLACK);
        let steps = if single {
            1.0
        } else {
            (h / C::INFO.integrator_step_s - SLACK).ceil()
        };
        let step = if single { h } else { h / steps };
        let f = self.component.held_derivatives(self.memory, self.inputs);
        for k in 0..steps as u64 {
            runge_kutta::<C>(&f, x, t + k as f64 * step, step);
        }
    }
}

/// One step of the classical Runge-Kutta method.
#[inline]
fn runge_kutta<C: Component>(
    f: &impl Fn(f64, &C::States) -> C::States,
    x: &mut C::States,
    t: f64,
    h: f64,
) {
    let half = 0.5 * h;
    let k1 = f(t, x);
    let k2 = f(t + half, &moved::<C>(x, &k1, half));
    let k3 = f(t + half, &moved::<C>(x, &k2, half));
    let k4 = f(t + h, &moved::<C>(x, &k3, h));
    let mut slope = k1;
    add::<C>(&mut slope, &k2, 2.0);
    add::<C>(&mut slope, &k3, 2.0);
    add::<C>(&mut slope, &k4, 1.0);
    add::<C>(x, &slope, h / 6.0);
}

const fn x_is_empty<C: Component>() -> bool {
    <C::States as crate::author::Variables>::COUNT.reals == 0
}

#[inline]
fn moved<C: Component>(x: &C::States, k: &C::States, h: f64) -> C::States {
    let mut there = *x;
    add::<C>(&mut there, k, h);
    there
}

#[inline]
fn add<C: Component>(x: &mut C::States, k: &C::States, factor: f64) {
    use crate::author::Variables;
    x.zip_reals(k, &mut |x, k| *x += factor * k);
}
