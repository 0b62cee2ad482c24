//! A [`Component`] as a [`Model`]: typed structs on one side, flat values on the other.

use crate::author::{Component, Fault, ParameterError, Reader, Resources, Time, Variables};

use super::integrator::Integrator;
use super::memory::SPREAD;
use super::model::{Cause, Events, Halt, Memory, Model, Outputs};
use super::parameters::Parameters;
use super::shape;
use super::signal::{Held, Moving, Signal, Slopes};
use super::stepper::{MOST_WORK, Progress, Scheme, Stepper};
use super::table::{Group, Layout, Table};
use super::values::{
    Explicit, Values, accumulate, first_not_finite, is_finite, read, read_ports, write, write_ports,
};

/// A component together with everything that changes.
pub(crate) struct ComponentModel<C: Component> {
    layout: Layout,
    resources: Resources,
    component: Option<C>,
    scheme: Scheme<C::States>,
    progress: Progress<C::Memory>,
}

impl<C: Component> ComponentModel<C> {
    pub(crate) fn new(table: &Table, resources: Resources) -> Self {
        const {
            assert!(C::States::COUNT.only_reals(), "states are Real only: use f64 in them");
            assert!(C::INDICATORS.len() <= 64, "there can be no more than 64 event indicators");
        }
        let states = table.group(Group::State);
        let nominals: Vec<f64> = states.map(|(_, state)| state.nominal.unwrap_or(1.0)).collect();
        Self {
            layout: table.layout().clone(),
            resources,
            component: None,
            scheme: Scheme {
                integrator: Integrator::of(&C::INFO),
                nominal: C::States::load(&mut Reader { reals: &nominals, ..Reader::default() }),
            },
            progress: Progress::default(),
        }
    }

    fn inputs(&self, values: &Values) -> C::Inputs {
        read_ports(values, &self.layout.inputs, self.layout.before[0])
    }

    fn states(&self, values: &Values) -> C::States {
        read(&values.reals, &self.layout.states)
    }

    /// A step along a signal.
    #[inline(always)]
    fn advance(
        &mut self,
        t: f64,
        h: f64,
        signal: &impl Signal<C>,
        fresh: bool,
        values: &mut Values,
    ) -> Result<usize, Halt> {
        let Some(component) = &self.component else {
            return Err(Halt::new(t, unconfigured()));
        };
        let mut x = self.states(values);
        let mut stepper = Stepper {
            component,
            scheme: &self.scheme,
            progress: &mut self.progress,
            signal,
            known: values
                .reals
                .get(self.layout.outputs.clone())
                .filter(|_| fresh && const { C::Outputs::COUNT.only_reals() }),
            work: MOST_WORK,
        };
        let events = match stepper.advance(&mut x, t, h) {
            Ok(events) => events,
            Err(halt) => {
                let halt = halt.in_table(self.layout.states.start);
                return Err(self.halted(halt, &x, signal, values));
            }
        };
        let memory = &self.progress.memory;
        let outputs = signal.with(t + h, |u| component.outputs(t + h, memory, &x, u));
        if !(is_finite(&x) & is_finite(&outputs)) {
            return Err(self.not_finite(t, &x, &outputs, signal, values));
        }
        write(&x, &mut values.reals, &self.layout.states);
        write_outputs::<C>(&outputs, values, &self.layout);
        Ok(events)
    }

    /// The step from `t` led to these states and outputs; the values are still those before it.
    #[cold]
    #[inline(never)]
    fn not_finite(
        &self,
        t: f64,
        x: &C::States,
        outputs: &C::Outputs,
        signal: &impl Signal<C>,
        values: &mut Values,
    ) -> Halt {
        let reference = match first_not_finite(outputs) {
            Some(output) => self.layout.outputs.start + output,
            None => self.layout.states.start + first_not_finite(x).unwrap_or_default(),
        };
        let halt = Halt { reached_s: t, cause: Cause::NotFinite(reference) };
        self.halted(halt, &self.states(values), signal, values)
    }

    /// Leaves the values at the end of the step.
    #[cold]
    #[inline(never)]
    fn halted(
        &self,
        halt: Halt,
        x: &C::States,
        signal: &impl Signal<C>,
        values: &mut Values,
    ) -> Halt {
        let (t, memory) = (halt.reached_s, &self.progress.memory);
        write(x, &mut values.reals, &self.layout.states);
        if let Some(component) = &self.component {
            let outputs = signal.with(t, |u| component.outputs(t, memory, x, u));
            if is_finite(&outputs) {
                write_outputs::<C>(&outputs, values, &self.layout);
            }
        }
        halt
    }

