//! Faults of the sensors other than the velocity log.

use crate::statistics::{correlation, mean, sigma};
use approx::assert_relative_eq;
use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use rexrov::sensors::*;

const N: usize = 40_000;

fn none() -> BiasNoise {
    BiasNoise { noise_density: 0.0, random_walk: 0.0, correlation_time: 1.0, turn_on_sigma: 0.0 }
}

fn quiet_imu() -> ImuParameters {
    ImuParameters { accelerometer: none(), gyro: none(), attitude_sigma: 0.0, ..Default::default() }
}

fn quiet_ahrs() -> AhrsParameters {
    AhrsParameters { tilt_sigma: 0.0, heading_sigma: 0.0, ..Default::default() }
}

fn ahrs_at(p: &AhrsParameters, yaw: f64, disturbance: f64) -> [f64; 3] {
    let ahrs = Ahrs::new(p).unwrap();
    ahrs.sample(&mut ahrs.memory(), &AhrsTruth { euler: [0.1, -0.2, yaw], disturbance })
}

fn share(all: usize, some: usize) -> f64 {
    some as f64 / all as f64
}

#[test]
fn imu_scale_misalignment_and_g_sensitivity_enter_as_their_matrices_say() {
    let accelerometer_axes = AxisErrors {
        scale_error: [0.01, 0.0, -0.02],
        misalignment: [1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3],
        range: 0.0,
    };
    let gyro_axes = AxisErrors {
        scale_error: [0.0, 0.1, 0.0],
        misalignment: [0.0, 0.0, 0.5, 0.0, 0.0, 0.0],
        range: 0.0,
    };
    let p = ImuParameters { accelerometer_axes, gyro_axes, g_sensitivity: 1e-3, ..quiet_imu() };
    let truth =
        ImuTruth { specific_force: [1.0, 2.0, -10.0], rate: [0.1, 0.2, 0.3], ..Default::default() };
    let imu = Imu::new(&p).unwrap();
    let sample = imu.sample(&mut imu.memory(), &truth);
    let force = [1.01 + 2e-3 - 0.02, 3e-3 + 2.0 - 0.04, 5e-3 + 0.012 - 9.8];
    let rate = [0.1 + 1e-3, 0.05 + 0.22 + 2e-3, 0.3 - 1e-2];
    for axis in 0..3 {
        assert_relative_eq!(sample.specific_force[axis], force[axis], epsilon = 1e-14);
        assert_relative_eq!(sample.rate[axis], rate[axis], epsilon = 1e-14);
    }
}

#[test]
fn imu_saturates_at_its_range() {
    let limited = |range| AxisErrors { range, ..Default::default() };
    let p =
        ImuParameters { accelerometer_axes: limited(20.0), gyro_axes: limited(0.5), ..quiet_imu() };
    let truth = ImuTruth {
        specific_force: [30.0, 0.0, -30.0],
        rate: [-1.0, 0.4, 1.0],
        ..Default::default()
    };
    let imu = Imu::new(&p).unwrap();
    let sample = imu.sample(&mut imu.memory(), &truth);
    assert_eq!(sample.specific_force, [20.0, 0.0, -20.0]);
    assert_eq!(sample.rate, [-0.5, 0.4, 0.5]);
}

#[test]
fn grades_get_better_and_the_default_is_the_adis16448() {
    let [adis, industrial, tactical] =
        [ImuGrade::Adis16448, ImuGrade::Industrial, ImuGrade::Tactical].map(ImuGrade::noise);
    let p = ImuParameters::default();
    assert_eq!((p.accelerometer, p.gyro), (adis.accelerometer, adis.gyro));
    let figures = |n: &ImuNoise| {
        let of = |b: &BiasNoise| [b.noise_density, b.random_walk, b.turn_on_sigma];
        [&of(&n.accelerometer)[..], &of(&n.gyro), &[n.attitude_sigma]].concat()
    };
    for (worse, better) in [(&adis, &industrial), (&industrial, &tactical)] {
        assert!(figures(worse).iter().zip(figures(better)).all(|(worse, better)| *worse > better));
    }
}

