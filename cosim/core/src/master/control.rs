//! Communication steps with error control, and rollback.
//!
//! Step doubling (Hairer, Norsett, Wanner, II.4): all components together make the step h, go back,
//! and make it again in two halves. The difference of the connected outputs estimates the coupling
//! error; held inputs cause an error of order h^2 per step, linear ones of order h^3. A step whose
//! error exceeds the tolerance, or that a component discards, is rejected and made shorter.

use super::engine::Engine;
use super::trend::{Ramp, Trend};
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::Time;
use cosim_import::{Place, Scalar};

const SAFETY: f64 = 0.9;
/// The smallest step is this part of the largest.
const SMALLEST: i64 = 10_000;

/// The step size control of a run.
pub(super) struct Control {
    tolerance: f64,
    largest: Time,
    /// Exponent of the error's dependence on the step: 1 / order.
    exponent: f64,
    /// For each slot of `values`: its usual magnitude, if it is a Real that counts.
    nominals: Vec<Option<f64>>,
    pub now: Time,
    /// The step to try next.
    pub step: Time,
    pub accepted: u64,
    pub rejected: u64,
    pub shortest: Time,
    pub longest: Time,
    /// Steps that were accepted because no shorter one was possible, and the time of the first.
    pub forced: u64,
    pub first_forced: Time,
}

/// State besides the slaves that is rolled back.
struct Kept {
    values: Vec<Scalar>,
    inputs: Vec<Scalar>,
    trends: Vec<Trend>,
    ramps: Vec<Ramp>,
}

impl Control {
    pub(super) fn new(
        tolerance: f64,
        largest: Time,
        start: Time,
        linear: bool,
        nominals: Vec<Option<f64>>,
    ) -> Self {
        Self {
            tolerance,
            largest,
            exponent: if linear { 1.0 / 3.0 } else { 0.5 },
            nominals,
            now: start,
            step: largest,
            accepted: 0,
            rejected: 0,
            shortest: largest,
            longest: Time::ZERO,
            forced: 0,
            first_forced: start,
        }
    }

    fn smallest(&self) -> Time {
        Time::from_ns((self.largest.ns() / SMALLEST).max(2))
    }

    /// A length close to the wanted one that divides the remaining time.
    fn length(&self, remaining: Time) -> Time {
        let wanted = self.step.min(self.largest).max(self.smallest());
        let parts = remaining.ns() as f64 / wanted.ns() as f64;
        // A remainder of a tenth of a step is included.
        let parts = (parts - 0.1).ceil().max(1.0);
        let length = (remaining.ns() as f64 / parts).ceil() as i64;
        Time::from_ns(length).min(remaining)
    }

    /// The greatest difference, relative to the tolerance; NaN if any value is NaN.
    fn error(&self, whole: &[Scalar], halves: &[Scalar]) -> f64 {
        let pairs = Scalar::reals(whole).iter().zip(Scalar::reals(halves)).zip(&self.nominals);
        let parts = pairs.filter_map(|((whole, halves), nominal)| {
            let scale = self.tolerance * (nominal.as_ref()? + halves.abs());
            Some((whole - halves).abs() / scale)
        });
        parts.fold(0.0, |most: f64, part| if part <= most { most } else { part })
    }
}

impl Engine {
    /// Steps all components together until `limit`.
    pub(super) fn run_controlled(&mut self, limit: Time) -> Result<()> {
        while let Some((now, length)) = self.control.as_ref().and_then(|control| {
            let remaining = limit - control.now;
            (remaining > Time::ZERO).then(|| (control.now, control.length(remaining)))
        }) {
            for slave in &mut self.slaves {
                slave.save(Place::Control)?;
            }
            let kept = self.keep();
            let error = self.attempt(now, length, &kept)?;
            self.judge(now, length, error, &kept)?;
        }
        Ok(())
    }

    /// Makes the step as a whole, then in halves: returns the error, or how far a discarded step
    /// got.
    fn attempt(&mut self, now: Time, length: Time, kept: &Kept) -> Result<Result<f64, Time>> {
        self.discarded = None;
        self.together(now, length)?;
        let whole = self.values.clone();
        let half = Time::from_ns(length.ns() / 2);
        if self.discarded.is_none() {
            self.go_back(now, kept)?;
            self.together(now, half)?;
        }
        if self.discarded.is_none() {
            self.together(now + half, length - half)?;
        }
        let error = self.control.as_ref().map_or(0.0, |c| c.error(&whole, &self.values));
        Ok(self.discarded.take().map_or(Ok(error), Err))
    }

    /// Accepts the step just made, or rejects it; chooses the next length.
    fn judge(
        &mut self,
        now: Time,
        length: Time,
        error: Result<f64, Time>,
        kept: &Kept,
    ) -> Result<()> {
        let Some(control) = &mut self.control else {
            return Ok(());
        };
        let smallest = length <= control.smallest();
        let factor = match error {
            Ok(0.0) => 5.0,
            Ok(error) if error.is_finite() => SAFETY * libm::pow(error, -control.exponent),
            _ => 0.1,
        };
        let scaled = |factor: f64| Time::from_ns((length.ns() as f64 * factor) as i64);
        if error.is_ok_and(|error| error <= 1.0 || (smallest && error.is_finite())) {
            if error.is_ok_and(|error| error > 1.0) {
                if control.forced == 0 {
                    control.first_forced = now;
                }
                control.forced += 1;
            }
            control.accepted += 1;
            control.shortest = control.shortest.min(length);
            control.longest = control.longest.max(length);
            control.now = now + length;
            let suggested = scaled(factor.clamp(0.2, 5.0));
            // A step shortened by its limit is no evidence against longer ones.
            control.step =
                if length < control.step { suggested.max(control.step) } else { suggested };
            return Ok(());
        }
        if smallest {
            return Err(Error::new(Code::Step, format!("no step is small enough at t = {now}"))
                .why(format!("a step of {length} is still discarded, or gives no finite values"))
                .help("a smaller --step of the components makes the smallest step smaller too"));
        }
        control.rejected += 1;
        control.step = match error {
            Err(reached) if reached > now => reached - now,
            Err(_) => scaled(0.5),
            Ok(_) => scaled(factor.clamp(0.1, 0.9)),
        };
        self.go_back(now, kept)
    }

    /// Every component makes the same step.
    fn together(&mut self, begin: Time, length: Time) -> Result<()> {
        for pace in &mut self.paces {
            (pace.length, pace.end) = (length, begin + length);
        }
        self.instant(begin + length)
    }

    fn keep(&self) -> Kept {
        Kept {
            values: self.values.clone(),
            inputs: self.inputs.clone(),
            trends: self.trends.clone(),
            ramps: self.ramps.clone(),
        }
    }

    fn go_back(&mut self, now: Time, kept: &Kept) -> Result<()> {
        for slave in &mut self.slaves {
            slave.restore(Place::Control, now)?;
        }
        self.values.copy_from_slice(&kept.values);
        self.inputs.copy_from_slice(&kept.inputs);
        self.trends.copy_from_slice(&kept.trends);
        self.ramps.copy_from_slice(&kept.ramps);
        Ok(())
    }
}
