//! Time as integer nanoseconds; seconds as `f64` exist only at the edges (files, FMI calls).
//!
//! Instants are compared and added exactly, so a run of any length has no drift, and steps of two
//! components that end together are recognized as such. A [`Step`] may be a fraction of
//! nanoseconds, such as 1/30 s: each of its multiples is rounded once, to the nearest nanosecond.

use std::cmp::Ordering;
use std::fmt;
use std::ops::{Add, Sub};

use serde::{Deserialize, Serialize};

/// Nanoseconds per second.
const NS_PER_S: f64 = 1e9;

/// An instant or a duration of simulated time in integer nanoseconds (292 years either way).
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
pub struct Time {
    ns: i64,
}

/// Why a number of seconds is not a time or not a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeError {
    /// Not finite, or too large to be counted.
    OutOfRange,
    /// A step that is not positive.
    NotPositive,
}

impl Time {
    /// Zero.
    pub const ZERO: Self = Self { ns: 0 };

    /// After all instants: used if the stop time is unknown.
    pub const NEVER: Self = Self { ns: i64::MAX };

    /// The instant of this many nanoseconds.
    #[must_use]
    pub const fn from_ns(ns: i64) -> Self {
        Self { ns }
    }

    /// The instant nearest to `seconds`; the first or the last one if there is none.
    #[inline]
    #[must_use]
    pub fn from_seconds(seconds: f64) -> Self {
        Self { ns: nearest(seconds * NS_PER_S) }
    }

    /// The instant nearest to `seconds`.
    ///
    /// # Errors
    /// It is beyond 2^62 ns (146 years), which leaves space for additions.
    pub fn try_from_seconds(seconds: f64) -> Result<Self, TimeError> {
        let ns = seconds * NS_PER_S;
        match ns.abs() < (1_i64 << 62) as f64 {
            true => Ok(Self { ns: nearest(ns) }),
            false => Err(TimeError::OutOfRange),
        }
    }

    /// Nanoseconds.
    #[must_use]
    pub const fn ns(self) -> i64 {
        self.ns
    }

    /// Seconds, rounded to the nearest `f64`.
    #[inline]
    #[must_use]
    pub fn seconds(self) -> f64 {
        self.ns as f64 / NS_PER_S
    }

    /// This instant and `ns` nanoseconds later, clamped to the range.
    #[must_use]
    pub const fn after_ns(self, ns: i64) -> Self {
        Self { ns: self.ns.saturating_add(ns) }
    }
}

/// The integer nearest to a number, ties away from zero, as [`f64::round`] gives it, which is a call
/// on processors that may lack an instruction for it.
#[inline]
fn nearest(number: f64) -> i64 {
    let whole = number as i64;
    let rest = number - whole as f64;
    whole.saturating_add(i64::from(rest >= 0.5)).saturating_sub(i64::from(rest <= -0.5))
}

impl fmt::Display for TimeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OutOfRange => "time is counted in nanoseconds and must stay within 146 years",
            Self::NotPositive => "it must be at least one nanosecond",
        })
    }
}

impl std::error::Error for TimeError {}

/// The length of steps: a positive number of nanoseconds, integer or not.
///
/// An instant is a multiple of this rational number, rounded once: steps of 1/30 s and 1/60 s
/// coincide at the same instants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Step {
    /// Both positive, without a common divisor.
    nanoseconds: i64,
    parts: i64,
}

/// A non-integer number of nanoseconds is a fraction with a denominator up to this …
const MOST_PARTS: i64 = 1_000_000;
/// … if it equals it to the precision of its digits, …
const EXACTLY: f64 = 4.5e-16;
/// … or to that of a few digits less, if the denominator is small.
const FEW_PARTS: i64 = 64;
const NEARLY: f64 = 2e-12;

impl Step {
    /// A step of this many seconds.
    ///
    /// # Errors
    /// It is not positive, or too long.
    pub fn from_seconds(seconds: f64) -> Result<Self, TimeError> {
        let time = Time::try_from_seconds(seconds)?;
        if time <= Time::ZERO {
            return Err(TimeError::NotPositive);
        }
        Ok(match time.seconds() == seconds {
            true => Self::whole(time),
            false => fraction(seconds * NS_PER_S).unwrap_or(Self::whole(time)),
        })
    }

    /// An integer number of nanoseconds, at least one.
    #[must_use]
    pub fn whole(time: Time) -> Self {
        Self { nanoseconds: time.ns.max(1), parts: 1 }
    }

    fn reduced(nanoseconds: i128, parts: i128) -> Option<Self> {
        let common = gcd(nanoseconds, parts);
        let part = |number: i128| i64::try_from(number / common).ok().filter(|n| *n > 0);
        Some(Self { nanoseconds: part(nanoseconds)?, parts: part(parts)? })
    }

    /// Whether it is an integer number of nanoseconds.
    #[inline]
    #[must_use]
    pub fn is_whole(self) -> bool {
        self.parts == 1
    }

    /// Seconds, rounded once.
    #[must_use]
    pub fn seconds(self) -> f64 {
        self.nanoseconds as f64 / (self.parts as f64 * NS_PER_S)
    }

