//! One cycle of each filter of the paper.

use super::timer::{repeat, rounds};
use super::{Bar, Row, row};
use anyhow::Result;
use rexrov::estimation::paper::{Acceleration, Ekf, EkfParameters};
use rexrov::estimation::{Measurements, Navigation, Reading};
use rexrov::vehicle::{Parameters, ReducedModel};
use std::hint::black_box;

const TIMES: u32 = 1000;

pub(super) fn measure() -> Result<Vec<Row>> {
    let model = ReducedModel::new(&Parameters::default())?;
    let measurements = Measurements {
        imu: Reading::at(-1.0, [0.0, 0.0, -9.81, 0.0, 0.0, 0.0]),
        ahrs: Reading::at(-1.0, [0.0; 3]),
        dvl: Reading::at(-1.0, [0.3, 0.02, 0.0]),
        fix: Reading::at(-1.0, [0.0; 3]),
        depth: Reading::at(-1.0, [20.0]),
        thrust: Reading::at(-1.0, [0.0; 8]),
    };
    let mut rows = Vec::new();
    for (name, source) in
        [("dynamic", Acceleration::Dynamic(model)), ("kinematic", Acceleration::Kinematic)]
    {
        let ekf = Ekf::new(&EkfParameters::default(), source)?;
        let mut memory = ekf.memory();
        let times = rounds(
            TIMES,
            [&mut repeat(|| {
                black_box(ekf.update(&mut memory, 0.0, black_box(&measurements)));
            })],
        );
        let what = format!("cycle of the paper's {name} filter, all sensors new");
        rows.push(row(what, times.ns(0), "ns", Bar::AtMost(300.0)));
    }
    Ok(rows)
}
