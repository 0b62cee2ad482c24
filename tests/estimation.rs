//! The paper's two filters: their predictions, when they fuse, and that they never give NaN.

use approx::assert_relative_eq;
use proptest::prelude::*;
use rexrov::estimation::paper::*;
use rexrov::estimation::{Channel, Estimate, Health, Measurements, Navigation, Reading};
use rexrov::vehicle::{Parameters, ReducedModel};

fn dynamic() -> Acceleration {
    Acceleration::Dynamic(ReducedModel::new(&Parameters::default()).unwrap())
}

fn filter(p: EkfParameters, source: Acceleration) -> (Ekf, EkfMemory) {
    let ekf = Ekf::new(&p, source).unwrap();
    let memory = ekf.memory();
    (ekf, memory)
}

/// A steady turn at 20 m depth with perfect sensors but no fix and no depth, all of unknown time.
fn turning(u: f64, r: f64) -> Measurements {
    Measurements {
        imu: Reading::at(-1.0, [0.0, r * u, -9.81, 0.0, 0.0, r]),
        ahrs: Reading::at(-1.0, [0.0; 3]),
        dvl: Reading::at(-1.0, [u, -1.4 * r, 0.0]),
        ..Measurements::default()
    }
}

#[test]
fn dead_reckoning_closes_a_circle() {
    let (u, r) = (0.3, core::f64::consts::TAU / 60.0);
    // The compass would be new in each cycle; being far less certain than the gyro it hardly
    // counts.
    let p = EkfParameters { heading_sigma: 1e9, ..EkfParameters::default() };
    let (ekf, mut memory) = filter(p, Acceleration::Kinematic);
    let start = ekf.update(&mut memory, 0.0, &turning(u, r));
    let mut widest = 0.0_f64;
    let mut last = start;
    for _ in 0..600 {
        last = ekf.update(&mut memory, 0.0, &turning(u, r));
        widest = widest.max(last.position[1]);
    }
    assert_relative_eq!(widest, 2.0 * u / r, epsilon = 2e-3);
    assert_relative_eq!(last.position[0], 0.0, epsilon = 2e-3);
    assert_relative_eq!(last.position[1], 0.0, epsilon = 2e-3);
    assert_relative_eq!(last.velocity[1], 0.0, epsilon = 1e-12);
    assert_relative_eq!(last.acceleration[1], 0.0, epsilon = 1e-12);
}

#[test]
fn only_the_yaw_rate_moves_the_dvl_velocity_to_the_centre_of_gravity() {
    let (ekf, mut memory) = filter(EkfParameters::default(), Acceleration::Kinematic);
    let mut m = turning(0.3, 0.1);
    m.imu.value[3..].copy_from_slice(&[0.2, -0.3, 0.1]);
    let velocity = ekf.update(&mut memory, 0.0, &m).velocity;
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
        ekf.update(&mut memory, 0.0, &turning(0.3, 0.0));
    }
    let pose = ekf.estimate(&memory).position;
    assert_relative_eq!(pose[0], 3.0, epsilon = 1e-9);
    assert_relative_eq!(pose[1], 0.0, epsilon = 1e-9);
}

#[test]
fn the_dynamic_filter_predicts_with_the_thrust() {
    let (ekf, mut memory) = filter(EkfParameters::default(), dynamic());
    let mut m = turning(0.0, 0.0);
    m.thrust = Reading::at(-1.0, [0.0, 0.0, 0.0, 0.0, 100.0, 100.0, -100.0, -100.0]);
    let estimate = ekf.update(&mut memory, 0.0, &m);
    let expected = 400.0 * core::f64::consts::FRAC_1_SQRT_2 / (1862.87 + 779.79);
    assert_relative_eq!(estimate.acceleration[0], expected, epsilon = 1e-12);
    // Nothing counteracts the buoyancy.
    assert_relative_eq!(estimate.acceleration[2], -263.51 / (1862.87 + 3659.9), epsilon = 1e-5);
}

#[test]
fn gravity_leaves_the_kinematic_acceleration_at_any_tilt() {
    let (ekf, mut memory) = filter(EkfParameters::default(), Acceleration::Kinematic);
    let (roll, pitch) = (0.1, -0.2);
    let mut m = turning(0.0, 0.0);
    let down = rexrov::attitude::rotation_euler([roll, pitch, 0.7])[2];
    m.imu.value[..3].copy_from_slice(&down.map(|d| -9.81 * d));
    m.ahrs.value = [roll, pitch, 0.7];
    let estimate = ekf.update(&mut memory, 0.0, &m);
    assert!(estimate.acceleration.iter().all(|a| a.abs() < 1e-12), "{estimate:?}");
}

