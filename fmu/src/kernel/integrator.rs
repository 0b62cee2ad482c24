//! The integrators of the co-simulation stepper, and the parameters that choose among them.
//!
//! | method | order | step |
//! |---|---|---|
//! | classical Runge-Kutta | 4 | fixed: an interval is cut into equal steps of at most `step` |
//! | Dormand and Prince (1980) | 5, error estimate of order 4 | adaptive, to `tolerance` |
//!
//! The error of a step is the root mean square of e_i / (tolerance (nominal_i + |x_i|)) over the
//! states (Hairer, Nørsett and Wanner, Solving ODEs I, II.4); a step is accepted up to 1.

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

/// Nodes, weights of the stages, and the difference of the two embedded results (RK5(4)7M).
const NODES: [f64; 5] = [0.2, 0.3, 0.8, 8.0 / 9.0, 1.0];
const STAGES: [&[f64]; 5] = [
    &[0.2],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
    &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
];
const RESULT: [f64; 6] =
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0];
const ERROR: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

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
    for (stage, (node, weights)) in (1..).zip(NODES.iter().zip(STAGES)) {
        let there = along(&k, weights);
        if let Some(slope) = k.get_mut(stage) {
            *slope = f(t + node * h, &there);
        }
    }
    let there = along(&k, &RESULT);
    let slope = f(t + h, &there);
    if let Some(last) = k.last_mut() {
        *last = slope;
    }
    let mut error = X::default();
    error.zip_reals(&X::default(), &mut |e, _| *e = 0.0);
    for (k, weight) in k.iter().zip(ERROR) {
        add(&mut error, k, h * weight);
    }
    Trial { x: there, slope, error }
}

/// The error of a step relative to the tolerance; NaN if the step contains NaN.
pub(crate) fn weighed<X: Ports>(x: &X, trial: &Trial<X>, nominal: &X, tolerance: f64) -> f64 {
    let mut scale = *nominal;
    scale.zip_reals(x, &mut |scale, x| *scale = tolerance * (*scale + x.abs()));
    let mut squares = 0.0;
    scale.zip_reals(&trial.error, &mut |scale, error| {
        squares += (error / *scale) * (error / *scale);
    });
    (squares / X::COUNT.reals.max(1) as f64).sqrt()
}

/// The factor by which to change the step after this error; the exponent is the estimate's order.
pub(crate) fn step_factor(error: f64) -> f64 {
    if error == 0.0 {
        return 5.0;
    }
    // An error that is NaN requires the smallest step.
    let factor = 0.9 * libm::pow(error, -0.2);
    if factor.is_nan() { 0.2 } else { factor.clamp(0.2, 5.0) }
}