#[test]
fn a_fix_reports_the_noise_that_its_range_makes() {
    let p = GpsParameters {
        sigma: 0.3,
        range_sigma: 0.01,
        beacon: [0.0, 30.0, 0.0],
        ..Default::default()
    };
    let gps = Gps::new(&p).unwrap();
    let mut memory = gps.memory();
    let truth = GpsTruth { p_ned: [40.0, 30.0, 0.0], ..Default::default() };
    let fixes: Vec<GpsFix> = (0..N).map(|_| gps.sample(&mut memory, &truth).unwrap()).collect();
    assert_relative_eq!(fixes[0].sigma, 0.5, epsilon = 1e-14);
    for axis in 0..2 {
        let values: Vec<f64> = fixes.iter().map(|fix| fix.sample.position[axis]).collect();
        assert_relative_eq!(sigma(&values), 0.5, max_relative = 0.02);
    }
}

#[test]
fn fixes_are_lost_and_far_off_at_their_rates() {
    let outlier = Outliers { probability: 0.1, sigma: 30.0 };
    let p = GpsParameters { sigma: 0.0, outlier, dropout_probability: 0.25, ..Default::default() };
    let gps = Gps::new(&p).unwrap();
    let mut memory = gps.memory();
    let fixes: Vec<GpsFix> =
        (0..N).filter_map(|_| gps.sample(&mut memory, &GpsTruth::default())).collect();
    assert_relative_eq!(share(N, fixes.len()), 0.75, epsilon = 0.01);
    let off: Vec<f64> =
        fixes.iter().map(|fix| fix.sample.position[1]).filter(|y| *y != 0.0).collect();
    assert_relative_eq!(share(fixes.len(), off.len()), 0.1, epsilon = 0.01);
    assert_relative_eq!(sigma(&off), 30.0, max_relative = 0.05);
    assert!(fixes.iter().all(|fix| fix.sigma == 0.0), "they are not reported");
}

#[test]
fn the_pressure_bias_is_constant_in_a_run_and_spread_over_seeds() {
    let bias = |seed| {
        let p = PressureParameters {
            instrument: Instrument::new(10.0, seed),
            sigma_pa: 0.0,
            bias_sigma_pa: 500.0,
            ..Default::default()
        };
        let sensor = PressureSensor::new(&p).unwrap();
        let mut memory = sensor.memory();
        let mut sample = || sensor.sample(&mut memory, &PressureTruth::default()).pressure_pa;
        let first = sample();
        assert_eq!(first, sample());
        first
    };
    let biases: Vec<f64> = (0..4000).map(bias).collect();
    assert_relative_eq!(sigma(&biases), 500.0, max_relative = 0.05);
}

#[test]
fn pressures_are_far_off_at_their_rate() {
    let outlier = Outliers { probability: 0.02, sigma: 1e5 };
    let p = PressureParameters { sigma_pa: 0.0, outlier, position: [0.0; 3], ..Default::default() };
    let sensor = PressureSensor::new(&p).unwrap();
    let mut memory = sensor.memory();
    let depths = (0..N).map(|_| sensor.sample(&mut memory, &PressureTruth::default()).depth);
    let off: Vec<f64> = depths.filter(|depth| *depth != 0.0).collect();
    assert_relative_eq!(share(N, off.len()), 0.02, epsilon = 0.003);
    assert_relative_eq!(sigma(&off), 1e5 / 9806.38, max_relative = 0.1);
}

#[test]
fn ahrs_noise_has_its_standard_deviations() {
    let p = AhrsParameters { tilt_sigma: 0.002, heading_sigma: 0.02, ..Default::default() };
    let ahrs = Ahrs::new(&p).unwrap();
    let mut memory = ahrs.memory();
    let truth = AhrsTruth { euler: [0.1, 0.2, 0.3], ..Default::default() };
    let all: Vec<[f64; 3]> = (0..N).map(|_| ahrs.sample(&mut memory, &truth)).collect();
    for (axis, expected) in [(0, 0.002), (1, 0.002), (2, 0.02)] {
        let values: Vec<f64> = all.iter().map(|sample| sample[axis]).collect();
        assert_relative_eq!(mean(&values), truth.euler[axis], epsilon = 5e-4);
        assert_relative_eq!(sigma(&values), expected, max_relative = 0.02);
    }
}

