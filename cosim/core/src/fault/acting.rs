//! A fault that acts on one variable.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::kind::{Kind, Meanwhile, Spread};
use super::{End, Random};
use cosim_base::time::Time;

/// How a value reaches its component, or leaves it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Way {
    /// A connected input.
    Input,
    /// An output.
    Output,
    /// A parameter, or an unconnected input.
    Free,
}

/// A fault with its state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Acting {
    /// The position of the fault in the list.
    number: u32,
    kind: Kind,
    /// When it begins; unknown until its condition holds.
    from: Option<Time>,
    until: Time,
    /// Its duration, if that determines its end.
    lasts: Option<Time>,
    ramp_in: Time,
    ramp_out: Time,
    /// The time between samples; 0 if each step is one.
    every: Time,
    /// When the next sample is due, and the time of the last one.
    next: Time,
    taken: Option<Time>,
    /// A later fault has ended it.
    released: bool,
    random: Random,
    way: Way,
    /// The instant of the current values.
    now: Time,
    /// The start of the step that decides whether the fault acts; `None` before the first step.
    begun: Option<Time>,
    /// It has acted in a step.
    acted: bool,
    /// The current noise or error.
    level: f64,
    lost: bool,
    /// The last good value, and its time.
    good: Option<(Time, f64)>,
    /// Values in transit: their time, their time of arrival, and the values.
    late: VecDeque<(Time, Time, f64)>,
    /// The delay of the current value (s).
    delay: f64,
}

impl Acting {
    pub(super) fn new(
        number: u32,
        kind: Kind,
        from: Option<Time>,
        end: End,
        random: Random,
    ) -> Self {
        let lasts = if let End::After(lasts) = end { Some(lasts) } else { None };
        let until = match (end, from, lasts) {
            (End::At(until), ..) => until,
            (_, Some(from), Some(lasts)) => from + lasts,
            _ => Time::NEVER,
        };
        Self {
            number,
            kind,
            from,
            until,
            lasts,
            ramp_in: Time::ZERO,
            ramp_out: Time::ZERO,
            every: Time::ZERO,
            next: Time::ZERO,
            taken: None,
            released: false,
            random,
            way: Way::Output,
            now: Time::ZERO,
            begun: None,
            acted: false,
            level: 0.0,
            lost: false,
            good: None,
            late: VecDeque::new(),
            delay: 0.0,
        }
    }

    pub(super) fn ramped(mut self, ramp_in: Time, ramp_out: Time) -> Self {
        (self.ramp_in, self.ramp_out) = (ramp_in, ramp_out);
        self
    }

    pub(super) fn sampled(mut self, every: Time) -> Self {
        self.every = every;
        self
    }

    /// From now on it acts on a variable of this kind.
    pub(crate) fn installed(mut self, way: Way, now: Time) -> Self {
        (self.way, self.now) = (way, now);
        self.begun = (way != Way::Output).then_some(now);
        self.draw(Time::ZERO);
        self
    }

    /// The condition of fault `number` holds; only the first time counts. Returns whether the
    /// component is to be reset now.
    pub(crate) fn trigger(&mut self, number: u32, now: Time) -> bool {
        if self.number != number || self.from.is_some() {
            return false;
        }
        self.from = Some(now);
        self.until = self.lasts.map_or(self.until, |lasts| now + lasts);
        if self.way != Way::Output && self.begun == Some(now) {
            self.draw(Time::ZERO);
        }
        self.kind == Kind::Reset
    }

    /// Whether it needs values from before its start.
    pub(crate) fn remembers(&self) -> bool {
        self.kind.remembers()
    }

    /// A step from `begin` to `end` was made.
    pub(crate) fn advance(&mut self, begin: Time, end: Time) {
        self.now = end;
        self.begun = Some(if self.way == Way::Output { begin } else { end });
        self.draw(end - begin);
    }

    fn acts(&self) -> bool {
        match (self.begun, self.from) {
            (Some(begun), Some(from)) => !self.released && from <= begun && begun < self.until,
            _ => false,
        }
    }

    /// Whether it ends the faults before it.
    pub(crate) fn releases(&self) -> bool {
        self.kind == Kind::Release && self.acts()
    }

