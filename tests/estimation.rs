//! The two filters: what they predict, when they fuse, and that they never give NaN.

use approx::assert_relative_eq;
use proptest::prelude::*;
use rexrov::estimation::*;
use rexrov::sensors::{DvlSample, GpsSample, ImuSample};
use rexrov::vehicle::{Parameters, ReducedModel};

fn dynamic() -> Acceleration {
    Acceleration::Dynamic(ReducedModel::new(&Parameters::default()).unwrap())
}

fn filter(p: EkfParameters, source: Acceleration) -> (Ekf, EkfMemory) {
    let ekf = Ekf::new(&p, source).unwrap();
    let memory = ekf.memory();
    (ekf, memory)
}

/// A steady turn at 20 m depth with perfect sensors but no fix, depth or compass.
fn turning(u: f64, r: f64) -> Measurements {
    let mut m = Measurements::default();
    m.imu.value =
        ImuSample { specific_force: [0.0, r * u, -9.81], rate: [0.0, 0.0, r], euler: [0.0; 3] };
    m.dvl.value = DvlSample { velocity: [u, -1.4 * r, 0.0] };
    m.fix.valid = false;
    m.pressure.valid = false;
    m
}

#[test]
fn dead_reckoning_closes_a_circle() {
    let (u, r) = (0.3, core::f64::consts::TAU / 60.0);
    // The compass would be new in each cycle; far less certain than the gyro it hardly counts.
    let p = EkfParameters { heading_sigma: 1e9, ..EkfParameters::default() };
    let (ekf, mut memory) = filter(p, Acceleration::Kinematic);
    let start = ekf.update(&mut memory, &turning(u, r)).unwrap();
    let mut widest = 0.0_f64;
    let mut last = start;
    for _ in 0..600 {
        last = ekf.update(&mut memory, &turning(u, r)).unwrap();
        widest = widest.max(last.pose[1]);
    }
    assert_relative_eq!(widest, 2.0 * u / r, epsilon = 2e-3);
    assert_relative_eq!(last.pose[0], 0.0, epsilon = 2e-3);
    assert_relative_eq!(last.pose[1], 0.0, epsilon = 2e-3);
    assert_relative_eq!(last.velocity[1], 0.0, epsilon = 1e-12);
    assert_relative_eq!(last.acceleration[1], 0.0, epsilon = 1e-12);
}

#[test]
fn only_the_yaw_rate_moves_the_dvl_velocity_to_the_centre_of_gravity() {
    let (ekf, mut memory) = filter(EkfParameters::default(), Acceleration::Kinematic);
    let mut m = turning(0.3, 0.1);
    m.imu.value.rate = [0.2, -0.3, 0.1];
    let velocity = ekf.update(&mut memory, &m).unwrap().velocity;
    assert_relative_eq!(velocity[0], 0.3, epsilon = 1e-12);
    assert_relative_eq!(velocity[1], 0.0, epsilon = 1e-12);
    assert_relative_eq!(velocity[2], 0.0, epsilon = 1e-12);
}

#[test]
fn without_rotation_the_filter_walks_north_as_printed() {
    let p = EkfParameters {
        rotate_to_ned: false,
        initial_pose: [0.0, 0.0, 20.0, 1.5],
        heading_sigma: 1e9,
        ..EkfParameters::default()
    };
    let (ekf, mut memory) = filter(p, Acceleration::Kinematic);
    for _ in 0..101 {
        ekf.update(&mut memory, &turning(0.3, 0.0)).unwrap();
    }
    let pose = ekf.estimate(&memory).pose;
    assert_relative_eq!(pose[0], 3.0, epsilon = 1e-9);
    assert_relative_eq!(pose[1], 0.0, epsilon = 1e-9);
}

#[test]
fn the_dynamic_filter_predicts_with_the_thrust() {
    let (ekf, mut memory) = filter(EkfParameters::default(), dynamic());
    let mut m = turning(0.0, 0.0);
    m.thrust = [0.0, 0.0, 0.0, 0.0, 100.0, 100.0, -100.0, -100.0];
    let estimate = ekf.update(&mut memory, &m).unwrap();
    let expected = 400.0 * core::f64::consts::FRAC_1_SQRT_2 / (1862.87 + 779.79);
    assert_relative_eq!(estimate.acceleration[0], expected, epsilon = 1e-12);
    // Nothing holds the buoyancy down.
    assert_relative_eq!(estimate.acceleration[2], -263.51 / (1862.87 + 3659.9), epsilon = 1e-5);
}

