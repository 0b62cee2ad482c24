//! Integrates an FMU for model exchange from one communication point to the next.
//!
//! Steps end exactly at time events. After each step, the event indicators are compared with those
//! before it, also in its middle (on the cubic Hermite interpolant), so that a short excursion into
//! the other domain is detected; a crossing is located by integrating again from the start of the
//! step, which preserves the accuracy of the method. Every event is handled once: the indicators
//! are read again after it.

use fmu_ode::{Bracket, RungeKutta, any_changed, resolution, step_factor};

use super::Settings;
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::Time;
use cosim_import::{Instance, NextEvent};
use serde::{Deserialize, Serialize};

/// Two instants closer than this are the same: half of the master's resolution.
const SAME: f64 = 0.5e-9;
/// Width to which a state event is located, in seconds, if the time has enough digits.
const LOCATED: f64 = 1e-10;

/// The state of the integration, besides that of the FMU.
#[derive(Clone)]
pub(crate) struct Continuous {
    settings: Settings,
    rk: RungeKutta,
    time: f64,
    x: Vec<f64>,
    end: Vec<f64>,
    nominal: Vec<f64>,
    /// Indicators at `time`, and a buffer for trial values.
    z: Vec<f64>,
    z_trial: Vec<f64>,
    next_event: Option<f64>,
    /// The step that the error control suggests; 0: not known yet.
    h: f64,
    completed_step: bool,
    ramp: Ramp,
}

/// Inputs that move during a step: references, values at `begin`, slopes.
#[derive(Clone, Default)]
struct Ramp {
    begin: f64,
    references: Vec<u32>,
    values: Vec<f64>,
    slopes: Vec<f64>,
    now: Vec<f64>,
}

/// The part of an integration that continues after a communication point.
#[derive(Serialize, Deserialize)]
pub(crate) struct Progress {
    time: f64,
    h: f64,
    next_event: Option<f64>,
    x: Vec<f64>,
    end: Vec<f64>,
    nominal: Vec<f64>,
    z: Vec<f64>,
}

impl Continuous {
    /// For an FMU that is in event mode after its initialization at `start`.
    pub(crate) fn new(settings: Settings, instance: &Instance, completed_step: bool) -> Self {
        let description = instance.fmu().description();
        let (states, indicators) = (description.states, description.event_indicators);
        Self {
            settings,
            rk: RungeKutta::new(settings.method.tableau(), states),
            time: 0.0,
            x: vec![0.0; states],
            end: vec![0.0; states],
            nominal: vec![1.0; states],
            z: vec![0.0; indicators],
            z_trial: vec![0.0; indicators],
            next_event: None,
            h: 0.0,
            completed_step,
            ramp: Ramp::default(),
        }
    }

    /// Everything needed to continue from here.
    pub(crate) fn progress(&self) -> Progress {
        Progress {
            time: self.time,
            h: self.h,
            next_event: self.next_event,
            x: self.x.clone(),
            end: self.end.clone(),
            nominal: self.nominal.clone(),
            z: self.z.clone(),
        }
    }

    /// Continues from there; `false` if that is the progress of another FMU.
    pub(crate) fn resume(&mut self, progress: Progress) -> bool {
        let Progress { time, h, next_event, x, end, nominal, z } = progress;
        let states = [&x, &end, &nominal].iter().all(|of| of.len() == self.x.len());
        if !states || z.len() != self.z.len() {
            return false;
        }
        (self.time, self.h, self.next_event) = (time, h, next_event);
        (self.x, self.end, self.nominal, self.z) = (x, end, nominal, z);
        true
    }

    /// Makes Real inputs move from here on: their current values and their slopes.
    pub(crate) fn ramp(&mut self, references: &[u32], values: &[f64], slopes: &[f64]) {
        let ramp = &mut self.ramp;
        ramp.begin = self.time;
        for (own, new) in [(&mut ramp.values, values), (&mut ramp.slopes, slopes)] {
            own.clear();
            own.extend_from_slice(new);
        }
        ramp.references.clear();
        ramp.references.extend_from_slice(references);
        ramp.now.resize(references.len(), 0.0);
    }

    /// The events at the start; the FMU has left initialization mode.
    pub(crate) fn begin(&mut self, instance: &mut Instance, start: Time) -> Result<()> {
        self.time = start.seconds();
        let event = instance.finish_event()?;
        let all = NextEvent { states_changed: true, nominals_changed: true, ..event };
        self.take_over(instance, all)
    }

    /// Handles an event at the current time. `change` is its cause: it sets inputs.
    pub(crate) fn event(
        &mut self,
        instance: &mut Instance,
        change: impl FnOnce(&mut Instance) -> Result<()>,
    ) -> Result<()> {
        instance.enter_event_mode()?;
        change(instance)?;
        let event = instance.finish_event()?;
        self.take_over(instance, event)
    }

