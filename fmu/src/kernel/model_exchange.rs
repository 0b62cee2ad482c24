//! Model exchange: the importer integrates.

use fmu_standard::{Call, Phase, Status};

use crate::author::Time;

use super::clock::check_instant;
use super::instance::{Instance, Stale};
use super::model::Events;
use super::status::Trouble;
use super::table::Group;
use super::values::all_finite;

/// What `NewDiscreteStates` reports to the importer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EventOutcome {
    /// Whether to call again before continuing.
    pub again: bool,
    /// Whether an event changed the continuous states.
    pub states_changed: bool,
    /// The next time event.
    pub next_event: Option<Time>,
}

impl Instance {
    /// `EnterEventMode`
    pub fn enter_event_mode(&mut self) -> Status {
        self.call(Call::EnterEventMode, |me| {
            me.run.phase = Phase::Event;
            Ok(())
        })
    }

    /// `EnterContinuousTimeMode`
    pub fn enter_continuous_time_mode(&mut self) -> Status {
        self.call(Call::EnterContinuousTimeMode, |me| {
            me.run.phase = Phase::Continuous;
            Ok(())
        })
    }

    /// `NewDiscreteStates`: handles the time events that are due, and checks for a state event.
    pub fn new_discrete_states(&mut self, outcome: &mut EventOutcome) -> Status {
        self.call(Call::NewDiscreteStates, |me| {
            let before: Vec<f64> = me.states().to_vec();
            let events = me
                .model
                .events(me.run.time_s, &mut me.values)
                .map_err(|fault| Trouble::error(format_args!("at {} s: {fault}", me.run.time_s)))
                .inspect_err(|_| me.run.phase = Phase::Error)?;
            if events != Events::default() {
                me.evaluate_again();
                me.log.event(|| {
                    let (n, t) = (events.time_events, me.run.time_s);
                    let state = if events.changed { " and a state event" } else { "" };
                    format!("{n} time events{state} at {t} s")
                });
                me.log_notice();
            }
            *outcome = EventOutcome {
                again: events.changed,
                states_changed: me.states() != before,
                next_event: me.model.next_event(),
            };
            Ok(())
        })
    }

    /// `CompletedIntegratorStep`: nothing depends on accepted steps.
    pub fn completed_integrator_step(&mut self) -> Status {
        self.call(Call::CompletedIntegratorStep, |_| Ok(()))
    }

    /// `SetTime`
    pub fn set_time(&mut self, time_s: f64) -> Status {
        self.call(Call::SetTime, |me| {
            check_instant("time", time_s)?;
            me.set_clock(time_s);
            me.evaluate_again();
            Ok(())
        })
    }

    /// `SetContinuousStates`
    pub fn set_continuous_states(&mut self, x: &[f64]) -> Status {
        self.call(Call::SetContinuousStates, |me| {
            me.check_number_of_states(x.len())?;
            if !all_finite(x) {
                return Err(Trouble::discard(me.which_is_not_finite(x)));
            }
            let place = me.table.layout().states.clone();
            if let Some(states) = me.values.reals.get_mut(place) {
                states.copy_from_slice(x);
            }
            me.evaluate_again();
            Ok(())
        })
    }

    /// `GetContinuousStates`
    pub fn get_continuous_states(&mut self, x: &mut [f64]) -> Status {
        self.call(Call::GetContinuousStates, |me| {
            me.check_number_of_states(x.len())?;
            me.refresh_initial()?;
            x.copy_from_slice(me.states());
            Ok(())
        })
    }

    /// `GetDerivatives`
    pub fn get_derivatives(&mut self, derivatives: &mut [f64]) -> Status {
        self.call(Call::GetDerivatives, |me| {
            me.check_number_of_states(derivatives.len())?;
            me.refresh_initial()?;
            me.refresh_derivatives()?;
            let place = me.table.layout().derivatives.clone();
            derivatives.copy_from_slice(me.values.reals.get(place).unwrap_or_default());
            Ok(())
        })
    }

    /// `GetNominalsOfContinuousStates`
    pub fn get_nominals(&mut self, nominals: &mut [f64]) -> Status {
        self.call(Call::GetNominals, |me| {
            me.check_number_of_states(nominals.len())?;
            for (nominal, (_, state)) in nominals.iter_mut().zip(me.table.group(Group::State)) {
                *nominal = state.nominal.unwrap_or(1.0);
            }
            Ok(())
        })
    }

    /// `GetEventIndicators`
    pub fn get_event_indicators(&mut self, indicators: &mut [f64]) -> Status {
        self.call(Call::GetEventIndicators, |me| {
            let names = me.table.indicators();
            if indicators.len() != names.len() {
                return Err(Trouble::error(format_args!(
                    "ni = {}, but there are {} event indicators",
                    indicators.len(),
                    names.len()
                )));
            }
            me.refresh_initial()?;
            me.model.indicators(me.run.time_s, &me.values, indicators);
            match names.iter().zip(&*indicators).find(|(_, z)| !z.is_finite()) {
                Some((name, z)) => Err(Trouble::discard(format_args!(
                    "event indicator {name} = {z} is not finite; try a shorter step"
                ))),
                None => Ok(()),
            }
        })
    }

    fn states(&self) -> &[f64] {
        self.values.reals.get(self.table.layout().states.clone()).unwrap_or_default()
    }

    /// Before initialization ends, states follow from parameters and inputs.
    fn refresh_initial(&mut self) -> Result<(), Trouble> {
        if self.run.stale.component | self.run.stale.initial { self.refresh() } else { Ok(()) }
    }

    fn evaluate_again(&mut self) {
        self.run.stale = Stale { outputs: true, derivatives: true, ..self.run.stale };
    }

    fn check_number_of_states(&self, n: usize) -> Result<(), Trouble> {
        let states = self.table.layout().states.len();
        if n == states {
            return Ok(());
        }
        Err(Trouble::error(format_args!("nx = {n}, but there are {states} continuous states")))
    }

    fn which_is_not_finite(&self, x: &[f64]) -> String {
        let states = self.table.group(Group::State).map(|(_, state)| state.name.as_str());
        let bad = states.zip(x).find(|(_, value)| !value.is_finite());
        let (name, value) = bad.map_or(("?", f64::NAN), |(name, value)| (name, *value));
        format!("{name} = {value} is not finite; try a shorter step")
    }
}
