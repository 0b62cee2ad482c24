//! How FMUs for model exchange are integrated.

use clap::Args;
use cosim::Overrides;
use cosim::system::Method;

#[derive(Args)]
pub(crate) struct Solver {
    /// Integrate model exchange with rk4 (one step per communication step) or dopri5 (adaptive; the
    /// default)
    #[arg(long, value_name = "METHOD")]
    solver: Option<Method>,
    /// Relative tolerance of dopri5, also passed to FMUs for co-simulation (default: what each FMU
    /// suggests; for dopri5 1e-6 if none does)
    #[arg(long, value_name = "NUMBER")]
    tolerance: Option<f64>,
}

impl Solver {
    pub(crate) fn add_to(&self, mut overrides: Overrides) -> Overrides {
        if let Some(method) = self.solver {
            overrides = overrides.solver(method);
        }
        match self.tolerance {
            Some(tolerance) => overrides.tolerance(tolerance),
            None => overrides,
        }
    }
}
