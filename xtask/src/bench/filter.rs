//! The cost of the filters: a cycle of the paper's, a prediction with its updates of the others, as
//! the mean over sensors at their usual rates and with an update of every sensor. FilterPy is
//! measured beside them if `FILTERPY_PYTHON` names a Python that has it.

use super::timer::{repeat, rounds};
use super::{Bar, Row, row};
use crate::paths;
use anyhow::{Context, Result, ensure};
use rexrov::allocation::Allocation;
use rexrov::estimation::paper::{Acceleration, Ekf, EkfParameters};
use rexrov::estimation::{
    AidedFilter, ConstantAcceleration, ConstantAccelerationFilter, Disturbances, DynamicFilter,
    InertialFilter, InertialProcess, Measurements, ModelAid, ModelErrors, Navigation,
    NavigationParameters, PlanarDynamic, Reading, UnmonitoredAidedFilter, UnmonitoredDynamicFilter,
};
use rexrov::vehicle::{Parameters, ReducedModel};
use std::{env, ffi::OsString, hint::black_box, process::Command};

const TIMES: u32 = 1000;
/// Inertial and thrust samples a second (Hz).
const RATE_HZ: u32 = 50;
/// Samples in a prediction of 0.1 s.
const CYCLES: u32 = 5;
/// Speed of a vehicle moving north (m/s).
const SPEED: f64 = 0.5;

pub(super) fn measure() -> Result<Vec<Row>> {
    let mut rows = paper()?;
    let p = NavigationParameters::default();
    let (vehicle, d) = (Parameters::default(), Disturbances::default());
    let errors = ModelErrors::default();
    let constant = ConstantAcceleration::new(&p)?;
    let inertial = InertialProcess::new(&p, None)?;
    let planar = PlanarDynamic::new(&p, &vehicle, &d)?;
    let aided = InertialProcess::new(&p, Some(ModelAid::new(&vehicle, &errors)?))?;
    let python = env::var_os("FILTERPY_PYTHON");
    let python = python.as_ref();
    let basic = ConstantAccelerationFilter::new(constant, &p)?;
    rows.extend(navigation("constant-acceleration filter", &basic, Bar::None, None)?);
    let inertial = InertialFilter::new(inertial, &p)?;
    let peer = python.map(|python| (python, Peer::Inertial));
    rows.extend(navigation("inertial filter", &inertial, Bar::AtMost(1.2), peer)?);
    let peer = python.map(|python| (python, Peer::Algebra(16)));
    let alone = UnmonitoredDynamicFilter::new(planar.clone(), &p)?;
    rows.extend(navigation("dynamic filter without monitor", &alone, Bar::AtMost(1.5), peer)?);
    let watched = DynamicFilter::new(planar, &p)?;
    rows.extend(navigation("dynamic filter", &watched, Bar::AtMost(1.5), peer)?);
    let aided = UnmonitoredAidedFilter::new(aided, &p)?;
    let peer = python.map(|python| (python, Peer::Algebra(30)));
    rows.extend(navigation("model-aided filter without watch", &aided, Bar::AtMost(6.0), peer)?);
    let whole = AidedFilter::new(&p, &vehicle, &errors)?;
    rows.extend(navigation("model-aided filter", &whole, Bar::AtMost(6.0), peer)?);
    Ok(rows)
}

