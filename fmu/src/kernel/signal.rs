//! Inputs during a communication step: they are held, or they follow the polynomial given by their
//! value and their time derivatives at its beginning (`SetRealInputDerivatives`).

use serde::{Deserialize, Serialize};

use crate::author::{Component, Ports, runge_kutta};

use super::values::all_finite;

/// Maximum order of input derivatives.
pub(crate) const ORDERS: usize = 3;

/// Inputs over time.
pub(crate) trait Signal<C: Component> {
    /// Whether they may change within a step.
    const MOVES: bool;

    /// Calls `f` with the inputs at `t`.
    fn with<R>(&self, t: f64, f: impl FnOnce(&C::Inputs) -> R) -> R;

    /// The derivatives of the states along these inputs; the outputs of the same point are passed
    /// if they are known.
    fn derivatives<'a>(
        &'a self,
        component: &'a C,
        memory: &'a C::Memory,
    ) -> impl Fn(f64, &C::States, Option<&C::Outputs>) -> C::States;

    /// The step of the fixed-step method along these inputs.
    fn step<'a>(
        &'a self,
        component: &'a C,
        memory: &'a C::Memory,
    ) -> impl Fn(&mut C::States, f64, f64, Option<&C::Outputs>);
}

/// Constant inputs.
pub(crate) struct Held<U>(pub(crate) U);

impl<C: Component> Signal<C> for Held<C::Inputs> {
    const MOVES: bool = false;

    #[inline]
    fn with<R>(&self, _: f64, f: impl FnOnce(&C::Inputs) -> R) -> R {
        f(&self.0)
    }

    #[inline]
    fn derivatives<'a>(
        &'a self,
        component: &'a C,
        memory: &'a C::Memory,
    ) -> impl Fn(f64, &C::States, Option<&C::Outputs>) -> C::States {
        component.held_derivatives(memory, &self.0)
    }

    #[inline]
    fn step<'a>(
        &'a self,
        component: &'a C,
        memory: &'a C::Memory,
    ) -> impl Fn(&mut C::States, f64, f64, Option<&C::Outputs>) {
        component.held_step(memory, &self.0)
    }
}

/// Inputs that follow polynomials in time.
pub(crate) struct Moving<U> {
    /// Where the polynomials start.
    pub(crate) start_s: f64,
    /// Values there.
    pub(crate) value: U,
    /// Time derivatives there, first order first.
    pub(crate) slopes: [U; ORDERS],
}

impl<U: Ports> Moving<U> {
    pub(crate) fn at(&self, t: f64) -> U {
        let elapsed = t - self.start_s;
        let (mut there, mut factor) = (self.value, 1.0);
        for (order, slope) in (1..).zip(&self.slopes) {
            factor *= elapsed / f64::from(order);
            there.zip_reals(slope, &mut |u, slope| *u += factor * slope);
        }
        there
    }
}

impl<C: Component> Signal<C> for Moving<C::Inputs> {
    const MOVES: bool = true;

    fn with<R>(&self, t: f64, f: impl FnOnce(&C::Inputs) -> R) -> R {
        f(&self.at(t))
    }

    fn derivatives<'a>(
        &'a self,
        component: &'a C,
        memory: &'a C::Memory,
    ) -> impl Fn(f64, &C::States, Option<&C::Outputs>) -> C::States {
        move |t, x, _| component.derivatives(t, memory, x, &self.at(t))
    }

    fn step<'a>(
        &'a self,
        component: &'a C,
        memory: &'a C::Memory,
    ) -> impl Fn(&mut C::States, f64, f64, Option<&C::Outputs>) {
        let f = |t, x: &C::States| component.derivatives(t, memory, x, &self.at(t));
        move |x, t, h, _| runge_kutta(&f, f(t, x), x, t, h)
    }
}

/// What the time derivatives of the inputs apply to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Course {
    /// They are zero.
    #[default]
    Held,
    /// To the next step.
    Ahead,
    /// To the end of the last step; the next one holds its inputs unless they are set again.
    Behind,
}

/// The time derivatives of all inputs of an instance.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Slopes {
    pub(crate) course: Course,
    /// By order, then by input.
    pub(crate) orders: [Box<[f64]>; ORDERS],
}

impl Slopes {
    /// For this number of inputs, all held.
    pub(crate) fn held(inputs: usize) -> Self {
        Self { course: Course::Held, orders: std::array::from_fn(|_| vec![0.0; inputs].into()) }
    }

    /// Whether both have the same number of inputs and are finite.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.orders
            .iter()
            .zip(&other.orders)
            .all(|(own, theirs)| own.len() == theirs.len() && all_finite(own))
    }

    /// Sets one derivative for the next step.
    pub(crate) fn set(&mut self, input: usize, order: usize, value: f64) {
        if self.course != Course::Ahead {
            self.orders.iter_mut().for_each(|slopes| slopes.fill(0.0));
            self.course = Course::Ahead;
        }
        let slopes = order.checked_sub(1).and_then(|index| self.orders.get_mut(index));
        if let Some(place) = slopes.and_then(|slopes| slopes.get_mut(input)) {
            *place = value;
        }
    }

    /// Moves on to the end of a step of `h` seconds.
    pub(crate) fn pass(&mut self, h: f64) {
        if self.course != Course::Ahead {
            self.course = Course::Held;
            return;
        }
        self.course = Course::Behind;
        let [first, second, third] = &mut self.orders;
        for ((first, second), third) in first.iter_mut().zip(second).zip(third) {
            *first += h * (*second + 0.5 * h * *third);
            *second += h * *third;
        }
    }

    /// Copies another's, without allocating if they have the same number.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.course = other.course;
        if other.course != Course::Held {
            for (own, theirs) in self.orders.iter_mut().zip(&other.orders) {
                own.clone_from(theirs);
            }
        }
    }
}
