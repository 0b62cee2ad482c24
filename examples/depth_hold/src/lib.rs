//! A vehicle that holds its depth: `m dw/dt = T - d w` with `T = k (target - z) - c w`, limited.

use fmu_kit::{Component, Info, ParameterError, Resources, Variables};

/// Mass with the water it takes along (kg).
pub const MASS: f64 = 26.0;
/// Linear damping (N.s/m).
pub const DRAG: f64 = 40.0;
/// Gains of depth and of velocity (N/m, N.s/m).
pub const GAIN: [f64; 2] = [100.0, 20.0];

/// What the user chooses before the start.
#[derive(Clone, Variables)]
pub struct Parameters {
    /// Largest thrust, up or down
    #[var(unit = "N", start = 60.0, min = 0.0, tunable)]
    pub limit: f64,
}

/// What comes from other components.
#[derive(Clone, Copy, Variables)]
pub struct Inputs {
    /// Depth to hold
    #[var(unit = "m")]
    pub target: f64,
    /// Whether the thruster works
    #[var(start = true)]
    pub on: bool,
}

/// What other components may want.
#[derive(Clone, Copy, Default, Variables)]
pub struct Outputs {
    /// Depth
    #[var(unit = "m")]
    pub depth: f64,
    /// Whether it asks for more thrust than there is
    pub limited: bool,
}

/// What is integrated.
#[derive(Clone, Copy, Default, Variables)]
pub struct States {
    /// Depth
    #[var(unit = "m")]
    pub z: f64,
    /// Velocity, down
    #[var(unit = "m/s")]
    pub w: f64,
}

/// The vehicle with its controller and thruster.
pub struct DepthHold(Parameters);

impl DepthHold {
    fn demand(&self, x: &States, u: &Inputs) -> f64 {
        let wanted = GAIN[0] * (u.target - x.z) - GAIN[1] * x.w;
        if u.on { wanted } else { 0.0 }
    }
}

impl Component for DepthHold {
    const INFO: Info = Info::new("DepthHold", "Vehicle that holds its depth by a limited thruster");
    const INDICATORS: &'static [&'static str] = &["reserve of thrust"];
    type Parameters = Parameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type States = States;
    type Memory = ();

    fn new(parameters: &Parameters, _: &Resources) -> Result<Self, ParameterError> {
        Ok(Self(parameters.clone()))
    }

    fn derivatives(&self, _: f64, (): &(), x: &States, u: &Inputs) -> States {
        let thrust = self.demand(x, u).clamp(-self.0.limit, self.0.limit);
        States { z: x.w, w: (thrust - DRAG * x.w) / MASS }
    }

    fn outputs(&self, _: f64, (): &(), x: &States, u: &Inputs) -> Outputs {
        Outputs { depth: x.z, limited: self.demand(x, u).abs() > self.0.limit }
    }

    fn indicators(&self, _: f64, (): &(), x: &States, u: &Inputs, reserve: &mut [f64]) {
        reserve.fill(self.0.limit - self.demand(x, u).abs());
    }
}

fmu_kit::export!(DepthHold);