/// A cycle of each filter of the paper.
fn paper() -> Result<Vec<Row>> {
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

/// A prediction with its updates: the mean over a second of sensors at their usual rates, with an estimate
/// at each inertial sample; and one of 0.1 s with an update of every sensor, five inertial samples and an
/// estimate. Both beside FilterPy's.
fn navigation(
    name: &str,
    filter: &impl Navigation,
    bar: Bar,
    peer: Option<(&OsString, Peer)>,
) -> Result<Vec<Row>> {
    let mut all = Run::new(filter, |k| [5, 5, 5, 5].map(|every| k % every == 0))?;
    // 50, 10, 7.1 and 1 Hz: only attitudes make predictions of their own.
    let mut usual = Run::new(filter, |k| [1, 5, 7, 50].map(|every| k % every == 0))?;
    let times = rounds(
        20,
        [
            &mut repeat(|| {
                (0..CYCLES).for_each(|_| all.take());
                all.estimate();
            }),
            &mut repeat(|| {
                for _ in 0..RATE_HZ {
                    usual.take();
                    usual.estimate();
                }
            }),
        ],
    );
    let (all, mean) = (times.ns(0) / 1e3, times.ns(1) / 1e3 / f64::from(RATE_HZ));
    let mut rows = vec![
        row(format!("{name}, prediction with its updates"), mean, "us", bar),
        row("  one with an update of every sensor", all, "us", Bar::None),
    ];
    match peer {
        Some((python, Peer::Inertial)) => {
            let ratio = filterpy(python, "usual")? / mean;
            rows.push(row("  FilterPy's over this one", ratio, "", Bar::AtLeast(100.0)));
            let ratio = filterpy(python, "all")? / all;
            rows.push(row("  the same with an update of every sensor", ratio, "", Bar::None));
        }
        Some((python, Peer::Algebra(states))) => {
            let ratio = filterpy(python, &states.to_string())? / all;
            let what = "  FilterPy's algebra alone over the whole of this one";
            rows.push(row(what, ratio, "", Bar::None));
        }
        None => {}
    }
    Ok(rows)
}

/// What is measured in FilterPy beside a filter.
#[derive(Clone, Copy)]
enum Peer {
    /// The inertial filter as a user writes it: the same sensors at the same rates, 16 states.
    Inertial,
    /// Predictions and updates of this many states whose matrices cost nothing.
    Algebra(usize),
}

/// Microseconds of a prediction with its updates in FilterPy; the script explains what of.
fn filterpy(python: &OsString, what: &str) -> Result<f64> {
    let script = paths::root().join("xtask/bench/filterpy_ekf.py");
    let output = Command::new(python).arg(&script).arg(what).output();
    let output = output.with_context(|| format!("cannot start {}", python.display()))?;
    let text = String::from_utf8_lossy(&output.stdout);
    ensure!(output.status.success(), "{}: {text}", script.display());
    let median = text.split_whitespace().rev().nth(1).context("FilterPy's figure is missing")?;
    Ok(median.parse()?)
}

/// A filter in a vehicle moving north.
struct Run<'a, F: Navigation, New> {
    filter: &'a F,
    memory: F::Memory,
    measured: Measurements,
    cycle: u32,
    /// Which of attitude, depth, velocity and fix are new in a cycle.
    new: New,
    thrust: [f64; 8],
}

impl<'a, F: Navigation, New: Fn(u32) -> [bool; 4]> Run<'a, F, New> {
    fn new(filter: &'a F, new: New) -> Result<Self> {
        let vehicle = Parameters::default();
        let model = ReducedModel::new(&vehicle)?;
        // The thrust that keeps the speed.
        let missing = model.acceleration([SPEED, 0.0, 0.0, 0.0], &[0.0; 8]);
        let mass = vehicle.mass_matrix();
        let wrench = [-missing[0] * mass[0][0], 0.0, -missing[2] * mass[2][2], 0.0, 0.0, 0.0];
        let thrust = Allocation::new(&vehicle.propulsion.thrusters)?.forces(&wrench);
        let (memory, measured) = (filter.memory(), Measurements::default());
        Ok(Self { filter, memory, measured, cycle: 0, new, thrust })
    }

    fn take(&mut self) {
        let time = f64::from(self.cycle) / f64::from(RATE_HZ);
        // No value repeats: that would indicate a stuck instrument.
        let noise = f64::from(self.cycle * 37 % 101) / 101.0 - 0.5;
        let [ahrs, depth, dvl, fix] = (self.new)(self.cycle);
        let m = &mut self.measured;
        let (force, rate) = (1e-2 * noise, 1e-3 * noise);
        m.imu = Reading::at(time, [force, -force, force - 9.81, rate, -rate, rate]);
        m.thrust = Reading::at(time, self.thrust);
        if ahrs {
            m.ahrs = Reading::at(time, [0.01 * noise, -0.01 * noise, 0.01 * noise]);
        }
        if depth {
            m.depth = Reading::at(time, [19.15 + 0.3 * noise]);
        }
        if dvl {
            m.dvl = Reading::at(time, [SPEED + 0.01 * noise, 0.01 * noise, -0.01 * noise]);
        }
        if fix {
            m.fix = Reading::at(time, [SPEED * time + 0.5 * noise, 0.5 * noise, 0.0]);
        }
        self.filter.take(&mut self.memory, time, black_box(&self.measured));
        self.cycle += 1;
    }

    fn estimate(&mut self) {
        black_box(self.filter.estimate(&mut self.memory));
    }
}