    /// Whether a later fault has ended it.
    pub(crate) fn release(&mut self, released: bool) {
        self.released = released;
    }

    /// Whether a sample is due; returns the time of the previous one.
    fn sample(&mut self) -> Option<Option<Time>> {
        if self.acted && self.every > Time::ZERO {
            if self.now < self.next {
                return None;
            }
        } else {
            self.next = self.from.unwrap_or(self.now);
        }
        // Samples stay on their grid, however long the steps are.
        while self.every > Time::ZERO && self.next <= self.now {
            self.next = self.next + self.every;
        }
        let before = if self.acted { self.taken } else { None };
        self.taken = Some(self.now);
        Some(before)
    }

    /// The random numbers of a step of this length.
    fn draw(&mut self, step: Time) {
        if let Kind::Latency { delay, jitter } = self.kind {
            // Also drawn before the start, for values that arrive after it.
            self.delay = delay;
            if jitter > 0.0 {
                self.delay += jitter * self.random.uniform();
            }
        }
        if let (&Kind::Lag(tau), Some((_, value))) = (&self.kind, self.good) {
            let kept = libm::exp(-step.seconds() / tau);
            self.level = kept * self.level + (1.0 - kept) * value;
        }
        if !self.acts() {
            (self.acted, self.lost) = (false, false);
            return;
        }
        let Some(before) = self.sample() else { return };
        match self.kind {
            Kind::WhiteNoise(sigma) => self.level = sigma * self.random.normal(),
            Kind::GaussMarkov { sigma, tau } => {
                let normal = sigma * self.random.normal();
                self.level = if let Some(before) = before {
                    let kept = libm::exp(-(self.now - before).seconds() / tau);
                    kept * self.level + libm::sqrt(1.0 - kept * kept) * normal
                } else {
                    normal
                };
            }
            Kind::Outliers { share, size } => {
                // The same number of draws each time, so that later numbers do not depend on the
                // outcome.
                let (chance, drawn) = (self.random.uniform(), self.random.uniform());
                let error = match size {
                    Spread::Normal(sigma) => sigma * super::normal_quantile(drawn),
                    Spread::Uniform(most) => most * (2.0 * drawn - 1.0),
                };
                self.level = if chance < share { error } else { 0.0 };
            }
            Kind::DropOut { turns: None, .. } => self.lost = true,
            Kind::DropOut { turns: Some((up, down)), .. } => {
                let mean = if self.lost { down } else { up };
                let turns = self.random.uniform() >= libm::exp(-step.seconds() / mean);
                self.lost ^= turns;
            }
            Kind::Reordering { share, .. } => self.lost = self.random.uniform() < share,
            _ => {}
        }
        self.acted = true;
    }

    /// The faulty value for the current value. Called again, it gives the same result for the same
    /// value.
    pub(crate) fn apply(&mut self, value: f64) -> f64 {
        self.remember(value);
        if !self.acts() {
            return value;
        }
        let weight = self.weight();
        let faulty = self.faulty(value);
        if weight >= 1.0 {
            faulty
        } else if weight <= 0.0 {
            value
        } else {
            value + weight * (faulty - value)
        }
    }

    /// How fully it acts.
    fn weight(&self) -> f64 {
        let part = |time: Time, of: Time| {
            if of > Time::ZERO { time.seconds() / of.seconds() } else { 1.0 }
        };
        let rising = part(self.since(), self.ramp_in);
        let falling = if self.until == Time::NEVER {
            1.0
        } else {
            part(self.until - self.now, self.ramp_out)
        };
        rising.min(falling)
    }

    fn since(&self) -> Time {
        self.from.map_or(Time::ZERO, |from| self.now - from)
    }

