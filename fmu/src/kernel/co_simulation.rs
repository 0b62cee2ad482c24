//! Co-simulation: communication steps.

use fmu_standard::{Basic, Call, InterfaceType, Phase, Status};

use super::clock::check_step;
use super::instance::Instance;
use super::model::{Cause, Halt};
use super::signal::{Course, ORDERS};
use super::status::Trouble;
use super::stepper::MOST_WORK;

impl Instance {
    /// `DoStep`: advances from `t` by `h` seconds.
    ///
    /// `h` may be as small as the importer's rounding leaves it, and `t` may differ from the
    /// instance's own time by such rounding; time events are counted in integer nanoseconds and
    /// happen once.
    #[inline]
    pub fn do_step(&mut self, t: f64, h: f64) -> Status {
        self.call(Call::DoStep, |me| me.step(t, h))
    }

    fn step(&mut self, t: f64, h: f64) -> Result<(), Trouble> {
        check_step(t, h, self.run.time_s, self.run.stop_s)?;
        let slopes = (self.slopes.course == Course::Ahead).then_some(&self.slopes);
        let fresh = !self.run.stale.outputs;
        let events = match self.model.step(t, h, slopes, fresh, &mut self.values) {
            Ok(events) => events,
            Err(halt) => return Err(self.halted(t, h, &halt)),
        };
        self.set_clock(t + h);
        self.slopes.pass(h);
        self.run.stale.outputs = false;
        self.run.stale.derivatives = !self.table.layout().states.is_empty();
        if events > 0 {
            self.log.event(|| format!("{events} events until {} s", self.run.time_s));
            self.log_notice();
        }
        Ok(())
    }

    /// A step that ended early: an error, or discarded if a shorter step may succeed.
    #[cold]
    fn halted(&mut self, t: f64, h: f64, halt: &Halt) -> Trouble {
        let reached = halt.reached_s;
        self.set_clock(reached);
        self.slopes.pass(reached - t);
        self.run.stale.outputs = false;
        self.run.stale.derivatives = true;
        let step = format!("step from {t} s by {h} s, successful until {reached} s");
        let discard = |reason: String| {
            Trouble::discard(format_args!(
                "{step}: {reason}; restore an earlier state and step to a time before, or look at \
                 the inputs and start values that lead there"
            ))
        };
        self.run.phase = Phase::Failed;
        match &halt.cause {
            Cause::Fault(fault) => {
                self.run.phase = Phase::Error;
                Trouble::error(format_args!("step from {t} s by {h} s, at {reached} s: {fault}"))
            }
            Cause::NotFinite(reference) => {
                let variable = u32::try_from(*reference)
                    .ok()
                    .and_then(|reference| self.table.find(Basic::Real, reference));
                let name = variable.map_or("?", |variable| variable.name.as_str());
                discard(format!("{name} is not finite"))
            }
            Cause::Work => discard(format!(
                "the rest takes more than the {MOST_WORK} integration steps and events of one \
                 call; step in shorter communication steps"
            )),
            Cause::Accuracy { error, tolerance } => discard(format!(
                "the error of the shortest step is {error:e} times the tolerance of {tolerance:e}"
            )),
        }
    }

    /// `SetRealInputDerivatives`: for the next step; after it inputs are held at the values
    /// they reached.
    pub fn set_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Status {
        self.call(Call::SetRealInputDerivatives, |me| {
            let inputs = me.table.layout().inputs.clone();
            let each = || references.iter().zip(orders).zip(values);
            for ((reference, order), value) in each() {
                let name = || me.table.find(Basic::Real, *reference).map_or("?", |v| &v.name);
                if !inputs.contains(&(*reference as usize)) {
                    return Err(Trouble::error(format_args!(
                        "{} (value reference {reference}) is not an input of type Real",
                        name()
                    )));
                }
                if !(1..=ORDERS as i32).contains(order) {
                    return Err(Trouble::error(format_args!(
                        "{}: order = {order}; derivatives of order 1 to {ORDERS} are taken",
                        name()
                    )));
                }
                if !value.is_finite() {
                    return Err(Trouble::error(format_args!(
                        "derivative {order} of {} = {value} is not finite",
                        name()
                    )));
                }
            }
            for ((reference, order), value) in each() {
                let input = (*reference as usize).saturating_sub(inputs.start);
                me.slopes.set(input, usize::try_from(*order).unwrap_or_default(), *value);
            }
            Ok(())
        })
    }

    /// `GetRealStatus` of `LastSuccessfulTime`
    pub fn last_successful_time(&mut self, into: &mut f64) -> Status {
        self.call(Call::GetRealStatus, |me| {
            *into = me.run.time_s;
            Ok(())
        })
    }

    /// `GetBooleanStatus` of `Terminated`: a component never ends a simulation by itself.
    pub fn wants_to_end(&mut self, into: &mut bool) -> Status {
        self.call(Call::GetBooleanStatus, |_| {
            *into = false;
            Ok(())
        })
    }

    /// The time of the instance in seconds.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.run.time_s
    }

    /// Which interface the instance serves.
    #[must_use]
    pub fn interface(&self) -> InterfaceType {
        self.interface
    }
}
