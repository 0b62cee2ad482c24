//! Directional derivatives, and the time derivatives of outputs computed from them.
//!
//! dz = (dh/dv) dv for unknowns z and knowns v, by the component's tangent-linear model. Which
//! variables these are depends on the mode (FMI 2.0.4, section 2.1.9):
//!
//! | mode | unknowns | knowns |
//! |---|---|---|
//! | initialization | outputs, states, derivatives | inputs, Real parameters, time |
//! | any later | outputs, derivatives | inputs, states, time |
//!
//! Parameters are fixed, so they are knowns only as long as they can be set. A tangent-linear model
//! does not depend explicitly on time, so the derivatives with respect to time are zero.

use fmu_standard::{Basic, Call, Phase, Status};

use super::instance::Instance;
use super::model::Outputs;
use super::signal::Course;
use super::status::Trouble;
use super::table::Group;
use super::values::{all_finite, gather};

// The first of the unknowns are those that solvers request alone.
const UNKNOWNS: [Group; 2] = [Group::Derivative, Group::Output];
const KNOWNS: [Group; 3] = [Group::State, Group::Input, Group::Time];
const UNKNOWNS_AT_START: [Group; 3] = [Group::Derivative, Group::Output, Group::State];
const KNOWNS_AT_START: [Group; 3] = [Group::Input, Group::Parameter, Group::Time];

impl Instance {
    /// `GetDirectionalDerivative`
    pub fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        along: &[f64],
        into: &mut [f64],
    ) -> Status {
        self.call(Call::GetDirectionalDerivative, |me| {
            if !me.table.has_tangent() {
                return Err(Trouble::error(
                    "not supported, as modelDescription.xml says: \
                     providesDirectionalDerivative = false",
                ));
            }
            let starts = me.run.phase == Phase::Initialization;
            let mut outputs = Outputs::Wanted;
            if starts {
                me.check_groups("unknown", unknowns, &UNKNOWNS_AT_START)?;
                me.check_groups("known", knowns, &KNOWNS_AT_START)?;
                me.refresh()?;
            } else {
                if me.check_groups("unknown", unknowns, &UNKNOWNS)? == 1 {
                    outputs = Outputs::Unread;
                }
                me.check_groups("known", knowns, &KNOWNS)?;
            }
            if !all_finite(along) {
                return Err(Trouble::error("an element of dvKnown is not finite"));
            }
            me.still();
            for (known, along) in knowns.iter().zip(along) {
                if let Some(change) = me.changes.get_mut(*known as usize) {
                    *change += along;
                }
            }
            if starts {
                me.model.initial_tangent(me.run.time_s, &me.values, &mut me.changes);
            } else {
                me.model.tangent(me.run.time_s, &me.values, outputs, &mut me.changes);
            }
            me.read_changes(unknowns, into)
        })
    }

    /// `GetRealOutputDerivatives`: of order 1, if there is a tangent-linear model.
    pub fn output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        into: &mut [f64],
    ) -> Status {
        self.call(Call::GetRealOutputDerivatives, |me| {
            me.check_groups("output", references, &[Group::Output])?;
            let highest = i32::from(me.table.has_tangent());
            if let Some(order) = orders.iter().find(|order| !(1..=highest).contains(*order)) {
                return Err(Trouble::error(format_args!(
                    "order = {order}, but modelDescription.xml says: maxOutputDerivativeOrder = \
                     {highest}"
                )));
            }
            if references.is_empty() {
                return Ok(());
            }
            me.refresh_derivatives()?;
            me.still();
            let layout = me.table.layout();
            let rates = me.values.reals.get(layout.derivatives.clone());
            if let (Some(dx), Some(rates)) = (me.changes.get_mut(layout.states.clone()), rates) {
                dx.copy_from_slice(rates);
            }
            // At the end of a step the inputs still change as they did within it.
            if let (Course::Behind, Some(du)) =
                (me.slopes.course, me.changes.get_mut(layout.inputs.clone()))
            {
                du.copy_from_slice(&me.slopes.orders[0]);
            }
            me.model.tangent(me.run.time_s, &me.values, Outputs::Wanted, &mut me.changes);
            me.read_changes(references, into)
        })
    }

    /// How many are Reals of a group; counted without a branch, several at a time.
    #[inline]
    fn count(&self, references: &[u32], group: Group) -> u32 {
        let layout = self.table.layout();
        let place = match group {
            Group::Input => layout.inputs.clone(),
            Group::Output => layout.outputs.clone(),
            Group::State => layout.states.clone(),
            Group::Derivative => layout.derivatives.clone(),
            Group::Parameter => 0..layout.parameters.reals,
            Group::Time => layout.time..layout.time + 1,
        };
        let (start, n) = (place.start as u32, place.len() as u32);
        references.iter().map(|reference| u32::from(reference.wrapping_sub(start) < n)).sum()
    }

    /// Checks that all are Reals of the groups that count as `what` now; returns how many of these
    /// groups, from the first, contain them all. No Real is in two groups, so the counts add up.
    #[inline]
    fn check_groups(
        &self,
        what: &str,
        references: &[u32],
        groups: &[Group],
    ) -> Result<usize, Trouble> {
        let mut found = 0;
        for (looked_at, group) in (1..).zip(groups) {
            found += self.count(references, *group) as usize;
            if found == references.len() {
                return Ok(looked_at);
            }
        }
        Err(self.wrong_group(what, references, groups))
    }

    #[cold]
    fn wrong_group(&self, what: &str, references: &[u32], groups: &[Group]) -> Trouble {
        let is_right = |reference| groups.iter().any(|g| self.count(&[reference], *g) > 0);
        let wrong = references.iter().copied().find(|reference| !is_right(*reference));
        let (words, reference) = (self.run.phase.words(), wrong.unwrap_or_default());
        let right: Vec<&str> = groups.iter().map(|group| group.words()).collect();
        let right = right.join(", ");
        match self.table.find(Basic::Real, reference) {
            Some(variable) => Trouble::error(format_args!(
                "{} cannot be the {what} {words}: it is of the {}; possible are {right}",
                variable.name,
                variable.group.words()
            )),
            None => Trouble::error(format_args!(
                "no Real has value reference {reference}, named as the {what}; possible are {right}"
            )),
        }
    }

    /// No change of anything that a tangent-linear model reads.
    fn still(&mut self) {
        if self.changes.len() != self.values.reals.len() {
            self.changes = vec![0.0; self.values.reals.len()].into();
        }
        let layout = self.table.layout();
        let parameters = 0..layout.parameters.reals;
        let moving = if self.run.phase == Phase::Initialization { parameters } else { 0..0 };
        for place in [&moving, &layout.inputs, &layout.states] {
            if let Some(changes) = self.changes.get_mut(place.clone()) {
                changes.fill(0.0);
            }
        }
    }

    fn read_changes(&self, references: &[u32], into: &mut [f64]) -> Result<(), Trouble> {
        // All of them exist, because their groups were checked.
        match gather(&self.changes, references, into) {
            Some(()) if all_finite(into) => Ok(()),
            _ => Err(self.doubtful("a derivative is not finite")),
        }
    }
}