#[test]
fn a_measurement_is_fused_once() {
    let (ekf, mut memory) = filter(EkfParameters::default(), Acceleration::Kinematic);
    let mut m = turning(0.0, 0.0);
    m.fix = Reading::at(0.0, [1.0, 0.0, 0.0]);
    let first = ekf.update(&mut memory, 0.0, &m);
    assert!(first.position[0] > 0.0);
    let second = ekf.update(&mut memory, 0.0, &m);
    assert_eq!(second.position[0], first.position[0]);
    m.fix.stamp = 0.1;
    assert!(ekf.update(&mut memory, 0.0, &m).position[0] > first.position[0]);
    // Unknown time of measurement: new in every cycle.
    m.fix.stamp = -1.0;
    let third = ekf.update(&mut memory, 0.0, &m);
    assert!(ekf.update(&mut memory, 0.0, &m).position[0] > third.position[0]);
}

#[test]
fn depth_is_that_of_the_centre_of_gravity() {
    let p = EkfParameters { initial_sigma: [1.0; 4], ..EkfParameters::default() };
    let (ekf, mut memory) = filter(p, Acceleration::Kinematic);
    let mut m = turning(0.0, 0.0);
    // When level, the sensor is 0.85 m higher.
    m.depth = Reading::at(-1.0, [24.15]);
    for _ in 0..2000 {
        ekf.update(&mut memory, 0.0, &m);
    }
    assert_relative_eq!(ekf.estimate(&memory).position[2], 25.0, epsilon = 1e-3);
}

#[test]
fn heading_is_wrapped_across_south() {
    let p = EkfParameters { initial_pose: [0.0, 0.0, 20.0, 3.1], ..EkfParameters::default() };
    let (ekf, mut memory) = filter(p, Acceleration::Kinematic);
    let mut m = turning(0.0, 0.0);
    m.ahrs.value[2] = -3.1;
    for _ in 0..200 {
        let yaw = ekf.update(&mut memory, 0.0, &m).euler[2];
        assert!(yaw.abs() > 3.09, "{yaw}");
    }
    assert_relative_eq!(ekf.estimate(&memory).euler[2], -3.1, epsilon = 1e-6);
}

#[test]
fn steady_variance_solves_the_riccati_equation() {
    // F = 1: P = sqrt(Q^2 / 4 + Q R) + Q / 2 before the update, minus its share after.
    let p = EkfParameters { transition: Transition::Repaired, ..EkfParameters::default() };
    let (ekf, mut memory) = filter(p, Acceleration::Kinematic);
    let mut m = turning(0.0, 0.0);
    m.fix = Reading::at(-1.0, [0.0; 3]);
    for _ in 0..5000 {
        ekf.update(&mut memory, 0.0, &m);
    }
    let (q, r) = (1e-4_f64, 2.25);
    let before = q / 2.0 + (q * q / 4.0 + q * r).sqrt();
    let expected = before * r / (before + r);
    assert_relative_eq!(
        ekf.estimate(&memory).covariance[0][0].sqrt(),
        expected.sqrt(),
        epsilon = 1e-9
    );
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
        ekf.update(&mut memory, 0.0, &turning(0.3, 0.0));
    }
    let covariance = ekf.estimate(&memory).covariance;
    assert_relative_eq!(covariance[0][0].sqrt(), 0.0, epsilon = 1e-9);
    assert_relative_eq!(covariance[1][1].sqrt(), 0.1 * 3.0, epsilon = 1e-9);
}

#[test]
fn an_input_left_alone_is_never_fused() {
    let (ekf, mut memory) = filter(EkfParameters::default(), dynamic());
    let mut estimate = Estimate::default();
    for k in 0..100 {
        estimate = ekf.update(&mut memory, 0.1 * f64::from(k), &Measurements::default());
    }
    assert_eq!((estimate.position, estimate.euler), ([0.0, 0.0, 20.0], [0.0; 3]));
    assert!(estimate.channels.iter().all(|channel| channel.used == 0 && channel.rejected == 0));
    assert_relative_eq!(estimate.covariance[0][0], 0.01 + 99.0 * 1e-4, epsilon = 1e-9);
    assert_eq!(ekf.update(&mut memory, 11.0, &Measurements::default()).health, Health::Starved);
}

#[test]
fn what_is_not_a_number_is_ignored_and_counted() {
    let (ekf, mut memory) = filter(EkfParameters::default(), dynamic());
    let mut m = turning(0.3, 0.1);
    m.fix = Reading::at(0.0, [1.0, 2.0, 0.0]);
    let good = ekf.update(&mut memory, 0.0, &m);
    m.dvl.value[1] = f64::NAN;
    m.thrust = Reading::at(0.0, [f64::INFINITY; 8]);
    for _ in 0..2 {
        m.fix = Reading::at(0.1, [f64::NAN, 0.0, 0.0]);
        let estimate = ekf.update(&mut memory, 0.1, &m);
        assert_eq!(estimate.velocity, good.velocity);
        assert!(estimate.position.iter().all(|x| x.is_finite()));
    }
    let channels = ekf.estimate(&memory).channels;
    let rejected = |channel: Channel| channels[channel as usize].rejected;
    assert_eq!([Channel::Dvl, Channel::Fix, Channel::Depth].map(rejected), [2, 1, 0]);
}

