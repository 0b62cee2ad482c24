//! The results of a filter, compared with those of dual numbers.

use core::ops::Index;

use super::oracle::*;
use super::{Check, TOLERANCE};
use nalgebra::{SMatrix, Vector3};
use num_dual::Dual64;
use proptest::prelude::*;
use rexrov::estimation::NavigationParameters;
use rexrov::estimation::belief::{Belief, Column, Row};
use rexrov::estimation::kalman::Witness;
use rexrov::estimation::kinematics::{Kinematics, Linearized};
use rexrov::estimation::sensor::{Depth, Dvl, Fix, Heading, Observation, Sensor, Tilt};
use rexrov::estimation::transition::Transition;

/// Records the transitions of a prediction.
#[derive(Default)]
pub(super) struct Tape<const N: usize> {
    pub(super) transitions: Vec<SMatrix<f64, N, N>>,
    pub(super) rows: Vec<Row<N>>,
}

impl<const N: usize> Witness<N> for Tape<N> {
    fn predicted(&mut self, f: &Transition<N>) {
        self.transitions.push(f.dense());
    }

    fn updated(&mut self, row: &Row<N>, _: &Column<N>, _: f64, _: f64) {
        self.rows.push(*row);
    }
}

/// Relative to the element, and to a thousandth of the largest in its row, whose rounding it has.
pub(super) fn close_rows<const N: usize>(
    what: &str,
    got: &[impl Index<usize, Output = f64>],
    want: &[[f64; N]],
    order: usize,
) -> Check {
    for (i, (got, want)) in got.iter().zip(want).enumerate() {
        let size = want.iter().fold(0.0_f64, |m, w| m.max(w.abs()));
        for j in 0..order {
            let (g, w) = (got[j], want[j]);
            let bad = format!("{what}: d[{i}]/dx[{j}] = {g}, expected {w}, row up to {size}");
            prop_assert!((g - w).abs() <= TOLERANCE * (w.abs() + 1e-3 * size), "{}", bad);
        }
    }
    Ok(())
}

pub(super) fn close(what: &str, got: &[f64], want: &[f64]) -> Check {
    for (i, (g, w)) in got.iter().zip(want).enumerate() {
        let bad = format!("{what}: [{i}] = {g}, expected {w}");
        prop_assert!((g - w).abs() <= 1e-10 * (1.0 + w.abs()), "{}", bad);
    }
    Ok(())
}

pub(super) fn rows_of<const N: usize>(f: &SMatrix<f64, N, N>) -> Vec<Column<N>> {
    (0..N).map(|i| f.row(i).transpose()).collect()
}

/// A predicted mean: the same numbers and the same rotation.
pub(super) fn close_points<const N: usize>(
    belief: &Belief<N>,
    want: &Point<f64, N>,
    skip: Option<usize>,
) -> Check {
    let got: Vec<f64> =
        (0..N).map(|i| if Some(i) == skip { want.x[i] } else { belief.mean[i] }).collect();
    close("mean", &got, &want.x)?;
    let (a, b) = (matrix(belief.attitude), matrix(want.q));
    close("attitude", &a.concat(), &b.concat())
}

/// Innovations (measured minus predicted, for the value zero) and rows of a sensor.
pub(super) fn close_observation<const N: usize, const M: usize>(
    what: &str,
    got: &Observation<N>,
    order: usize,
    mean: &Point<f64, N>,
    predicted: impl Fn(&Point<Dual64, N>) -> [Dual64; M],
) -> Check {
    prop_assert_eq!(got.size, M);
    let want = mean.rows(&predicted);
    close_rows(what, &got.rows[..M], &want, order)?;
    let lifted = Point { x: lift(mean.x), q: lift(mean.q), theta: mean.theta };
    let values = predicted(&lifted).map(|d: Dual64| d.re);
    let angles = what == "heading" || what == "tilt";
    for (innovation, value) in got.innovation.iter().zip(values) {
        // The value was zero; angles may differ by a turn.
        let sum = innovation + value;
        let turns = if angles { (sum / core::f64::consts::TAU).round() } else { 0.0 };
        let off = sum - turns * core::f64::consts::TAU;
        prop_assert!(off.abs() < 1e-9 * (1.0 + value.abs()), "{what}: {innovation}, {value}");
    }
    Ok(())
}

