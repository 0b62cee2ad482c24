//! Co-simulation: communication steps.

use super::call::{Call, Phase};
use super::instance::{Instance, Interface};
use super::status::{Status, Trouble};

/// Two times are the same if no more than this many ulp apart …
const SAME_ULP: f64 = 16.0;
/// … or this many seconds, the resolution of time events.
const SAME_S: f64 = 1e-9;

/// Whether two times are the same but for rounding.
#[inline]
fn same_time(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME_S.max(SAME_ULP * f64::EPSILON * a.abs().max(b.abs()))
}

impl Instance {
    /// `fmi2DoStep`: advances from `t` by `h` seconds.
    ///
    /// `h` may be as small as the importer's rounding leaves it, and `t` may miss the instance's
    /// own time by such rounding; time events are counted in integer nanoseconds and happen once.
    #[inline]
    pub fn do_step(&mut self, t: f64, h: f64) -> Status {
        self.call(Call::DoStep, |me| me.step(t, h))
    }

    fn step(&mut self, t: f64, h: f64) -> Result<(), Trouble> {
        self.check_step(t, h)?;
        let events = self
            .model
            .step(t, h, &mut self.values)
            .map_err(|fault| Trouble::error(format_args!("step from {t} s by {h} s: {fault}")))
            .inspect_err(|_| self.phase = Phase::Error)?;
        self.set_clock(t + h);
        self.stale.outputs = false;
        self.stale.derivatives = !self.table.layout().states.is_empty();
        self.check_outputs()
            .inspect_err(|_| self.phase = Phase::Error)?;
        if events > 0 {
            self.log
                .event(|| format!("{events} time events until {} s", self.time_s));
        }
        Ok(())
    }

    fn check_step(&self, t: f64, h: f64) -> Result<(), Trouble> {
        if !(h >= 0.0 && h.is_finite()) {
            return Err(Trouble::error(format_args!(
                "communicationStepSize = {h} s; it must not be negative and must be finite"
            )));
        }
        if !same_time(t, self.time_s) {
            return Err(Trouble::error(format_args!(
                "currentCommunicationPoint = {t} s, but this instance is at {} s; steps must join",
                self.time_s
            )));
        }
        match self.stop_s {
            Some(stop) if t + h > stop && !same_time(t + h, stop) => {
                Err(Trouble::error(format_args!(
                    "a step to {} s goes past the stop time of {stop} s given in \
                     fmi2SetupExperiment",
                    t + h
                )))
            }
            _ => Ok(()),
        }
    }

    /// `fmi2GetRealStatus` of `fmi2LastSuccessfulTime`
    pub fn last_successful_time(&mut self, into: &mut f64) -> Status {
        self.call(Call::GetRealStatus, |me| {
            *into = me.time_s;
            Ok(())
        })
    }

    /// `fmi2GetBooleanStatus` of `fmi2Terminated`: a component never ends a simulation by itself.
    pub fn wants_to_end(&mut self, into: &mut bool) -> Status {
        self.call(Call::GetBooleanStatus, |_| {
            *into = false;
            Ok(())
        })
    }

    /// Any other status kind: it would tell of a pending step, and there never is one.
    pub fn no_status(&mut self, call: Call, kind: i32) -> Status {
        self.call(call, |_| {
            Err(Trouble::discard(format_args!(
                "status kind {kind} is not available: steps are never pending"
            )))
        })
    }

    /// The time of the instance in seconds.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    /// Which interface the instance serves.
    #[must_use]
    pub fn interface(&self) -> Interface {
        self.interface
    }
}
