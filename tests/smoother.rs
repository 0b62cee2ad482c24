//! The smoother compared with the batch solution, and its improvement over the filters.

use crate::mission::*;
use crate::scoring::*;
use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, SVector};
use rexrov::estimation::belief::{Belief, Column};
use rexrov::estimation::interval::Interval;
use rexrov::estimation::kalman::Witness;
use rexrov::estimation::kinematics::{Block, Kinematics, Linearized, Motion, SensorStates};
use rexrov::estimation::process::Process;
use rexrov::estimation::transition::Transition;
use rexrov::estimation::{
    Filter, Measurements, Mounting, NavigationParameters, Reading, Recording, SensorErrors,
    Smoothed, Smoothing,
};
use rexrov::guidance::Course;
use rexrov::sensors::Gaussian;

/// Position and velocity along the axes of the world, with white acceleration on the velocity.
struct Linear;

const DENSITY: f64 = 0.3;
const SIGMAS: [f64; 6] = [5.0, 5.0, 5.0, 2.0, 2.0, 2.0];

impl Process<6> for Linear {
    fn initial(&self) -> Belief<6> {
        let sigma = Column::from(SIGMAS);
        Belief::new(6, Column::zeros(), &sigma, [1.0, 0.0, 0.0, 0.0])
    }

    fn predict(&self, belief: &mut Belief<6>, interval: &Interval, witness: &mut impl Witness<6>) {
        let mut f = Transition::identity();
        (0..3).for_each(|i| f.set_row(i, [(i, 1.0), (3 + i, interval.dt)]));
        belief.mean = f.apply(&belief.mean);
        belief.propagate(&f);
        (3..6).for_each(|i| belief.add_noise(i, DENSITY * DENSITY * interval.dt));
        witness.predicted(&f);
    }

    fn kinematics(&self, belief: &Belief<6>, _: &Interval) -> Kinematics<6> {
        let part = |from: usize| {
            let mut part = Linearized::constant(belief.mean.fixed_rows::<3>(from).into_owned());
            part.set_block(from, &Matrix3::identity());
            part
        };
        Kinematics {
            position: part(0),
            rotation: Matrix3::identity(),
            turn: Block::default(),
            velocity: part(3),
            rate: Linearized::constant(nalgebra::Vector3::zeros()),
            rate_variance: 0.0,
            tracking_variance: 0.0,
            acceleration: Linearized::constant(nalgebra::Vector3::zeros()),
            sensors: SensorStates::default(),
            mean: belief.mean,
        }
    }

    fn motion(&self, belief: &Belief<6>, _: &Interval) -> Motion {
        Motion {
            position: belief.mean.fixed_rows::<3>(0).into_owned(),
            rotation: Matrix3::identity(),
            velocity: belief.mean.fixed_rows::<3>(3).into_owned(),
            rate: nalgebra::Vector3::zeros(),
            acceleration: nalgebra::Vector3::zeros(),
        }
    }

    fn correct(&self, belief: &mut Belief<6>, correction: &Column<6>) {
        belief.mean += correction;
    }

    fn align(&self, _: &mut Belief<6>, _: [f64; 3]) {}

    fn velocity(&self) -> usize {
        3
    }
}

/// A component of a measurement: time, state, value, and variance.
struct Point {
    time: f64,
    state: usize,
    value: f64,
    variance: f64,
}

/// Samples that arrive up to 2 s late, in no order.
fn measure(s: &SensorErrors, recording: &mut Recording) -> Vec<Point> {
    let (mut points, mut noise) = (Vec::new(), Gaussian::new(7, 1_u64));
    let mut arrivals = Vec::new();
    for i in 0..12 {
        let time = f64::from(i) * 0.37;
        arrivals.push((time + (1.3 * f64::from(i * i)) % 2.0, time, i % 3));
    }
    arrivals.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut measured = Measurements::default();
    for (now, time, kind) in arrivals {
        let value: [f64; 3] = core::array::from_fn(|_| 3.0 * noise.draw());
        let mut note = |state: usize, value: f64, sigma: f64| {
            points.push(Point { time, state, value, variance: sigma * sigma });
        };
        match kind {
            0 => {
                measured.fix = Reading::at(time, [value[0], value[1], 0.0]);
                (0..2).for_each(|i| note(i, value[i], s.fix_sigma));
            }
            1 => {
                measured.dvl = Reading::at(time, value);
                (0..3).for_each(|i| note(3 + i, value[i], s.dvl_sigma));
            }
            _ => {
                measured.depth = Reading::at(time, [value[2]]);
                note(2, value[2], s.depth_sigma);
            }
        }
        recording.add(now, &measured);
    }
    points
}