    #[inline(never)]
    fn step_moving(
        &mut self,
        t: f64,
        h: f64,
        slopes: &Slopes,
        values: &mut Values,
    ) -> Result<usize, Halt> {
        let signal = Moving {
            start_s: t,
            value: self.inputs(values),
            slopes: slopes.orders.each_ref().map(|slopes| read(slopes, &(0..slopes.len()))),
        };
        let done = self.advance(t, h, &signal, false, values);
        let end = done.as_ref().map_or_else(|halt| halt.reached_s, |_| t + h);
        write_ports(&signal.at(end), values, &self.layout.inputs, self.layout.before[0]);
        done
    }

    /// Works with the stepper at the present values, with inputs held.
    fn stepping<R>(
        &mut self,
        values: &Values,
        work: impl FnOnce(&mut Stepper<'_, C, Held<C::Inputs>>, &mut C::States) -> R,
    ) -> Result<(R, C::States), Fault> {
        let (mut x, u) = (self.states(values), self.inputs(values));
        let mut stepper = Stepper {
            component: self.component.as_ref().ok_or_else(unconfigured)?,
            scheme: &self.scheme,
            progress: &mut self.progress,
            signal: &Held(u),
            known: None,
            work: MOST_WORK,
        };
        let done = work(&mut stepper, &mut x);
        Ok((done, x))
    }
}

#[inline(always)]
fn write_outputs<C: Component>(outputs: &C::Outputs, values: &mut Values, layout: &Layout) {
    write_ports(outputs, values, &layout.outputs, layout.before[1]);
}

/// An instance configures its model before anything else, so this is never seen.
fn unconfigured() -> Fault {
    Fault::new("the component was used before its parameters were checked")
}

impl<C: Component> Model for ComponentModel<C> {
    fn configure(
        &mut self,
        values: &mut Values,
        explicit: &Explicit,
        tolerance: Option<f64>,
    ) -> Result<(), ParameterError> {
        let mut selected = Values::of(&Parameters::<C>::with(C::Parameters::default()));
        selected.overlay(values, explicit);
        let selected: Parameters<C> = selected.load();
        let mut preset = Parameters::<C>::with(C::preset(&selected.author));
        if let Some(tolerance) = tolerance {
            // Within the bounds of the parameter: some importers pass 0.
            preset.integrator.tolerance = tolerance.max(1e-14);
        }
        let mut complete = Values::of(&preset);
        complete.overlay(values, explicit);
        let parameters: Parameters<C> = complete.load();
        values.store(&parameters);
        self.scheme.integrator = parameters.integrator;
        self.component = Some(C::new(&parameters.author, &self.resources)?);
        Ok(())
    }

    fn initialize(&mut self, start: Time, values: &mut Values) -> Result<(), Fault> {
        let component = self.component.as_ref().ok_or_else(unconfigured)?;
        let (states, memory) = component.initial(start, &self.inputs(values))?;
        write(&states, &mut values.reals, &self.layout.states);
        self.progress = Progress { memory, proposed_s: 0.0, signs: 0 };
        if !C::INDICATORS.is_empty() {
            let t = start.seconds();
            let (signs, _) = self.stepping(values, |stepper, x| stepper.signs(x, t))?;
            self.progress.signs = signs;
        }
        Ok(())
    }

    fn outputs(&self, t: f64, values: &mut Values) {
        let Some(component) = &self.component else {
            return;
        };
        let (x, u) = (self.states(values), self.inputs(values));
        let outputs = component.outputs(t, &self.progress.memory, &x, &u);
        write_outputs::<C>(&outputs, values, &self.layout);
    }

    fn derivatives(&self, t: f64, values: &mut Values) {
        let Some(component) = &self.component else {
            return;
        };
        let (x, u) = (self.states(values), self.inputs(values));
        let derivatives = component.derivatives(t, &self.progress.memory, &x, &u);
        write(&derivatives, &mut values.reals, &self.layout.derivatives);
    }

    fn indicators(&self, t: f64, values: &Values, into: &mut [f64]) {
        if let Some(component) = &self.component {
            let (x, u) = (self.states(values), self.inputs(values));
            component.indicators(t, &self.progress.memory, &x, &u, into);
        }
    }