    fn faulty(&self, value: f64) -> f64 {
        let since = || self.since().seconds();
        match self.kind {
            Kind::Override(instead) => instead,
            Kind::Bias(bias) => value + bias,
            Kind::Scale(factor) => value * factor,
            Kind::Drift(rate) => value + rate * since(),
            Kind::Ramp { size, over } => value + size * (since() / over).min(1.0),
            Kind::WhiteNoise(_) | Kind::GaussMarkov { .. } | Kind::Outliers { .. } => {
                value + self.level
            }
            Kind::Stuck | Kind::Sampling => self.good.map_or(value, |(_, good)| good),
            Kind::Lag(_) => self.level,
            Kind::Release | Kind::Reset => value,
            Kind::NotANumber => f64::NAN,
            Kind::Quantization(step) => libm::rint(value / step) * step,
            Kind::Saturation(low, high) => {
                if value < low {
                    low
                } else if value > high {
                    high
                } else {
                    value
                }
            }
            Kind::DropOut { .. } if !self.lost => value,
            Kind::DropOut { meanwhile, .. } => match meanwhile {
                Meanwhile::Last => self.good.map_or(value, |(_, good)| good),
                Meanwhile::Zero => 0.0,
                Meanwhile::NotANumber => f64::NAN,
            },
            Kind::Latency { .. } => {
                let come = self.late.iter().rev().find(|(_, due, _)| *due <= self.now);
                // Before anything has arrived, the initial value.
                come.or(self.late.front()).map_or(value, |(_, _, late)| *late)
            }
            Kind::Reordering { .. } => {
                let come = self.late.iter().filter(|(_, due, _)| *due <= self.now);
                // If two arrive at once, the older one is seen: it is the late one.
                let last = come.max_by_key(|(of, due, _)| (*due, std::cmp::Reverse(*of)));
                last.map_or(value, |(_, _, late)| *late)
            }
        }
    }

    fn remember(&mut self, value: f64) {
        match self.kind {
            Kind::Stuck | Kind::DropOut { .. } => {
                let holds = match self.kind {
                    Kind::Stuck => self.acts(),
                    _ => self.lost,
                };
                // The very first value is kept, and so is its replacement at the same instant.
                if !holds || self.good.is_none_or(|(of, _)| of == self.now) {
                    self.good = Some((self.now, value));
                }
            }
            Kind::Latency { .. } => self.send(value),
            Kind::Lag(_) => {
                if !self.acts() {
                    self.level = value;
                }
                self.good = Some((self.now, value));
            }
            Kind::Sampling if !self.acts() || self.taken == Some(self.now) => {
                self.good = Some((self.now, value));
            }
            Kind::Reordering { .. } if !self.acts() => self.late.clear(),
            Kind::Reordering { delay, again, .. } if self.taken == Some(self.now) => {
                self.late.retain(|(of, ..)| *of != self.now);
                let late = Time::from_ns(libm::rint(delay * 1e9) as i64);
                if !self.lost || again {
                    self.late.push_back((self.now, self.now, value));
                }
                if self.lost {
                    self.late.push_back((self.now, self.now + late, value));
                }
                self.forget();
            }
            _ => {}
        }
    }

    /// Drops everything that has arrived except the last value.
    fn forget(&mut self) {
        let now = self.now;
        let come = self.late.iter().filter(|(_, due, _)| *due <= now).map(|(_, due, _)| *due);
        if let Some(last) = come.max() {
            self.late.retain(|(of, due, _)| *due >= last || *of == now);
        }
    }

    /// Sends a value.
    fn send(&mut self, value: f64) {
        if let Some((of, _, newest)) = self.late.back_mut()
            && *of == self.now
        {
            *newest = value;
            return;
        }
        let delay = Time::from_ns(libm::rint(self.delay * 1e9) as i64);
        let last = self.late.back().map_or(self.now, |(_, due, _)| *due);
        self.late.push_back((self.now, (self.now + delay).max(last), value));
        // The newest value that has arrived stays; earlier ones are no longer needed.
        while self.late.get(1).is_some_and(|(_, due, _)| *due <= self.now) {
            self.late.pop_front();
        }
    }

    /// The derivative of the output with respect to the input.
    pub(crate) fn slope(&self) -> f64 {
        if !self.acts() {
            return 1.0;
        }
        match self.kind {
            Kind::Scale(factor) => factor,
            Kind::Override(_)
            | Kind::Stuck
            | Kind::NotANumber
            | Kind::Quantization(_)
            | Kind::Lag(_)
            | Kind::Sampling
            | Kind::Reordering { .. }
            | Kind::Latency { .. } => 0.0,
            Kind::DropOut { .. } if self.lost => 0.0,
            _ => 1.0,
        }
    }
}

#[cfg(test)]
mod tests;
