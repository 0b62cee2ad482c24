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
mod tests {
    use super::*;
    use crate::fault::{Begin, Fault};

    fn seconds(seconds: f64) -> Time {
        Time::from_seconds(seconds, "t").unwrap()
    }

    fn fault(kind: Kind) -> Fault {
        Fault {
            variables: Vec::new(),
            kind,
            begin: Begin::At(seconds(2.0)),
            end: End::At(seconds(5.0)),
            ramp_in: Time::ZERO,
            ramp_out: Time::ZERO,
        }
    }

    /// What an output 0, 10, 20 … at 0 s, 1 s, 2 s … becomes.
    fn course(mut acting: Acting, steps: i32) -> Vec<f64> {
        let mut seen = vec![acting.apply(0.0)];
        for step in 1..=steps {
            acting.advance(seconds(f64::from(step - 1)), seconds(f64::from(step)));
            let value = f64::from(step) * 10.0;
            // Asked twice, and first for a value that is not the last word.
            acting.apply(value - 3.0);
            let first = acting.apply(value);
            assert_eq!(acting.apply(value).to_bits(), first.to_bits());
            seen.push(first);
        }
        seen
    }

    fn output(kind: Kind) -> Vec<f64> {
        course(fault(kind).acting(1, 0, 0, Time::ZERO).installed(Way::Output, Time::ZERO), 6)
    }

    #[test]
    fn each_kind_without_chance_does_what_it_says() {
        let with = |faulty: [f64; 3]| vec![0.0, 10.0, 20.0, faulty[0], faulty[1], faulty[2], 60.0];
        assert_eq!(output(Kind::Override(7.0)), with([7.0; 3]));
        assert_eq!(output(Kind::Bias(0.5)), with([30.5, 40.5, 50.5]));
        assert_eq!(output(Kind::Scale(2.0)), with([60.0, 80.0, 100.0]));
        assert_eq!(output(Kind::Drift(0.5)), with([30.5, 41.0, 51.5]));
        assert_eq!(output(Kind::Ramp { size: 4.0, over: 2.0 }), with([32.0, 44.0, 54.0]));
        assert_eq!(output(Kind::Stuck), with([20.0; 3]));
        assert_eq!(output(Kind::Quantization(40.0)), with([40.0, 40.0, 40.0]));
        assert_eq!(output(Kind::Saturation(0.0, 45.0)), with([30.0, 40.0, 45.0]));
        let lost = |meanwhile| output(Kind::DropOut { turns: None, meanwhile });
        assert_eq!(lost(Meanwhile::Last), with([20.0; 3]));
        assert_eq!(lost(Meanwhile::Zero), with([0.0; 3]));
        assert!(lost(Meanwhile::NotANumber)[3..6].iter().all(|v| v.is_nan()));
        assert!(output(Kind::NotANumber)[3..6].iter().all(|v| v.is_nan()));
        assert_eq!(output(Kind::Latency { delay: 2.0, jitter: 0.0 }), with([10.0, 20.0, 30.0]));
    }

    #[test]
    fn an_input_is_acted_on_from_the_step_that_begins_then() {
        let mut acting =
            fault(Kind::Bias(1.0)).acting(1, 0, 0, Time::ZERO).installed(Way::Input, Time::ZERO);
        let mut seen = Vec::new();
        for step in 0..6 {
            seen.push(acting.apply(0.0));
            acting.advance(seconds(f64::from(step)), seconds(f64::from(step + 1)));
        }
        assert_eq!(seen, [0.0, 0.0, 1.0, 1.0, 1.0, 0.0]);
    }

    #[test]
    fn ramps_blend_and_late_values_keep_their_order() {
        let mut ramped = fault(Kind::Bias(4.0));
        (ramped.ramp_in, ramped.ramp_out) = (seconds(2.0), seconds(1.0));
        let seen = course(ramped.acting(1, 0, 0, Time::ZERO).installed(Way::Output, Time::ZERO), 6);
        assert_eq!(seen, [0.0, 10.0, 20.0, 32.0, 44.0, 50.0, 60.0]);
        let mut late = fault(Kind::Latency { delay: 0.0, jitter: 3.0 });
        late.end = End::Never;
        let seen = course(late.acting(1, 0, 0, Time::ZERO).installed(Way::Output, Time::ZERO), 60);
        assert!(seen[3..].windows(2).all(|pair| pair[0] <= pair[1]), "{seen:?}");
        assert!(seen[3..].iter().zip(3..).any(|(v, step)| *v < f64::from(step) * 10.0));
        assert!(seen[3..].iter().zip(3..).all(|(v, step)| *v >= f64::from(step - 3) * 10.0));
    }

