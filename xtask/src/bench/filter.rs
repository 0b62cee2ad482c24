//! One cycle of each filter of the paper.

use super::{Row, timer};
use anyhow::Result;
use rexrov::estimation::{Acceleration, Ekf, EkfParameters, Measurements};
use rexrov::vehicle::{Parameters, ReducedModel};
use std::hint::black_box;

const CALLS: u32 = 200_000;

pub(super) fn measure() -> Result<Vec<Row>> {
    let model = ReducedModel::new(&Parameters::default())?;
    let mut rows = Vec::new();
    for (name, source) in
        [("dynamic", Acceleration::Dynamic(model)), ("kinematic", Acceleration::Kinematic)]
    {
        let ekf = Ekf::new(&EkfParameters::default(), source)?;
        let mut memory = ekf.memory();
        let mut measurements = Measurements::default();
        measurements.dvl.value.velocity = [0.3, 0.02, 0.0];
        let time = timer::nanoseconds(CALLS, || {
            let _ = black_box(ekf.update(&mut memory, black_box(&measurements)));
        });
        rows.push(Row {
            what: format!("cycle of the {name} filter"),
            value: format!("{time:.0} ns"),
            goal: "at most 3000 ns",
        });
    }
    Ok(rows)
}
