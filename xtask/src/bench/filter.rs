//! One cycle of each filter of the paper.

use super::timer::{repeat, rounds};
use super::{Bar, Row, row};
use anyhow::Result;
use rexrov::estimation::{Acceleration, Ekf, EkfParameters, Measurements};
use rexrov::vehicle::{Parameters, ReducedModel};
use std::hint::black_box;

const TIMES: u32 = 1000;

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
        let times = rounds(
            TIMES,
            [&mut repeat(|| {
                let _ = black_box(ekf.update(&mut memory, black_box(&measurements)));
            })],
        );
        let what = format!("cycle of the {name} filter");
        rows.push(row(what, times.ns(0), "ns", Bar::AtMost(3000.0)));
    }
    Ok(rows)
}
