//! A fault at work on one variable.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::kind::{Kind, Meanwhile, Spread};
use super::{End, Random};
use crate::time::Time;

/// How a value reaches its component, or leaves it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Way {
    /// An input that somebody drives.
    Input,
    /// An output.
    Output,
    /// A parameter, or an input that nobody drives.
    Free,
}

/// A fault with its state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Acting {
    /// Which fault of the list this is.
    number: u32,
    kind: Kind,
    /// When it begins; unknown while its condition has not held.
    from: Option<Time>,
    until: Time,
    /// How long it lasts, if that decides when it ends.
    lasts: Option<Time>,
    ramp_in: Time,
    ramp_out: Time,
    random: Random,
    way: Way,
    /// The instant of the present values.
    now: Time,
    /// When the step began that decides whether the fault acts; none before the first one.
    begun: Option<Time>,
    /// It has acted at a step.
    acted: bool,
    /// The noise, or the error, of now.
    level: f64,
    lost: bool,
    /// The last good value, and of when it is.
    good: Option<(Time, f64)>,
    /// Values on their way: of when they are, when they come, and what they are.
    late: VecDeque<(Time, Time, f64)>,
    /// The delay of the value of now (s).
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

    /// From now on it is at a variable of this way.
    pub(crate) fn installed(mut self, way: Way, now: Time) -> Self {
        (self.way, self.now) = (way, now);
        self.begun = (way != Way::Output).then_some(now);
        self.draw(Time::ZERO);
        self
    }

    /// The condition of fault `number` holds; only the first time counts.
    pub(crate) fn trigger(&mut self, number: u32, now: Time) {
        if self.number == number && self.from.is_none() {
            self.from = Some(now);
            self.until = self.lasts.map_or(self.until, |lasts| now + lasts);
            if self.way != Way::Output && self.begun == Some(now) {
                self.draw(Time::ZERO);
            }
        }
    }

    /// Whether it looks at values before its beginning.
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
            (Some(begun), Some(from)) => from <= begun && begun < self.until,
            _ => false,
        }
    }

    /// The random numbers of a step, which is so long.
    fn draw(&mut self, step: Time) {
        if let Kind::Latency { delay, jitter } = self.kind {
            // Drawn also before the beginning, for values that come after it.
            self.delay = delay;
            if jitter > 0.0 {
                self.delay += jitter * self.random.uniform();
            }
        }
        if !self.acts() {
            (self.acted, self.lost) = (false, false);
            return;
        }
        match self.kind {
            Kind::WhiteNoise(sigma) => self.level = sigma * self.random.normal(),
            Kind::GaussMarkov { sigma, tau } => {
                let normal = sigma * self.random.normal();
                self.level = if self.acted {
                    let kept = libm::exp(-step.seconds() / tau);
                    kept * self.level + libm::sqrt(1.0 - kept * kept) * normal
                } else {
                    normal
                };
            }
            Kind::Outliers { share, size } => {
                // The same number of draws each time: what comes next does not depend on luck.
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
            _ => {}
        }
        self.acted = true;
    }

    /// What becomes of the present value. Asked again, it gives the same for the same.
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
            Kind::Stuck => self.good.map_or(value, |(_, good)| good),
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
                // Before anything has come, what there was at first.
                come.or(self.late.front()).map_or(value, |(_, _, late)| *late)
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
                // The first value of all is kept, and so is what replaces it at the same instant.
                if !holds || self.good.is_none_or(|(of, _)| of == self.now) {
                    self.good = Some((self.now, value));
                }
            }
            Kind::Latency { .. } => self.send(value),
            _ => {}
        }
    }

    /// A value sets out.
    fn send(&mut self, value: f64) {
        if let Some((of, _, newest)) = self.late.back_mut()
            && *of == self.now
        {
            *newest = value;
            return;
        }
        let delay = Time::from_nanoseconds(libm::rint(self.delay * 1e9) as i64);
        let last = self.late.back().map_or(self.now, |(_, due, _)| *due);
        self.late.push_back((self.now, (self.now + delay).max(last), value));
        // The newest that has come stays; those before it are of no use any more.
        while self.late.get(1).is_some_and(|(_, due, _)| *due <= self.now) {
            self.late.pop_front();
        }
    }

    /// How what comes out of it changes with what goes in.
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
            | Kind::Latency { .. } => 0.0,
            Kind::DropOut { .. } if self.lost => 0.0,
            _ => 1.0,
        }
    }
}

#[cfg(test)]
mod tests;