    /// The nearest integer number of nanoseconds, but not zero.
    #[must_use]
    pub fn rounded(self) -> Time {
        self.multiple(1).max(Time::from_ns(1))
    }

    /// This many steps, to the nearest nanosecond.
    #[inline]
    #[must_use]
    pub fn multiple(self, count: i64) -> Time {
        if self.is_whole() {
            // Without the division of 128 bits, which costs more than a step of a small FMU.
            return Time::from_ns(count.wrapping_mul(self.nanoseconds));
        }
        self.multiple_of_fraction(count)
    }

    fn multiple_of_fraction(self, count: i64) -> Time {
        let (whole, parts) = (i128::from(self.nanoseconds), i128::from(self.parts));
        Time::from_ns(((2 * i128::from(count) * whole + parts).div_euclid(2 * parts)) as i64)
    }

    /// How many whole steps end by `duration`.
    #[inline]
    #[must_use]
    pub fn count(self, duration: Time) -> i64 {
        match self.is_whole() {
            true => duration.ns.div_euclid(self.nanoseconds),
            false => self.count_of_fraction(duration),
        }
    }

    fn count_of_fraction(self, duration: Time) -> i64 {
        let (whole, parts) = (i128::from(self.nanoseconds), i128::from(self.parts));
        let mut count = (i128::from(duration.ns) * parts).div_euclid(whole) as i64;
        // A multiple that is rounded up to that instant counts.
        while self.multiple(count + 1) <= duration {
            count += 1;
        }
        while self.multiple(count) > duration {
            count -= 1;
        }
        count
    }

    /// The first multiple after `duration`.
    #[inline]
    #[must_use]
    pub fn after(self, duration: Time) -> Time {
        self.multiple(self.count(duration) + 1)
    }

    /// This many steps as one.
    #[must_use]
    pub fn times(self, count: i64) -> Step {
        let nanoseconds = i128::from(self.nanoseconds) * i128::from(count);
        Self::reduced(nanoseconds, i128::from(self.parts)).unwrap_or(self)
    }

    /// This divided into this many equal steps.
    #[must_use]
    pub fn part(self, count: i64) -> Step {
        let parts = i128::from(self.parts) * i128::from(count.max(1));
        Self::reduced(i128::from(self.nanoseconds), parts).unwrap_or(self)
    }

    /// Whether its numbers are valid for a step: it may come from another process.
    #[must_use]
    pub fn is_sound(self) -> bool {
        self.nanoseconds > 0 && self.parts > 0
    }

    /// Whether `duration` is an integer number of steps.
    #[must_use]
    pub fn divides(self, duration: Time) -> bool {
        self.multiple(self.count(duration)) == duration
    }

    /// How many steps `other` is, if that is an integer.
    #[must_use]
    pub fn parts_of(self, other: Step) -> Option<i64> {
        let quotient = Self::reduced(
            i128::from(other.nanoseconds) * i128::from(self.parts),
            i128::from(other.parts) * i128::from(self.nanoseconds),
        )?;
        (quotient.parts == 1).then_some(quotient.nanoseconds)
    }

    /// The seconds of an instant that is a multiple of the step after `start`, rounded once;
    /// otherwise those of its nanoseconds.
    #[must_use]
    pub fn seconds_at(self, start: Time, now: Time) -> f64 {
        let count = self.count(now - start);
        if self.is_whole() || self.multiple(count) != now - start {
            return now.seconds();
        }
        let parts = i128::from(self.parts);
        let exact = i128::from(start.ns) * parts + i128::from(count) * i128::from(self.nanoseconds);
        exact as f64 / (self.parts as f64 * NS_PER_S)
    }

    /// The greatest step of which both are multiples; the shortest possible one if it cannot be
    /// determined.
    #[must_use]
    pub fn gcd(self, other: Step) -> Step {
        let (a, b) = (i128::from(self.nanoseconds), i128::from(other.nanoseconds));
        let (p, q) = (i128::from(self.parts), i128::from(other.parts));
        Self::reduced(gcd(a * q, b * p), p * q).unwrap_or(Step { nanoseconds: 1, parts: i64::MAX })
    }
}

/// The simplest fraction for a number, by its continued fraction.
fn fraction(number: f64) -> Option<Step> {
    let (mut before, mut convergent) = ((0_i128, 1_i128), (1_i128, 0_i128));
    let mut rest = number;
    loop {
        let whole = rest.floor();
        let next = |(a, b): (i128, i128), (c, d): (i128, i128)| {
            let whole = whole as i128;
            Some((whole.checked_mul(c)?.checked_add(a)?, whole.checked_mul(d)?.checked_add(b)?))
        };
        (before, convergent) = (convergent, next(before, convergent)?);
        let (nanoseconds, parts) = convergent;
        if parts > i128::from(MOST_PARTS) {
            return None;
        }
        let error = (nanoseconds as f64 / parts as f64 - number).abs();
        let few = parts <= i128::from(FEW_PARTS);
        if error <= number * if few { NEARLY } else { EXACTLY } {
            return Step::reduced(nanoseconds, parts);
        }
        rest = (rest - whole).recip();
        if !rest.is_finite() {
            return None;
        }
    }
}