#[test]
fn an_estimate_that_overflows_begins_anew_and_says_so() {
    let (ekf, mut memory) = filter(EkfParameters::default(), dynamic());
    let mut m = turning(0.3, 0.0);
    m.thrust = Reading::at(0.0, [0.0; 8]);
    assert_eq!(ekf.update(&mut memory, 0.0, &m).health, Health::Good);
    m.dvl.value[0] = 1e200;
    let estimate = ekf.update(&mut memory, 0.1, &m);
    assert_eq!(estimate.health, Health::Diverged);
    assert_eq!(estimate.position, [0.0, 0.0, 20.0]);
    assert!(estimate.covariance[0][0] >= 1e8, "{:?}", estimate.covariance);
    m.dvl.value[0] = 0.3;
    m.fix = Reading::at(-1.0, [50.0, 0.0, 0.0]);
    let estimate = ekf.update(&mut memory, 0.2, &m);
    assert_relative_eq!(estimate.position[0], 50.0, epsilon = 1e-3);
    assert_eq!(estimate.health, Health::Diverged);
    assert_eq!(ekf.update(&mut memory, 40.0, &m).health, Health::Good);
}

#[test]
fn channels_tell_innovation_and_its_likelihood() {
    let p = EkfParameters { initial_sigma: [2.0; 4], fix_sigma: 1.5, ..EkfParameters::default() };
    let (ekf, mut memory) = filter(p, Acceleration::Kinematic);
    let fix = Reading::at(0.0, [3.0, -4.0, 0.0]);
    let m = Measurements { fix, ..Measurements::default() };
    let channel = ekf.update(&mut memory, 0.0, &m).channels[Channel::Fix as usize];
    assert_eq!(channel.innovation, [3.0, -4.0, 0.0]);
    assert_relative_eq!(channel.sigma[0], 2.5, epsilon = 1e-12);
    assert_relative_eq!(channel.nis, 25.0 / 6.25, epsilon = 1e-12);
    assert_eq!((channel.used, channel.rejected, channel.late), (1, 0, 0));
}

#[test]
fn a_fix_that_reports_its_error_is_weighed_by_it() {
    let p = EkfParameters { initial_sigma: [2.0; 4], fix_sigma: 1.5, ..EkfParameters::default() };
    let (ekf, mut memory) = filter(p, Acceleration::Kinematic);
    let fix = Reading::at(0.0, [1.0, 0.0, 6.0]);
    let estimate = ekf.update(&mut memory, 0.0, &Measurements { fix, ..Measurements::default() });
    assert_relative_eq!(estimate.position[0], 0.1, epsilon = 1e-12);
}

#[test]
fn parameters_out_of_range_are_named() {
    let p = EkfParameters { fix_sigma: 0.0, ..EkfParameters::default() };
    assert_eq!(Ekf::new(&p, dynamic()).unwrap_err().name, "fix_sigma");
    let p = EkfParameters { process_variance: [0.0, 0.0, -1.0, 0.0], ..EkfParameters::default() };
    assert_eq!(Ekf::new(&p, dynamic()).unwrap_err().name, "process_variance.z");
}

proptest! {
    #[test]
    fn estimates_stay_finite_whatever_the_measurements(
        which in 0..3_usize, with_model in any::<bool>(), with_fix in any::<bool>(),
        samples in prop::collection::vec(prop::array::uniform12(-1e3..1e3_f64), 1..80)
    ) {
        let all = [Transition::Paper, Transition::PaperUnguarded, Transition::Repaired];
        let transition = all[which];
        let source = if with_model { dynamic() } else { Acceleration::Kinematic };
        let (ekf, mut memory) = filter(EkfParameters { transition, ..EkfParameters::default() }, source);
        for s in samples {
            // Many exact zeros: where the quotients of the printed F are singular.
            let m = Measurements {
                imu: Reading::at(-1.0, [s[3], s[4], s[5], s[6].max(0.0), 0.0, s[7].max(0.0)]),
                ahrs: Reading::at(-1.0, [s[8], s[9], s[10]]),
                dvl: Reading::at(-1.0, [s[0].max(0.0), s[1].min(0.0), s[2]]),
                fix: Reading { value: [s[11], s[0], 0.0], stamp: -1.0, valid: with_fix },
                depth: Reading::default(),
                thrust: Reading::at(-1.0, [s[3]; 8]),
            };
            let e = ekf.update(&mut memory, 0.0, &m);
            let all = e.position.iter().chain(&e.euler).chain(&e.velocity).chain(&e.acceleration);
            prop_assert!(all.chain(e.covariance.as_flattened()).all(|x| x.is_finite()), "{e:?}");
            let [xx, xy, yy] = [e.covariance[0][0], e.covariance[0][1], e.covariance[1][1]];
            prop_assert!(xy * xy <= xx * yy * (1.0 + 1e-9), "{e:?}");
        }
    }
}