#[test]
fn gravity_leaves_the_kinematic_acceleration_at_any_tilt() {
    let (ekf, mut memory) = filter(EkfParameters::default(), Acceleration::Kinematic);
    let (roll, pitch) = (0.1, -0.2);
    let mut m = turning(0.0, 0.0);
    let down = rexrov::attitude::rotation_euler([roll, pitch, 0.7])[2];
    m.imu.value.specific_force = down.map(|d| -9.81 * d);
    m.imu.value.euler = [roll, pitch, 0.7];
    let estimate = ekf.update(&mut memory, &m).unwrap();
    assert!(estimate.acceleration.iter().all(|a| a.abs() < 1e-12), "{estimate:?}");
}

#[test]
fn a_measurement_is_fused_once() {
    let (ekf, mut memory) = filter(EkfParameters::default(), Acceleration::Kinematic);
    let mut m = turning(0.0, 0.0);
    m.fix = Reading { value: GpsSample { position: [1.0, 0.0] }, stamp: 0.0, valid: true };
    let first = ekf.update(&mut memory, &m).unwrap();
    assert!(first.pose[0] > 0.0);
    let second = ekf.update(&mut memory, &m).unwrap();
    assert_eq!(second.pose[0], first.pose[0]);
    m.fix.stamp = 0.1;
    assert!(ekf.update(&mut memory, &m).unwrap().pose[0] > first.pose[0]);
    // Unknown time of measurement: new in every cycle.
    m.fix.stamp = -1.0;
    let third = ekf.update(&mut memory, &m).unwrap();
    assert!(ekf.update(&mut memory, &m).unwrap().pose[0] > third.pose[0]);
}

#[test]
fn depth_is_that_of_the_centre_of_gravity() {
    let p = EkfParameters { initial_sigma: [1.0; 4], ..EkfParameters::default() };
    let (ekf, mut memory) = filter(p, Acceleration::Kinematic);
    let mut m = turning(0.0, 0.0);
    // Level, the sensor sits 0.85 m higher.
    m.pressure = Reading { value: 24.15, ..Reading::default() };
    for _ in 0..2000 {
        ekf.update(&mut memory, &m).unwrap();
    }
    assert_relative_eq!(ekf.estimate(&memory).pose[2], 25.0, epsilon = 1e-3);
}

#[test]
fn heading_is_wrapped_across_south() {
    let p = EkfParameters { initial_pose: [0.0, 0.0, 20.0, 3.1], ..EkfParameters::default() };
    let (ekf, mut memory) = filter(p, Acceleration::Kinematic);
    let mut m = turning(0.0, 0.0);
    m.imu.value.euler[2] = -3.1;
    for _ in 0..200 {
        let yaw = ekf.update(&mut memory, &m).unwrap().pose[3];
        assert!(yaw.abs() > 3.09, "{yaw}");
    }
    assert_relative_eq!(ekf.estimate(&memory).pose[3], -3.1, epsilon = 1e-6);
}

#[test]
fn steady_variance_solves_the_riccati_equation() {
    // F = 1: P = sqrt(Q^2 / 4 + Q R) + Q / 2 before the update, less its share after.
    let p = EkfParameters { transition: Transition::Repaired, ..EkfParameters::default() };
    let (ekf, mut memory) = filter(p, Acceleration::Kinematic);
    let mut m = turning(0.0, 0.0);
    m.fix.valid = true;
    for _ in 0..5000 {
        ekf.update(&mut memory, &m).unwrap();
    }
    let (q, r) = (1e-4_f64, 2.25);
    let before = q / 2.0 + (q * q / 4.0 + q * r).sqrt();
    let expected = before * r / (before + r);
    assert_relative_eq!(ekf.estimate(&memory).sigma[0], expected.sqrt(), epsilon = 1e-9);
}