    fn take_over(&mut self, instance: &mut Instance, event: NextEvent) -> Result<()> {
        self.next_event = event.time;
        if !self.x.is_empty() && event.states_changed {
            instance.get_states(&mut self.x)?;
        }
        if !self.x.is_empty() && event.nominals_changed {
            instance.get_nominals(&mut self.nominal)?;
            let magnitude = |nominal: &f64| nominal.is_finite() && *nominal != 0.0;
            self.nominal.iter_mut().filter(|n| !magnitude(n)).for_each(|n| *n = 1.0);
        }
        if !self.z.is_empty() {
            instance.get_indicators(&mut self.z)?;
        }
        Ok(())
    }

    /// Integrates to `end`, in seconds; events up to and at `end` are handled.
    pub(crate) fn advance(&mut self, instance: &mut Instance, end: f64) -> Result<()> {
        self.inputs_moved(instance)?;
        let mut at_once = 0;
        loop {
            let event = self.next_event.filter(|event| *event <= end + SAME);
            let limit = event.unwrap_or(end);
            let last = self.time;
            if limit - self.time > SAME {
                self.step(instance, limit)?;
            } else if event.is_some() {
                self.time = limit.max(self.time);
                instance.set_time(self.time)?;
                self.ramp.at(instance, self.time)?;
                self.event(instance, |_| Ok(()))?;
            } else {
                return Ok(());
            }
            at_once = if self.time - last > SAME { 0 } else { at_once + 1 };
            if at_once > 1000 {
                return Err(self.stuck(instance, "more than 1000 events follow at one instant"));
            }
        }
    }

    /// Inputs that were set may have moved an indicator into its other domain.
    fn inputs_moved(&mut self, instance: &mut Instance) -> Result<()> {
        if self.z.is_empty() {
            return Ok(());
        }
        instance.get_indicators(&mut self.z_trial)?;
        match any_changed(&self.z, &self.z_trial) {
            true => self.event(instance, |_| Ok(())),
            false => Ok(()),
        }
    }

    /// Makes one step towards `limit`, and handles the event at its end if there is one.
    fn step(&mut self, instance: &mut Instance, limit: f64) -> Result<()> {
        let has_states = !self.x.is_empty();
        let ramp = &mut self.ramp;
        let f = &mut |t: f64, x: &[f64], dx: &mut [f64]| {
            derivatives(instance, ramp, has_states, t, x, dx)
        };
        self.rk.begin(self.time, &self.x, f)?;
        let mut h = self.controlled(instance, limit)?;
        let crossing = self.crossing(instance, h)?;
        if let Some(after) = crossing {
            h = after;
            self.attempt(instance, h)?;
        }
        let to_limit = h == limit - self.time;
        self.time = if to_limit { limit } else { self.time + h };
        std::mem::swap(&mut self.x, &mut self.end);
        place(instance, &mut self.ramp, self.time, &self.x)?;
        let asked = self.completed_step && instance.completed_step()?;
        // A time event at the limit is handled by the loop that chose the limit.
        if crossing.is_some() || asked {
            return self.event(instance, |_| Ok(()));
        }
        if !self.z.is_empty() {
            instance.get_indicators(&mut self.z)?;
        }
        Ok(())
    }

    fn attempt(&mut self, instance: &mut Instance, h: f64) -> Result<()> {
        let has_states = !self.x.is_empty();
        let ramp = &mut self.ramp;
        let f = &mut |t: f64, x: &[f64], dx: &mut [f64]| {
            derivatives(instance, ramp, has_states, t, x, dx)
        };
        self.rk.attempt(h, &mut self.end, f)
    }

    /// Makes a step that the error control accepts; returns its length; the states at its end are
    /// in `end`.
    fn controlled(&mut self, instance: &mut Instance, limit: f64) -> Result<f64> {
        let whole = limit - self.time;
        if !self.rk.adaptive() || self.x.is_empty() {
            self.attempt(instance, whole)?;
            return Ok(whole);
        }
        if self.h == 0.0 {
            self.h = self.first_step(whole);
        }
        // A remainder too short for a step of its own is included.
        let mut h = if self.h * 1.1 >= whole { whole } else { self.h };
        loop {
            self.attempt(instance, h)?;
            let error = self.rk.error(h, |i| self.scale(i));
            if error <= 1.0 {
                let suggested = h * step_factor(error, 0.2);
                // A step shortened by its limit is no evidence against longer ones.
                self.h = if h < self.h { suggested.max(self.h) } else { suggested };
                return Ok(h);
            }
            // NaN also gets here: the states left the domain of the model.
            h *= step_factor(error, 0.1).min(0.9);
            self.h = h;
            if self.time + h <= self.time + 4.0 * f64::EPSILON * self.time.abs() || h < 1e-300 {
                return Err(self.stuck(instance, "no step is small enough for the tolerance"));
            }
        }
    }