/// Mean and covariance of all states at `times`, given all points: one linear system for everything.
fn batch(times: &[f64], points: &[Point]) -> (DVector<f64>, DMatrix<f64>) {
    let n = times.len();
    let mut joint = DMatrix::zeros(6 * n, 6 * n);
    let sigma = SVector::<f64, 6>::from(SIGMAS);
    let mut own = SMatrix::<f64, 6, 6>::from_diagonal(&sigma.component_mul(&sigma));
    for k in 0..n {
        if k > 0 {
            let dt = times[k] - times[k - 1];
            let mut f = SMatrix::<f64, 6, 6>::identity();
            (0..3).for_each(|i| f[(i, 3 + i)] = dt);
            own = f * own * f.transpose();
            (3..6).for_each(|i| own[(i, i)] += DENSITY * DENSITY * dt);
            let row = f * joint.view((6 * (k - 1), 0), (6, 6 * k));
            joint.view_mut((6 * k, 0), (6, 6 * k)).copy_from(&row);
            joint.view_mut((0, 6 * k), (6 * k, 6)).copy_from(&row.transpose());
        }
        joint.view_mut((6 * k, 6 * k), (6, 6)).copy_from(&own);
    }
    let place = |p: &Point| 6 * times.iter().position(|t| *t == p.time).unwrap() + p.state;
    let h =
        DMatrix::from_fn(points.len(), 6 * n, |i, j| f64::from(u8::from(place(&points[i]) == j)));
    let r = DVector::from_iterator(points.len(), points.iter().map(|p| p.variance));
    let y = DVector::from_iterator(points.len(), points.iter().map(|p| p.value));
    let s = &h * &joint * h.transpose() + DMatrix::from_diagonal(&r);
    let gain = &joint * h.transpose() * s.try_inverse().unwrap();
    (&gain * y, &joint - &gain * &h * &joint)
}

#[test]
fn smoothing_is_the_batch_solution_of_a_linear_problem() {
    let mut p = NavigationParameters { gated: false, ..NavigationParameters::default() };
    let zero = [0.0; 3];
    p.mounting = Mounting { imu: zero, dvl: zero, fix: zero, pressure: zero };
    let filter = Filter::<_, 6>::new(Linear, &p).unwrap();
    let mut recording = filter.recording();
    let points = measure(&p.sensors, &mut recording);
    let path = filter.smooth(&recording);
    let mut times: Vec<f64> = path.iter().map(|s| s.time).collect();
    times.extend(points.iter().map(|p| p.time).filter(|t| !path.iter().any(|s| near(s, *t))));
    times.sort_by(f64::total_cmp);
    times.dedup();
    let (mean, covariance) = batch(&times, &points);
    assert_eq!(path.len(), 41);
    for Smoothed { time, estimate: s } in &path {
        let k = 6 * times.iter().position(|t| *t == *time).unwrap();
        for i in 0..3 {
            let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{time} s: {a} {b}");
            close(s.position[i], mean[k + i]);
            close(s.velocity[i], mean[k + 3 + i]);
            close(s.velocity_sigma[i].powi(2), covariance[(k + 3 + i, k + 3 + i)]);
            (0..3).for_each(|j| close(s.covariance[i][j], covariance[(k + i, k + j)]));
        }
    }
}

fn near(s: &Smoothed, time: f64) -> bool {
    (s.time - time).abs() < 1e-9 && s.time != time
}

const SEEDS: core::ops::Range<u64> = 100..120;

/// Filter and smoother over the same missions; only their assumptions are wrong.
fn compare(which: Which, change: impl Fn(&mut Mission) + Sync) -> Vec<(Run, Run)> {
    parallel(SEEDS, |seed| {
        let options = Options::nominal(Course::BE3, seed);
        let mut mission = fly(&options);
        change(&mut mission);
        let unbiased = |p: &mut NavigationParameters| p.sensors.heading_bias_sigma = 0.0;
        (run(which, &options, &mission, unbiased), smooth(which, &options, &mission, unbiased))
    })
}