fn gcd(mut a: i128, mut b: i128) -> i128 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a.abs().max(1)
}

impl Ord for Step {
    fn cmp(&self, other: &Self) -> Ordering {
        let of = |step: &Self, parts: i64| i128::from(step.nanoseconds) * i128::from(parts);
        of(self, other.parts).cmp(&of(other, self.parts))
    }
}

impl PartialOrd for Step {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} s", self.seconds())
    }
}

impl Add for Time {
    type Output = Time;
    #[inline]
    fn add(self, other: Time) -> Time {
        Time::from_ns(self.ns + other.ns)
    }
}

impl Sub for Time {
    type Output = Time;
    #[inline]
    fn sub(self, other: Time) -> Time {
        Time::from_ns(self.ns - other.ns)
    }
}

impl fmt::Display for Time {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} s", self.seconds())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_steps_are_exact() {
        let step = Time::try_from_seconds(0.1).unwrap();
        assert_eq!(step.ns(), 100_000_000);
        assert_eq!((step + step + step).seconds(), 0.3);
    }

    #[test]
    fn whole_steps_are_counted_as_fractions_are() {
        for (step, ns) in [(1, 7), (10, 29), (10, 30), (10, -1), (10, -10), (3_000_000_000, -7)] {
            let (step, duration) = (Step::whole(Time::from_ns(step)), Time::from_ns(ns));
            assert_eq!(step.count(duration), step.count_of_fraction(duration), "{step} {ns}");
            assert_eq!(step.multiple(ns), step.multiple_of_fraction(ns), "{step} {ns}");
        }
    }

    #[test]
    fn the_nearest_integer_is_that_of_the_standard_library() {
        let below_half = 0.5_f64.next_down();
        let numbers = [0.0, 0.5, below_half, 1.5, 2.5, 7.4, 1e9 + 0.5, 4503599627370497.5, 9e18];
        for number in numbers.into_iter().chain([1e19, f64::INFINITY]).flat_map(|n| [n, -n]) {
            assert_eq!(nearest(number), number.round() as i64, "{number}");
        }
        assert_eq!(nearest(f64::NAN), 0);
    }

    #[test]
    fn no_number_that_is_no_time() {
        for bad in [f64::NAN, f64::INFINITY, 1e300] {
            assert!(Time::try_from_seconds(bad).is_err());
        }
        for bad in [0.0, -1.0, 1e-12, f64::NAN] {
            assert!(Step::from_seconds(bad).is_err());
        }
    }

    fn step(seconds: f64) -> Step {
        Step::from_seconds(seconds).unwrap()
    }

    #[test]
    fn gcd_of_steps() {
        assert_eq!(step(0.05).gcd(step(0.02)), step(0.01));
        assert_eq!(step(1.0 / 30.0).gcd(step(0.01)), step(1.0 / 300.0));
        assert_eq!(step(1.0 / 60.0).parts_of(step(1.0 / 12.0)), Some(5));
        assert_eq!(step(0.02).parts_of(step(0.05)), None);
    }

    #[test]
    fn steps_are_what_their_digits_mean() {
        let parts = |seconds: f64| (step(seconds).nanoseconds, step(seconds).parts);
        for decimal in [0.1, 0.007, 1e-9, 0.123_456_789, 12.5, 3.0e5, 0.1 * 3.0] {
            assert!(step(decimal).is_whole(), "{decimal}");
        }
        for thirtieth in [1.0 / 30.0, 0.033_333_333_333_333, 0.033_333_333_333_333_3] {
            assert_eq!(parts(thirtieth), (100_000_000, 3));
        }
        assert_eq!(parts(1.0 / 44_100.0), (10_000_000, 441));
        assert_eq!(parts(1001.0 / 30_000.0), (100_100_000, 3));
        assert_eq!(parts(1.0 / 1024.0), (1_953_125, 2));
        assert_eq!(parts(100.0 / 3.0), (100_000_000_000, 3));
        // Nine decimals are meant literally.
        assert_eq!(parts(0.033_333_333), (33_333_333, 1));
    }

    #[test]
    fn multiples_of_fractions_neither_drift_nor_part() {
        let (slow, fast) = (step(1.0 / 30.0), step(1.0 / 60.0));
        let (mut a, mut b) = (Time::ZERO, Time::ZERO);
        for k in 1..=3_000_000 {
            a = slow.after(a);
            b = fast.after(fast.after(b));
            assert_eq!(a, b);
            if k % 30 == 0 {
                assert_eq!(a, Time::from_ns(k / 30 * 1_000_000_000));
            }
        }
        assert!(slow.divides(Time::from_ns(100_000_000)));
        assert!(!slow.divides(Time::from_ns(110_000_000)));
        let start = Time::from_ns(5_000_000_000);
        let now = start + slow.multiple(7);
        assert_eq!(slow.seconds_at(start, now), 157.0 / 30.0);
        assert_eq!(slow.after(Time::from_ns(-1)), Time::ZERO);
    }
}