    #[test]
    fn noise_has_its_deviation_and_its_correlation_and_other_variables_other_noise() {
        let long = |kind: Kind, place| {
            let mut fault = fault(kind);
            (fault.begin, fault.end) = (Begin::At(Time::ZERO), End::Never);
            let seen = course(
                fault.acting(5, 1, place, Time::ZERO).installed(Way::Output, Time::ZERO),
                20_000,
            );
            let errors = seen.iter().zip(0..).map(|(v, step)| v - 10.0 * f64::from(step));
            errors.skip(1).collect::<Vec<f64>>()
        };
        let variance = |e: &[f64]| e.iter().map(|v| v * v).sum::<f64>() / e.len() as f64;
        let correlation = |e: &[f64]| {
            e.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / (e.len() as f64 * variance(e))
        };
        let white = long(Kind::WhiteNoise(2.0), 0);
        assert!((variance(&white) - 4.0).abs() < 0.3 && correlation(&white).abs() < 0.05);
        assert_ne!(white, long(Kind::WhiteNoise(2.0), 1));
        let coloured = long(Kind::GaussMarkov { sigma: 2.0, tau: 2.0 }, 0);
        assert!((variance(&coloured) - 4.0).abs() < 0.6, "{}", variance(&coloured));
        assert!((correlation(&coloured) - 0.6065).abs() < 0.03, "{}", correlation(&coloured));
        let outliers = long(Kind::Outliers { share: 0.05, size: Spread::Uniform(3.0) }, 0);
        let share = outliers.iter().filter(|e| **e != 0.0).count() as f64 / 2e4;
        assert!((share - 0.05).abs() < 0.01 && outliers.iter().all(|e| e.abs() <= 3.0), "{share}");
    }

    #[test]
    fn a_connection_that_comes_and_goes_is_lost_for_its_share_of_the_time() {
        let mut fault =
            fault(Kind::DropOut { turns: Some((30.0, 10.0)), meanwhile: Meanwhile::NotANumber });
        (fault.begin, fault.end) = (Begin::At(Time::ZERO), End::Never);
        let of = |place| {
            let acting = fault.acting(3, 0, place, Time::ZERO).installed(Way::Output, Time::ZERO);
            course(acting, 40_000).iter().map(|v| v.is_nan()).collect::<Vec<bool>>()
        };
        let lost = of(0);
        let share = lost.iter().filter(|lost| **lost).count() as f64 / 4e4;
        assert!((share - 0.25).abs() < 0.03, "{share}");
        // Variables of one fault are lost together.
        assert_eq!(lost, of(1));
    }

    #[test]
    fn an_instant_that_is_drawn_lies_within_and_a_condition_counts_once() {
        let mut fault = fault(Kind::Override(1.0));
        fault.begin = Begin::Between(seconds(2.0), seconds(4.0));
        let drawn: Vec<Time> =
            (0..50).map(|seed| fault.acting(seed, 0, 0, Time::ZERO).from.unwrap()).collect();
        assert!(drawn.iter().all(|t| *t >= seconds(2.0) && *t <= seconds(4.0)));
        assert_ne!(drawn[0], drawn[1]);
        fault.begin = Begin::When("a > 1".parse().unwrap());
        fault.end = End::After(seconds(3.0));
        let mut acting = fault.acting(1, 4, 0, Time::ZERO);
        acting.trigger(3, seconds(1.0));
        assert_eq!(acting.from, None);
        acting.trigger(4, seconds(2.0));
        acting.trigger(4, seconds(3.0));
        assert_eq!((acting.from, acting.until), (Some(seconds(2.0)), seconds(5.0)));
    }

    #[test]
    fn a_state_that_was_saved_goes_on_in_the_same_way() {
        for kind in [
            Kind::GaussMarkov { sigma: 1.0, tau: 3.0 },
            Kind::Latency { delay: 1.5, jitter: 1.0 },
            Kind::DropOut { turns: Some((2.0, 2.0)), meanwhile: Meanwhile::Last },
        ] {
            let mut one =
                fault(kind).acting(9, 0, 0, Time::ZERO).installed(Way::Output, Time::ZERO);
            one.until = Time::NEVER;
            for step in 1..8 {
                one.advance(seconds(f64::from(step - 1)), seconds(f64::from(step)));
                one.apply(f64::from(step));
            }
            let octets = postcard::to_stdvec(&one).unwrap();
            let mut other: Acting = postcard::from_bytes(&octets).unwrap();
            for step in 8..50 {
                let next = |acting: &mut Acting| {
                    acting.advance(seconds(f64::from(step - 1)), seconds(f64::from(step)));
                    acting.apply(f64::from(step)).to_bits()
                };
                assert_eq!(next(&mut one), next(&mut other));
            }
        }
    }
}