#[test]
fn correlated_attitude_errors_are_stationary_and_fall_off_in_their_times() {
    let p = AhrsParameters {
        tilt_error: GaussMarkov { sigma: 0.003, correlation_time: 0.5 },
        heading_error: GaussMarkov { sigma: 0.03, correlation_time: 2.0 },
        ..quiet_ahrs()
    };
    let ahrs = Ahrs::new(&p).unwrap();
    let mut memory = ahrs.memory();
    let all: Vec<[f64; 3]> =
        (0..10 * N).map(|_| ahrs.sample(&mut memory, &AhrsTruth::default())).collect();
    for (axis, expected, lag) in [(0, 0.003, 5), (1, 0.003, 5), (2, 0.03, 20)] {
        let values: Vec<f64> = all.iter().map(|sample| sample[axis]).collect();
        assert_relative_eq!(sigma(&values), expected, max_relative = 0.03);
        let later = correlation(&values[lag..], &values[..values.len() - lag]);
        assert_relative_eq!(later, (-1.0_f64).exp(), epsilon = 0.03);
    }
}

#[test]
fn a_heading_has_its_bias_and_a_drawn_one() {
    let fixed = AhrsParameters { heading_bias: 0.05, ..quiet_ahrs() };
    assert_relative_eq!(ahrs_at(&fixed, 1.0, 0.0)[2], 1.05, epsilon = 1e-15);
    let drawn = |seed| {
        let p = AhrsParameters {
            instrument: Instrument::new(10.0, seed),
            heading_bias_sigma: 0.02,
            ..fixed
        };
        ahrs_at(&p, 1.0, 0.0)[2] - 1.0
    };
    let biases: Vec<f64> = (0..4000).map(drawn).collect();
    assert_relative_eq!(mean(&biases), 0.05, epsilon = 0.001);
    assert_relative_eq!(sigma(&biases), 0.02, max_relative = 0.05);
}

#[test]
fn a_compass_deviates_by_the_heading_and_follows_a_disturbance() {
    let p = AhrsParameters { deviation: [0.01, 0.02, 0.03, 0.04], ..quiet_ahrs() };
    let error = |yaw: f64| ahrs_at(&p, yaw, 0.0)[2] - yaw;
    assert_relative_eq!(error(0.0), 0.02 + 0.04, epsilon = 1e-14);
    assert_relative_eq!(error(FRAC_PI_2), 0.01 - 0.04, epsilon = 1e-14);
    assert_relative_eq!(error(FRAC_PI_4), 0.03 * 0.5_f64.sqrt() + 0.03, epsilon = 1e-14);
    let [roll, pitch, heading] = ahrs_at(&quiet_ahrs(), 1.0, 0.3);
    assert_eq!((roll, pitch), (0.1, -0.2));
    assert_relative_eq!(heading, 1.3, epsilon = 1e-14);
    assert_relative_eq!(ahrs_at(&quiet_ahrs(), 3.0, 0.3)[2], 3.3 - 2.0 * PI, epsilon = 1e-14);
}

#[test]
fn tachometers_show_the_speeds_with_noise_and_the_thrusts_of_sound_propellers() {
    let rotors = Tachometer::new(&TachometerParameters::default()).unwrap();
    let truth = TachometerTruth { speed: [300.0, -300.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0] };
    let mut memory = rotors.memory();
    let all: Vec<TachometerSample> = (0..N).map(|_| rotors.sample(&mut memory, &truth)).collect();
    for (i, speed) in truth.speed.iter().enumerate() {
        let values: Vec<f64> = all.iter().map(|sample| sample.speed[i]).collect();
        assert_relative_eq!(mean(&values), speed, epsilon = 0.003);
        assert_relative_eq!(sigma(&values), 0.1, max_relative = 0.02);
    }
    for sample in all {
        for (thrust, speed) in sample.thrust.iter().zip(sample.speed) {
            assert_relative_eq!(*thrust, 0.00031 * speed * speed.abs(), max_relative = 1e-14);
        }
    }
}
