//! Random forces, current and thrust errors unknown to the vehicle.

use crate::statistics::{correlation, mean, sigma};
use approx::assert_relative_eq;
use rexrov::environment::{Disturbance, DisturbanceParameters, DisturbanceSample};

fn samples(p: &DisturbanceParameters, n: usize) -> Vec<DisturbanceSample> {
    let disturbance = Disturbance::new(p).unwrap();
    let mut memory = disturbance.memory();
    (0..n).map(|_| disturbance.sample(&mut memory)).collect()
}

#[test]
fn forces_and_moments_are_stationary_with_their_correlation_time() {
    let p = DisturbanceParameters {
        rate_hz: 2.0,
        tilt_moment_sigma: 3.0,
        ..DisturbanceParameters::default()
    };
    let all = samples(&p, 400_000);
    for (axis, expected) in [20.0, 20.0, 20.0, 3.0, 3.0, 10.0].into_iter().enumerate() {
        let values: Vec<f64> = all.iter().map(|sample| sample.wrench[axis]).collect();
        assert_relative_eq!(sigma(&values), expected, max_relative = 0.03);
        // Ten samples at 2 Hz are 5 s.
        let later = correlation(&values[10..], &values[..values.len() - 10]);
        assert_relative_eq!(later, (-1.0_f64).exp(), epsilon = 0.03);
    }
}

#[test]
fn a_force_is_as_large_at_the_start_as_later() {
    let at = |seed, k: usize| {
        let p = DisturbanceParameters { seed, ..Default::default() };
        samples(&p, k + 1)[k].wrench[0]
    };
    for k in [0, 20] {
        let values: Vec<f64> = (0..4000).map(|seed| at(seed, k)).collect();
        assert_relative_eq!(sigma(&values), 20.0, max_relative = 0.05);
    }
}

#[test]
fn the_current_walks_from_its_mean_with_the_root_of_time() {
    let at_ten_seconds = |seed| {
        let p = DisturbanceParameters {
            seed,
            mean_current: [0.2, -0.1, 0.05],
            current_random_walk: 0.01,
            ..Default::default()
        };
        let all = samples(&p, 501);
        assert_eq!(all[0].current, [0.2, -0.1, 0.05]);
        all[500].current
    };
    let ends: Vec<[f64; 3]> = (0..2000).map(at_ten_seconds).collect();
    for (axis, start) in [(0, 0.2), (1, -0.1)] {
        let values: Vec<f64> = ends.iter().map(|end| end[axis]).collect();
        assert_relative_eq!(mean(&values), start, epsilon = 0.003);
        assert_relative_eq!(sigma(&values), 0.01 * 10.0_f64.sqrt(), max_relative = 0.06);
    }
    assert!(ends.iter().all(|end| end[2] == 0.05));
}

#[test]
fn thrusts_are_off_by_a_constant_of_each_thruster() {
    let losses = |seed| {
        let all = samples(&DisturbanceParameters { seed, ..Default::default() }, 3);
        assert_eq!(all[0].thruster_loss, all[2].thruster_loss);
        all[0].thruster_loss
    };
    let all: Vec<[f64; 8]> = (0..4000).map(losses).collect();
    let of = |i: usize| all.iter().map(|loss| loss[i]).collect::<Vec<f64>>();
    for i in 0..8 {
        assert_relative_eq!(sigma(&of(i)), 0.03, max_relative = 0.05);
    }
    assert!(correlation(&of(0), &of(1)).abs() < 0.08);
}

#[test]
fn nonsense_is_refused_by_name() {
    let refused = |change: fn(&mut DisturbanceParameters)| {
        let mut p = DisturbanceParameters::default();
        change(&mut p);
        Disturbance::new(&p).unwrap_err().name
    };
    assert_eq!(refused(|p| p.rate_hz = 0.0), "rate_hz");
    assert_eq!(refused(|p| p.force_sigma = -1.0), "force_sigma");
    assert_eq!(refused(|p| p.moment_sigma = f64::NAN), "moment_sigma");
    assert_eq!(refused(|p| p.tilt_moment_sigma = -1.0), "tilt_moment_sigma");
    assert_eq!(refused(|p| p.correlation_time = 0.0), "correlation_time");
    assert_eq!(refused(|p| p.mean_current[1] = f64::NAN), "mean_current.east");
    assert_eq!(refused(|p| p.current_random_walk = -1.0), "current_random_walk");
    assert_eq!(refused(|p| p.thrust_gain_sigma = -1.0), "thrust_gain_sigma");
}
