//! A [`Component`] as a [`Model`]: typed structs on one side, flat values on the other.

use crate::author::{Component, Fault, ParameterError, Ports, Resources, Time};

use super::model::Model;
use super::stepper::Stepper;
use super::table::Layout;
use super::values::{Explicit, Values, read, write};

/// A component together with its memory.
pub(crate) struct ComponentModel<C: Component> {
    layout: Layout,
    resources: Resources,
    component: Option<C>,
    memory: C::Memory,
}

impl<C: Component> ComponentModel<C> {
    pub(crate) fn new(layout: Layout, resources: Resources) -> Self {
        const {
            assert!(
                only_reals::<C::Inputs>()
                    && only_reals::<C::Outputs>()
                    && only_reals::<C::States>(),
                "inputs, outputs and states are Real only: use f64 in them"
            );
        }
        Self {
            layout,
            resources,
            component: None,
            memory: C::Memory::default(),
        }
    }

    fn inputs(&self, values: &Values) -> C::Inputs {
        read(&values.reals, &self.layout.inputs)
    }

    fn states(&self, values: &Values) -> C::States {
        read(&values.reals, &self.layout.states)
    }
}

const fn only_reals<P: Ports>() -> bool {
    P::COUNT.only_reals()
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
    ) -> Result<(), ParameterError> {
        let mut selected = Values::of(&C::Parameters::default());
        selected.overlay(values, explicit);
        let mut complete = Values::of(&C::preset(&selected.load()));
        complete.overlay(values, explicit);
        let parameters: C::Parameters = complete.load();
        values.store(&parameters);
        self.component = Some(C::new(&parameters, &self.resources)?);
        Ok(())
    }

    fn initialize(&mut self, start: Time, values: &mut Values) -> Result<(), Fault> {
        let component = self.component.as_ref().ok_or_else(unconfigured)?;
        let (states, memory) = component.initial(start, &self.inputs(values))?;
        write(&states, &mut values.reals, &self.layout.states);
        self.memory = memory;
        Ok(())
    }

    fn outputs(&self, t: f64, values: &mut Values) {
        let Some(component) = &self.component else {
            return;
        };
        let (x, u) = (self.states(values), self.inputs(values));
        let outputs = component.outputs(t, &self.memory, &x, &u);
        write(&outputs, &mut values.reals, &self.layout.outputs);
    }

    fn derivatives(&self, t: f64, values: &mut Values) {
        let Some(component) = &self.component else {
            return;
        };
        let (x, u) = (self.states(values), self.inputs(values));
        let derivatives = component.derivatives(t, &self.memory, &x, &u);
        write(&derivatives, &mut values.reals, &self.layout.derivatives);
    }

    fn next_event(&self) -> Option<Time> {
        self.component
            .as_ref()
            .and_then(|component| component.next_event(&self.memory))
    }

    fn events(&mut self, now: Time, values: &mut Values) -> Result<usize, Fault> {
        let (mut x, u) = (self.states(values), self.inputs(values));
        let component = self.component.as_ref().ok_or_else(unconfigured)?;
        let mut stepper = Stepper {
            component,
            memory: &mut self.memory,
            inputs: &u,
        };
        let mut count = 0;
        while let Some(instant) = component.next_event(stepper.memory).filter(|at| *at <= now) {
            stepper.event(instant, &mut x)?;
            count += 1;
        }
        write(&x, &mut values.reals, &self.layout.states);
        Ok(count)
    }

    fn step(&mut self, t: f64, h: f64, values: &mut Values) -> Result<usize, Fault> {
        let (mut x, u) = (self.states(values), self.inputs(values));
        let component = self.component.as_ref().ok_or_else(unconfigured)?;
        let mut stepper = Stepper {
            component,
            memory: &mut self.memory,
            inputs: &u,
        };
        let events = stepper.advance(&mut x, t, h)?;
        let outputs = component.outputs(t + h, &self.memory, &x, &u);
        write(&x, &mut values.reals, &self.layout.states);
        write(&outputs, &mut values.reals, &self.layout.outputs);
        Ok(events)
    }
}
