//! The integrators of the co-simulation stepper, and the parameters that choose among them.
//!
//! | method | order | step |
//! |---|---|---|
//! | classical Runge-Kutta | 4 | fixed: an interval is cut into equal steps of at most `step` |
//! | Dormand and Prince (1980) | 5, error estimate of order 4 | adaptive, to `tolerance` |
//!
//! The error of a step is the root mean square of e_i / (tolerance (nominal_i + |x_i|)) over the
//! states (Hairer, Nørsett and Wanner, Solving ODEs I, II.4); a step is accepted up to 1.

use fmu_ode::{DORMAND_PRINCE, RootMeanSquare};

use crate::author::{Info, Ports, add};
use crate::{Enumeration, Variables};

/// How a component's states are integrated in co-simulation
#[derive(Clone, Copy, Debug, Default, PartialEq, Enumeration)]
pub enum IntegratorMethod {
    /// classical Runge-Kutta method of fourth order with fixed step
    #[default]
    RungeKutta4,
    /// Dormand-Prince method of fifth order with adaptive step
    DormandPrince45,
}

/// Parameters the kernel adds to every component with continuous states.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct Integrator {
    /// method
    pub method: IntegratorMethod,
    /// longest step of RungeKutta4, first step tried by DormandPrince45
    #[var(unit = "s", min = 1e-9)]
    pub step: f64,
    /// relative error of a step of DormandPrince45; unless set, fmi2SetupExperiment's counts
    #[var(min = 1e-14, max = 1.0)]
    pub tolerance: f64,
}

impl Integrator {
    /// The default for a component.
    pub(crate) const fn of(info: &Info) -> Self {
        Self {
            method: IntegratorMethod::RungeKutta4,
            step: info.integrator_step_s,
            tolerance: 1e-6,
        }
    }
}

/// One step of Dormand and Prince.
pub(crate) struct Trial<X> {
    /// The states at the end, of fifth order.
    pub(crate) x: X,
    /// Their derivatives, the first stage of the next step.
    pub(crate) slope: X,
    /// Estimate of the error.
    pub(crate) error: X,
}

/// Tries a step from `x`, where the derivatives are `slope`.
pub(crate) fn dormand_prince<X: Ports>(
    f: &impl Fn(f64, &X) -> X,
    x: &X,
    slope: &X,
    t: f64,
    h: f64,
) -> Trial<X> {
    let mut k = [*slope; 7];
    let along = |k: &[X; 7], weights: &[f64]| {
        let mut there = *x;
        for (k, weight) in k.iter().zip(weights) {
            add(&mut there, k, h * weight);
        }
        there
    };
    let mut there = *x;
    let rows = DORMAND_PRINCE.nodes.iter().zip(DORMAND_PRINCE.stages);
    for (stage, (node, weights)) in (1..).zip(rows) {
        there = along(&k, weights);
        if let Some(slope) = k.get_mut(stage) {
            *slope = f(t + node * h, &there);
        }
    }
    let [.., slope] = k;
    let mut error = X::default();
    error.zip_reals(&X::default(), &mut |e, _| *e = 0.0);
    for (k, weight) in k.iter().zip(DORMAND_PRINCE.error) {
        add(&mut error, k, h * weight);
    }
    Trial { x: there, slope, error }
}

/// The error of a step relative to the tolerance; NaN if the step contains NaN.
pub(crate) fn weighed<X: Ports>(x: &X, trial: &Trial<X>, nominal: &X, tolerance: f64) -> f64 {
    let mut scale = *nominal;
    scale.zip_reals(x, &mut |scale, x| *scale = tolerance * (*scale + x.abs()));
    let mut norm = RootMeanSquare::default();
    scale.zip_reals(&trial.error, &mut |scale, error| norm.add(error / *scale));
    norm.value()
}