    /// A first guess (Hairer, Norsett, Wanner, II.4).
    fn first_step(&self, whole: f64) -> f64 {
        let norm = |values: &[f64]| {
            let parts = values.iter().enumerate().map(|(i, v)| v / self.scale(i));
            parts.map(|p| p * p).sum::<f64>().sqrt()
        };
        let (size, slope) = (norm(&self.x), norm(self.rk.slope()));
        let guess = if size > 1e-5 && slope > 1e-5 { 0.01 * size / slope } else { 1e-3 * whole };
        guess.min(whole)
    }

    fn scale(&self, i: usize) -> f64 {
        self.settings.tolerance * (self.x[i].abs().max(self.end[i].abs()) + self.nominal[i].abs())
    }

    /// Where in the step of length `h` the first event indicator has crossed.
    fn crossing(&mut self, instance: &mut Instance, h: f64) -> Result<Option<f64>> {
        if self.z.is_empty() {
            return Ok(None);
        }
        self.indicators(instance, h)?;
        let mut after = h;
        if !any_changed(&self.z, &self.z_trial) {
            self.middle(instance, h)?;
            after = 0.5 * h;
            if !any_changed(&self.z, &self.z_trial) {
                return Ok(None);
            }
            // The interpolant is only a hint: the step itself decides.
            self.attempt(instance, after)?;
            self.indicators(instance, after)?;
            if !any_changed(&self.z, &self.z_trial) {
                self.attempt(instance, h)?;
                return Ok(None);
            }
        }
        let mut bracket = Bracket::new(&self.z, after, &self.z_trial);
        let width = resolution(LOCATED, self.time);
        while bracket.after - bracket.before > width {
            let at = bracket.guess();
            self.attempt(instance, at)?;
            self.indicators(instance, at)?;
            bracket.narrow(at, &self.z_trial);
        }
        Ok(Some(bracket.after))
    }

    /// The indicators at the end of the attempted step, into `z_trial`.
    fn indicators(&mut self, instance: &mut Instance, h: f64) -> Result<()> {
        place(instance, &mut self.ramp, self.time + h, &self.end)?;
        instance.get_indicators(&mut self.z_trial)
    }

    /// The indicators in the middle of the step, on the cubic Hermite interpolant.
    fn middle(&mut self, instance: &mut Instance, h: f64) -> Result<()> {
        let mut slope = vec![0.0; self.x.len()];
        if !slope.is_empty() {
            instance.get_derivatives(&mut slope)?;
        }
        let between: Vec<f64> = (0..self.x.len())
            .map(|i| {
                let mean = 0.5 * (self.x[i] + self.end[i]);
                mean + 0.125 * h * (self.rk.slope()[i] - slope[i])
            })
            .collect();
        place(instance, &mut self.ramp, self.time + 0.5 * h, &between)?;
        instance.get_indicators(&mut self.z_trial)
    }

    fn stuck(&self, instance: &Instance, why: &str) -> Error {
        let what = format!("'{}' cannot be integrated beyond t = {} s", instance.name(), self.time);
        Error::new(Code::Fmu, what)
            .at(instance.fmu().path())
            .why(why)
            .log(instance.messages())
            .help("use a larger --tolerance, or --interface-type cs if the FMU has its own solver")
    }
}

impl Ramp {
    fn at(&mut self, instance: &mut Instance, time: f64) -> Result<()> {
        if self.references.is_empty() {
            return Ok(());
        }
        let since = time - self.begin;
        for (now, (value, slope)) in self.now.iter_mut().zip(self.values.iter().zip(&self.slopes)) {
            *now = value + slope * since;
        }
        instance.set_real(&self.references, &self.now)
    }
}

fn place(instance: &mut Instance, ramp: &mut Ramp, time: f64, x: &[f64]) -> Result<()> {
    instance.set_time(time)?;
    ramp.at(instance, time)?;
    if x.is_empty() { Ok(()) } else { instance.set_states(x) }
}

fn derivatives(
    instance: &mut Instance,
    ramp: &mut Ramp,
    has_states: bool,
    time: f64,
    x: &[f64],
    dx: &mut [f64],
) -> Result<()> {
    if !has_states {
        return Ok(());
    }
    place(instance, ramp, time, x)?;
    instance.get_derivatives(dx)
}