/// By how much the median of the errors is smaller.
fn gain(runs: &[(Run, Run)], error: impl Fn(&Run) -> f64) -> f64 {
    let median = |errors: Vec<f64>| quantile(&errors, 0.5);
    let filtered = median(runs.iter().map(|(filtered, _)| error(filtered)).collect());
    1.0 - median(runs.iter().map(|(_, smoothed)| error(smoothed)).collect()) / filtered
}

/// Mean over the runs of the smoother's score from 30 s on.
fn consistency(runs: &[(Run, Run)], score: fn(&Sample) -> f64) -> f64 {
    runs.iter().map(|(_, smoothed)| smoothed.mean(30.0, f64::MAX, score)).sum::<f64>()
        / runs.len() as f64
}

#[test]
fn with_all_sensors_the_error_is_halved_and_its_covariance_true() {
    let runs = compare(Which::Dynamic, |_| {});
    let whole = gain(&runs, |r| r.rmse(0.0, f64::MAX));
    let late = gain(&runs, |r| r.rmse(30.0, f64::MAX));
    let heading = gain(&runs, |r| r.rms(30.0, |s| s.heading));
    assert!(whole > 0.45 && late > 0.30 && heading > 0.35, "{whole} {late} {heading}");
    // The errors of a smoothed path are correlated for minutes: 20 runs are some 60 samples of two.
    let (nees2, nees4) = (consistency(&runs, |s| s.nees2), consistency(&runs, |s| s.nees4));
    assert!((1.4..2.7).contains(&nees2) && (3.2..4.8).contains(&nees4), "{nees2} {nees4}");
}

#[test]
fn without_fix_and_velocity_the_error_in_the_gap_falls_by_more_than_half() {
    for which in [Which::Dynamic, Which::ModelAided] {
        let runs = compare(which, |mission| {
            drop(&mut mission.events, Kind::Fix, 200.0, 260.0);
            drop(&mut mission.events, Kind::Dvl, 200.0, 260.0);
        });
        let gap = gain(&runs, |r| r.rmse(200.0, 260.0));
        let nees2 = consistency(&runs, |s| s.nees2);
        assert!(gap > 0.60 && (1.3..2.7).contains(&nees2), "{which:?}: {gap} {nees2}");
    }
}

#[test]
fn a_vehicle_that_was_carried_away_is_where_it_was_before_and_after() {
    for seed in 0..3 {
        let options = Options {
            kidnap: Some(60.0),
            duration_s: 130.0,
            ..Options::nominal(Course::BE3, seed)
        };
        let mission = fly(&options);
        for which in [Which::Dynamic, Which::Inertial] {
            let path = smooth(which, &options, &mission, |_| {});
            let (before, after) = (path.rmse(5.0, 55.0), path.rmse(70.0, 130.0));
            assert!(before < 0.4 && after < 0.4, "{which:?} {seed}: {before} {after}");
        }
    }
}

#[test]
fn a_magnetic_step_spoils_the_heading_neither_before_nor_after() {
    let options = Options { duration_s: 200.0, ..Options::nominal(Course::BE3, 3) };
    let mut mission = fly(&options);
    heading_step(&mut mission.events, 100.0, 0.17);
    let path = smooth(Which::Inertial, &options, &mission, |_| {});
    let worst = path.samples.iter().map(|s| s.heading.abs()).fold(0.0, f64::max);
    assert!(worst < 0.02, "{worst}");
}

#[test]
fn what_is_smoothed_is_finite_and_positive_whatever_is_missing() {
    let options = Options { duration_s: 40.0, ..Options::nominal(Course::BE1, 3) };
    let mission = fly(&options);
    for kind in [Kind::Imu, Kind::Thrust, Kind::Ahrs, Kind::Dvl, Kind::Fix, Kind::Depth] {
        let mut mission = mission.clone();
        mission.events.retain(|e| e.data.kind() != kind);
        for which in [Which::ConstantAcceleration, Which::Dynamic, Which::ModelAided] {
            let path = smooth(which, &options, &mission, |_| {}).path;
            assert!(path.len() > 390, "{kind:?} {which:?}: {}", path.len());
            for e in path {
                let p = SMatrix::<f64, 6, 6>::from_fn(|i, j| e.covariance[i][j]);
                assert!(p.cholesky().is_some(), "{kind:?} {which:?}: {p}");
                let all = [e.position, e.euler, e.velocity].concat();
                assert!(all.iter().all(|x| x.is_finite()), "{kind:?} {which:?}");
            }
        }
    }
}
