//! Butcher tableaux: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.1 (the
//! classical method) and table II.5.2 (Dormand and Prince, 5(4)).

/// The coefficients of an explicit Runge-Kutta method.
#[derive(Debug)]
pub struct Tableau {
    /// Weights of the known stages for each stage after the first.
    pub stages: &'static [&'static [f64]],
    /// Weights of the stages for the result.
    pub result: &'static [f64],
    /// Times of the stages after the first, in parts of the step.
    pub nodes: &'static [f64],
    /// `result` minus the weights of the embedded method; empty without one.
    pub error: &'static [f64],
}

/// The classical method of order 4.
pub const CLASSICAL: Tableau = Tableau {
    stages: &[&[0.5], &[0.0, 0.5], &[0.0, 0.0, 1.0]],
    result: &[1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0],
    nodes: &[0.5, 0.5, 1.0],
    error: &[],
};

/// The pair of Dormand and Prince of orders 5 and 4, RK5(4)7M. Its last stage is at the result, so
/// it is the first one of the next step.
pub const DORMAND_PRINCE: Tableau = Tableau {
    stages: &[
        &[1.0 / 5.0],
        &[3.0 / 40.0, 9.0 / 40.0],
        &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
        &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
        &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
        &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
    ],
    result: &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0, 0.0],
    nodes: &[0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0],
    error: &[
        71.0 / 57600.0,
        0.0,
        -71.0 / 16695.0,
        71.0 / 1920.0,
        -17253.0 / 339_200.0,
        22.0 / 525.0,
        -1.0 / 40.0,
    ],
};