    fn tangent(&self, t: f64, values: &Values, wanted: Outputs, changes: &mut [f64]) -> bool {
        let Some(component) = self.component.as_ref().filter(|_| C::TANGENT) else {
            return false;
        };
        let (x, u) = (self.states(values), self.inputs(values));
        let dx = read(changes, &self.layout.states);
        let du = read(changes, &self.layout.inputs);
        let tangent = || component.tangent(t, &self.progress.memory, &x, &u, &dx, &du);
        // Two calls, so that the compiler omits from the first what only the outputs need.
        match wanted {
            Outputs::Unread => write(&tangent().0, changes, &self.layout.derivatives),
            Outputs::Wanted => {
                let (derivatives, outputs) = tangent();
                write(&derivatives, changes, &self.layout.derivatives);
                write(&outputs, changes, &self.layout.outputs);
            }
        }
        true
    }

    fn initial_tangent(&self, t: f64, values: &Values, changes: &mut [f64]) -> bool {
        let Some(component) = self.component.as_ref().filter(|_| C::TANGENT) else {
            return false;
        };
        let (x, u) = (self.states(values), self.inputs(values));
        let parameters: Parameters<C> = values.load();
        let along: Parameters<C> = Values { reals: changes.into(), ..values.clone() }.load();
        let du = read(changes, &self.layout.inputs);
        let (dx, derivatives, outputs) =
            component.initial_tangent(&x, &u, &parameters.author, &along.author, &du);
        write(&dx, changes, &self.layout.states);
        self.tangent(t, values, Outputs::Wanted, changes);
        accumulate(&derivatives, changes, &self.layout.derivatives);
        accumulate(&outputs, changes, &self.layout.outputs);
        true
    }

    fn next_event(&self) -> Option<Time> {
        self.component.as_ref().and_then(|component| component.next_event(&self.progress.memory))
    }

    fn events(&mut self, t: f64, values: &mut Values) -> Result<Events, Fault> {
        let now = Time::from_seconds(t);
        let (done, x) = self.stepping(values, |stepper, x| {
            let mut events = Events::default();
            while let Some(instant) = stepper.next_event().filter(|at| *at <= now) {
                if events.time_events == MOST_WORK as usize {
                    return Err(Fault::new(format_args!(
                        "more than {MOST_WORK} time events are due, the next one since {instant}; \
                         set the time to nextEventTime at the latest"
                    )));
                }
                stepper.time_event(instant, x)?;
                events.time_events += 1;
            }
            events.changed = stepper.state_event(t, x)?;
            Ok(events)
        })?;
        let events = done?;
        write(&x, &mut values.reals, &self.layout.states);
        Ok(events)
    }

    fn step(
        &mut self,
        t: f64,
        h: f64,
        slopes: Option<&Slopes>,
        fresh: bool,
        values: &mut Values,
    ) -> Result<usize, Halt> {
        match slopes {
            None => self.advance(t, h, &Held(self.inputs(values)), fresh, values),
            Some(slopes) => self.step_moving(t, h, slopes, values),
        }
    }

    fn notice(&mut self) -> Option<String> {
        C::notice(&mut self.progress.memory)
    }

    fn save(&self, into: &mut Option<Memory>) {
        match into.as_mut().and_then(|memory| memory.downcast_mut::<Progress<C::Memory>>()) {
            Some(place) => place.clone_from(&self.progress),
            None => *into = Some(Box::new(self.progress.clone())),
        }
    }

    fn restore(&mut self, from: &Memory) -> bool {
        let saved = from.downcast_ref::<Progress<C::Memory>>();
        saved.map(|saved| self.progress.clone_from(saved)).is_some()
    }

    fn size(&self) -> usize {
        let bytes = postcard::experimental::serialized_size(&self.progress).unwrap_or_default();
        C::ROOM + SPREAD * bytes
    }

    fn pack(&self, memory: &Memory) -> Result<Vec<u8>, String> {
        let progress = memory
            .downcast_ref::<Progress<C::Memory>>()
            .ok_or("the state is another component's")?;
        let bytes = shape::fingerprint(&C::Memory::default())?.to_vec();
        postcard::to_extend(progress, bytes).map_err(|cause| cause.to_string())
    }

    fn unpack(&self, bytes: &[u8]) -> Result<Memory, String> {
        let expected = shape::fingerprint(&C::Memory::default())?;
        let bytes = bytes
            .strip_prefix(&expected)
            .ok_or("it has another shape in the version of the library that saved it")?;
        match postcard::take_from_bytes::<Progress<C::Memory>>(bytes) {
            Ok((progress, [])) => Ok(Box::new(progress)),
            Ok((_, rest)) => Err(format!("{} bytes too many", rest.len())),
            Err(cause) => Err(cause.to_string()),
        }
    }
}
