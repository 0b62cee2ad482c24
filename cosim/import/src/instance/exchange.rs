//! Calls of model exchange (FMI 2.0.5, 3.2): time, states, derivatives, events.

use fmu_standard::{Call, Phase};

use super::followed::values;

use super::{Followed, Instance, nothing};
use crate::library::{Component, EventInfo, Exchange, Own};
use crate::status::RawStatus;
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::Time;

/// Iterations of one event after which the FMU is assumed not to settle.
const MAX_ITERATIONS: usize = 1000;

/// The result of an event.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct NextEvent {
    /// The next time event in seconds, if there is one.
    pub time: Option<f64>,
    /// The continuous states have changed discontinuously.
    pub states_changed: bool,
    /// The nominal values of the states have changed.
    pub nominals_changed: bool,
}

impl Instance {
    /// Sets the time in seconds.
    #[inline]
    pub fn set_time(&mut self, time: f64) -> Result<()> {
        // For messages; beyond 146 years the last instant is kept.
        self.time = Time::try_from_seconds(time).unwrap_or(self.time);
        // SAFETY: `c` is alive and the state allows the call.
        self.exchange(
            Call::SetTime,
            |_| format!("{time:?}"),
            |f, c| unsafe { (f.set_time)(c, time) },
        )
    }

    /// Sets the continuous states.
    #[inline]
    pub fn set_states(&mut self, states: &[f64]) -> Result<()> {
        self.length(Call::SetContinuousStates, states.len(), self.fmu.description().states)?;
        self.exchange(
            Call::SetContinuousStates,
            |_| values(states),
            |f, c| {
                // SAFETY: `c` is alive; the array has that length.
                unsafe { (f.set_states)(c, states.as_ptr(), states.len()) }
            },
        )
    }

    /// Reads the continuous states.
    pub fn get_states(&mut self, states: &mut [f64]) -> Result<()> {
        self.length(Call::GetContinuousStates, states.len(), self.fmu.description().states)?;
        self.exchange_get(Call::GetContinuousStates, |f, c| {
            // SAFETY: `c` is alive; the array has that length.
            unsafe { (f.get_states)(c, states.as_mut_ptr(), states.len()) }
        })?;
        self.show(|_| values(states));
        Ok(())
    }

    /// Reads the derivatives of the continuous states.
    #[inline]
    pub fn get_derivatives(&mut self, derivatives: &mut [f64]) -> Result<()> {
        self.length(Call::GetDerivatives, derivatives.len(), self.fmu.description().states)?;
        self.exchange_get(Call::GetDerivatives, |f, c| {
            // SAFETY: `c` is alive; the array has that length.
            unsafe { (f.get_derivatives)(c, derivatives.as_mut_ptr(), derivatives.len()) }
        })?;
        self.show(|_| values(derivatives));
        Ok(())
    }

    /// Reads the nominal values of the continuous states.
    pub fn get_nominals(&mut self, nominals: &mut [f64]) -> Result<()> {
        let function = Call::GetNominals;
        self.length(function, nominals.len(), self.fmu.description().states)?;
        self.exchange_get(function, |f, c| {
            // SAFETY: `c` is alive; the array has that length.
            unsafe { (f.get_nominals)(c, nominals.as_mut_ptr(), nominals.len()) }
        })?;
        self.show(|_| values(nominals));
        Ok(())
    }

    /// Reads the event indicators.
    #[inline]
    pub fn get_indicators(&mut self, indicators: &mut [f64]) -> Result<()> {
        let wanted = self.fmu.description().event_indicators;
        self.length(Call::GetEventIndicators, indicators.len(), wanted)?;
        self.exchange_get(Call::GetEventIndicators, |f, c| {
            // SAFETY: `c` is alive; the array has that length.
            unsafe { (f.get_indicators)(c, indicators.as_mut_ptr(), indicators.len()) }
        })?;
        self.show(|_| values(indicators));
        Ok(())
    }

    /// Notifies the FMU of an accepted step; returns whether it requests a step event.
    pub fn completed_step(&mut self) -> Result<bool> {
        let (mut event, mut terminate) = (0, 0);
        self.exchange_get(Call::CompletedIntegratorStep, |f, c| {
            // SAFETY: `c` is alive; both flags live during the call.
            unsafe { (f.completed_step)(c, 0, &mut event, &mut terminate) }
        })?;
        self.show(|_| format!("event: {}, terminate: {}", event != 0, terminate != 0));
        self.unless_ended(terminate)?;
        Ok(event != 0)
    }

    /// Enters event mode.
    pub fn enter_event_mode(&mut self) -> Result<()> {
        // SAFETY: `c` is alive and the state allows the call.
        self.exchange(Call::EnterEventMode, nothing, |f, c| unsafe { (f.enter_event)(c) })?;
        self.phase = Phase::Event;
        Ok(())
    }

    /// Iterates over the event until nothing changes, and enters continuous-time mode.
    pub fn finish_event(&mut self) -> Result<NextEvent> {
        let mut next = NextEvent::default();
        for _ in 0..MAX_ITERATIONS {
            let mut info = EventInfo::default();
            self.exchange_get(Call::NewDiscreteStates, |f, c| {
                // SAFETY: `c` is alive; `info` lives during the call.
                unsafe { (f.new_discrete)(c, &mut info) }
            })?;
            self.show(|_| format!("{info:?}"));
            self.unless_ended(info.terminate)?;
            next.states_changed |= info.states_changed != 0;
            next.nominals_changed |= info.nominals_changed != 0;
            next.time = (info.next_event_defined != 0).then_some(info.next_event);
            if info.new_discrete_states_needed == 0 {
                let function = Call::EnterContinuousTimeMode;
                self.exchange(function, nothing, |f, c| {
                    // SAFETY: `c` is alive and the state allows the call.
                    unsafe { (f.enter_continuous)(c) }
                })?;
                self.phase = Phase::Continuous;
                return Ok(next);
            }
        }
        Err(Error::new(Code::Fmu, format!("'{}' does not settle at t = {}", self.name, self.time))
            .at(self.fmu.path())
            .why(format!("the event requested {MAX_ITERATIONS} iterations and still more")))
    }

    fn unless_ended(&mut self, terminate: i32) -> Result<()> {
        if terminate == 0 { Ok(()) } else { Err(self.ended("the FMU set terminateSimulation")) }
    }

    #[inline]
    fn exchange(
        &mut self,
        function: Call,
        arguments: impl FnOnce(&Followed) -> String,
        call: impl FnOnce(&Exchange, Component) -> RawStatus,
    ) -> Result<()> {
        let own = self.own_functions(function)?;
        self.call(function, arguments, |_, c| call(&own, c))
    }

    /// A call with results, which `show` formats.
    #[inline]
    fn exchange_get(
        &mut self,
        function: Call,
        call: impl FnOnce(&Exchange, Component) -> RawStatus,
    ) -> Result<()> {
        let own = self.own_functions(function)?;
        self.get(function, nothing, |_, c| call(&own, c))
    }

    #[inline]
    fn own_functions(&self, function: Call) -> Result<Exchange> {
        self.require(function)?;
        match self.own {
            Own::Exchange(own) => Ok(own),
            Own::Stepping(_) => Err(self.refused(function)),
        }
    }

    #[inline]
    fn length(&self, function: Call, found: usize, wanted: usize) -> Result<()> {
        if found == wanted {
            return Ok(());
        }
        Err(Error::new(Code::Fmu, format!("{} of '{}'", function.name(), self.name))
            .why(format!("{found} values were passed, the FMU has {wanted}")))
    }
}