/// All sensors through the kinematics of a process.
pub(super) fn sensors<const N: usize>(
    p: &NavigationParameters,
    tilt_is_input: bool,
    got: &Kinematics<N>,
    order: usize,
    mean: &Point<f64, N>,
    motion: impl Fn(&Point<Dual64, N>) -> Motion<Dual64>,
) -> Check {
    let (s, m) = (&p.sensors, &p.mounting);
    if !tilt_is_input {
        let seen = Tilt { sigma: s.tilt_sigma }.observe(&[0.0; 3], got);
        close_observation("tilt", &seen, order, mean, |x| motion(x).tilt())?;
    }
    let seen = Heading { sigma: s.heading_sigma }.observe(&[0.0; 3], got);
    close_observation("heading", &seen, order, mean, |x| motion(x).heading())?;
    let seen = Depth { lever: m.pressure.into(), sigma: s.depth_sigma }.observe(&[0.0], got);
    close_observation("depth", &seen, order, mean, |x| motion(x).depth(m.pressure))?;
    let seen = Fix { lever: m.fix.into(), sigma: s.fix_sigma }.observe(&[0.0; 3], got);
    close_observation("fix", &seen, order, mean, |x| motion(x).fix(m.fix))?;
    let seen = Dvl { lever: m.dvl.into(), sigma: s.dvl_sigma }.observe(&[0.0; 3], got);
    close_observation("velocity log", &seen, order, mean, |x| motion(x).dvl(m.dvl))
}

/// The kinematics of a process, and their rows.
pub(super) fn kinematics<const N: usize>(
    got: &Kinematics<N>,
    order: usize,
    mean: &Point<f64, N>,
    motion: impl Fn(&Point<Dual64, N>) -> Motion<Dual64>,
) -> Check {
    let still = motion(&Point { x: lift(mean.x), q: lift(mean.q), theta: mean.theta });
    type Pick = fn(&Motion<Dual64>) -> [Dual64; 3];
    let vector = |what: &str, value: Vector3<f64>, rows: [Row<N>; 3], pick: Pick| {
        close(what, value.as_slice(), &pick(&still).map(|d| d.re))?;
        close_rows(what, &rows, &mean.rows(|x| pick(&motion(x))), order)
    };
    let Kinematics { position, velocity, rate, acceleration, .. } = got;
    vector("position", position.value, rows(position), |m| m.position)?;
    vector("velocity", velocity.value, rows(velocity), |m| m.velocity)?;
    vector("rate", rate.value, rows(rate), |m| m.rate)?;
    vector("acceleration", acceleration.value, rows(acceleration), |m| m.acceleration)?;
    let rotation = still.rotation.map(|row| row.map(|d| d.re));
    close("rotation", got.rotation.transpose().as_slice(), &rotation.concat())?;
    let back = transposed(&still.rotation);
    let turn = mean.rows(|x| {
        let r = matrix_product(&back, &motion(x).rotation);
        [r[2][1], r[0][2], r[1][0]]
    });
    let rows = [0, 1, 2].map(|i| got.through_rotation(&Vector3::ith(i, 1.0)));
    close_rows("turn", &rows, &turn, order)
}

fn rows<const N: usize, const B: usize>(vector: &Linearized<B>) -> [Row<N>; 3] {
    [0, 1, 2].map(|i| {
        let mut row = Row::zeros();
        vector.add_to(&mut row, &Vector3::ith(i, 1.0));
        row
    })
}