#[test]
fn a_moving_vehicle_uncertain_of_its_heading_is_uncertain_across_its_way() {
    let p = EkfParameters {
        transition: Transition::Repaired,
        process_noise: ProcessNoise::Dvl,
        initial_sigma: [0.0, 0.0, 0.0, 0.1],
        heading_sigma: 1e9,
        process_variance: [0.0; 4],
        dvl_sigma: 0.0,
        ..EkfParameters::default()
    };
    let (ekf, mut memory) = filter(p, Acceleration::Kinematic);
    for _ in 0..101 {
        ekf.update(&mut memory, &turning(0.3, 0.0)).unwrap();
    }
    let sigma = ekf.estimate(&memory).sigma;
    assert_relative_eq!(sigma[0], 0.0, epsilon = 1e-9);
    assert_relative_eq!(sigma[1], 0.1 * 3.0, epsilon = 1e-9);
}

#[test]
fn measurements_that_are_not_numbers_are_refused_and_change_nothing() {
    let (ekf, mut memory) = filter(EkfParameters::default(), dynamic());
    ekf.update(&mut memory, &turning(0.3, 0.1)).unwrap();
    let before = memory;
    let mut m = turning(0.3, 0.1);
    m.dvl.value.velocity[1] = f64::NAN;
    let error = ekf.update(&mut memory, &m).unwrap_err().to_string();
    assert!(error.starts_with("dvl.velocity[1] = NaN: a measurement must be"), "{error}");
    assert_eq!(memory, before);
    m.dvl.valid = false;
    assert!(ekf.update(&mut memory, &m).is_ok());
    m.thrust[7] = f64::INFINITY;
    assert_eq!(ekf.update(&mut memory, &m).unwrap_err().quantity, "thrust[7]");
    let (kinematic, mut memory) = filter(EkfParameters::default(), Acceleration::Kinematic);
    assert!(kinematic.update(&mut memory, &m).is_ok());
}

#[test]
fn parameters_out_of_range_are_named() {
    let p = EkfParameters { fix_sigma: 0.0, ..EkfParameters::default() };
    assert_eq!(Ekf::new(&p, dynamic()).unwrap_err().name, "fix_sigma");
    let p = EkfParameters { process_variance: [0.0, 0.0, -1.0, 0.0], ..EkfParameters::default() };
    assert_eq!(Ekf::new(&p, dynamic()).unwrap_err().name, "process_variance[2]");
}

proptest! {
    #[test]
    fn estimates_stay_finite_whatever_the_measurements(
        which in 0..3_usize, with_model in any::<bool>(), with_fix in any::<bool>(),
        samples in prop::collection::vec(prop::array::uniform12(-1e3..1e3_f64), 1..80)
    ) {
        let transition = [Transition::Paper, Transition::PaperUnguarded, Transition::Repaired][which];
        let source = if with_model { dynamic() } else { Acceleration::Kinematic };
        let (ekf, mut memory) = filter(EkfParameters { transition, ..EkfParameters::default() }, source);
        for s in samples {
            let mut m = turning(0.0, 0.0);
            // Many exact zeros: where the quotients of the printed F are singular.
            m.dvl.value.velocity = [s[0].max(0.0), s[1].min(0.0), s[2]];
            m.imu.value = ImuSample {
                specific_force: [s[3], s[4], s[5]],
                rate: [s[6].max(0.0), 0.0, s[7].max(0.0)],
                euler: [s[8], s[9], s[10]],
            };
            m.fix = Reading {
                value: GpsSample { position: [s[11], s[0]] },
                valid: with_fix,
                ..Reading::default()
            };
            m.thrust = [s[3]; 8];
            let e = ekf.update(&mut memory, &m).unwrap();
            let all = e.pose.iter().chain(&e.velocity).chain(&e.acceleration).chain(&e.sigma);
            prop_assert!(all.chain([&e.covariance_xy]).all(|x| x.is_finite()), "{e:?}");
            let bound = e.sigma[0] * e.sigma[1] * (1.0 + 1e-9);
            prop_assert!(e.covariance_xy.abs() <= bound, "{e:?}");
        }
    }
}
