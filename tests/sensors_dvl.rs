//! The four beams of the Doppler velocity log: geometry, noise, bottom lock and faults.

use crate::statistics::{correlation, sigma};
use approx::assert_relative_eq;
use rexrov::sensors::*;

const N: usize = 40_000;

fn quiet() -> DvlParameters {
    DvlParameters { sigma: 0.0, position: [0.0; 3], ..Default::default() }
}

fn moving(u: f64, v: f64, w: f64) -> DvlTruth {
    DvlTruth { nu: [u, v, w, 0.0, 0.0, 0.0], ..Default::default() }
}

/// Samples of a log for the same truth.
fn pings(p: &DvlParameters, truth: &DvlTruth, n: usize) -> Vec<Option<DvlPing>> {
    let dvl = Dvl::new(p).unwrap();
    let mut memory = dvl.memory();
    (0..n).map(|_| dvl.sample(&mut memory, truth)).collect()
}

fn ping(p: &DvlParameters, truth: &DvlTruth) -> Option<DvlPing> {
    pings(p, truth, 1)[0]
}

fn valid(ping: &DvlPing) -> usize {
    ping.beams.iter().flatten().count()
}

#[test]
fn beams_look_to_the_four_corners_and_down() {
    let ping = ping(&quiet(), &moving(1.0, 0.2, -0.3)).unwrap();
    let (s, c, d) = (0.5, 0.75_f64.sqrt(), 0.5_f64.sqrt());
    let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
    for (beam, (x, y)) in ping.beams.iter().zip(corners) {
        let expected = s * d * (1.0 * x + 0.2 * y) + c * -0.3;
        assert_relative_eq!(beam.unwrap(), expected, epsilon = 1e-14);
    }
    for (got, want) in ping.sample.velocity.iter().zip([1.0, 0.2, -0.3]) {
        assert_relative_eq!(*got, want, epsilon = 1e-14);
    }
    assert_relative_eq!(ping.error_velocity, 0.0, epsilon = 1e-15);
}

#[test]
fn noise_is_sigma_across_and_in_the_error_velocity_and_follows_from_the_geometry_along() {
    for beam_angle_deg in [20.0, 30.0] {
        let p = DvlParameters { sigma: 0.01, beam_angle_deg, ..quiet() };
        let all: Vec<DvlPing> =
            pings(&p, &moving(0.3, 0.0, 0.1), N).into_iter().flatten().collect();
        let along = 0.01 * beam_angle_deg.to_radians().tan() / 2.0_f64.sqrt();
        for (axis, expected) in [(0, 0.01), (1, 0.01), (2, along)] {
            let values: Vec<f64> = all.iter().map(|ping| ping.sample.velocity[axis]).collect();
            assert_relative_eq!(sigma(&values), expected, max_relative = 0.02);
        }
        let error: Vec<f64> = all.iter().map(|ping| ping.error_velocity).collect();
        let surge: Vec<f64> = all.iter().map(|ping| ping.sample.velocity[0]).collect();
        assert_relative_eq!(sigma(&error), 0.01, max_relative = 0.02);
        assert!(correlation(&error, &surge).abs() < 0.03);
    }
}

#[test]
fn three_beams_give_the_velocity_and_two_give_no_sample() {
    let p = DvlParameters { beam_dropout_probability: 0.2, ..quiet() };
    let all = pings(&p, &moving(0.5, -0.2, 0.1), N);
    let shown: Vec<&DvlPing> = all.iter().flatten().collect();
    // All four hold with 0.8^4, just three with 4 x 0.2 x 0.8^3.
    assert_relative_eq!(shown.len() as f64 / N as f64, 0.8192, epsilon = 0.01);
    for missing in 0..4 {
        let lacks = |ping: &&&DvlPing| valid(ping) == 3 && ping.beams[missing].is_none();
        let found = shown.iter().filter(lacks).count();
        assert_relative_eq!(found as f64 / N as f64, 0.1024, epsilon = 0.01);
    }
    for ping in shown {
        for (got, want) in ping.sample.velocity.iter().zip([0.5, -0.2, 0.1]) {
            assert_relative_eq!(*got, want, epsilon = 1e-14);
        }
        assert_relative_eq!(ping.error_velocity, 0.0, epsilon = 1e-15);
    }
}

#[test]
fn three_beams_are_noisier_by_the_root_of_two_and_know_no_error_velocity() {
    let p = DvlParameters { sigma: 0.01, beam_dropout_probability: 0.2, ..quiet() };
    let all = pings(&p, &moving(0.0, 0.0, 0.0), 4 * N);
    let three: Vec<&DvlPing> = all.iter().flatten().filter(|ping| valid(ping) == 3).collect();
    for axis in 0..2 {
        let values: Vec<f64> = three.iter().map(|ping| ping.sample.velocity[axis]).collect();
        assert_relative_eq!(sigma(&values), 0.01 * 2.0_f64.sqrt(), max_relative = 0.02);
    }
    assert!(three.iter().all(|ping| ping.error_velocity == 0.0));
}

#[test]
fn scale_stretches_and_misalignment_turns_the_velocity() {
    let p = DvlParameters { scale_error: 0.01, misalignment_deg: 90.0, ..quiet() };
    let [u, v, w] = ping(&p, &moving(1.0, 0.0, 0.5)).unwrap().sample.velocity;
    assert_relative_eq!(u, 0.0, epsilon = 1e-14);
    assert_relative_eq!(v, -1.01, epsilon = 1e-14);
    assert_relative_eq!(w, 0.505, epsilon = 1e-14);
}

#[test]
fn the_correlated_error_is_stationary_and_common_to_the_beams() {
    let correlated_error = GaussMarkov { sigma: 0.02, correlation_time: 1.0 };
    let p = DvlParameters { correlated_error, ..quiet() };
    let all: Vec<DvlPing> =
        pings(&p, &moving(0.0, 0.0, 0.0), 4 * N).into_iter().flatten().collect();
    let surge: Vec<f64> = all.iter().map(|ping| ping.sample.velocity[0]).collect();
    assert_relative_eq!(sigma(&surge), 0.02, max_relative = 0.03);
    // At 7 Hz seven samples are a correlation time.
    let lag = correlation(&surge[7..], &surge[..surge.len() - 7]);
    assert_relative_eq!(lag, (-1.0_f64).exp(), epsilon = 0.03);
    assert!(all.iter().all(|ping| ping.error_velocity.abs() < 1e-15));
    let first = |seed| {
        let p = DvlParameters { instrument: Instrument::new(7.0, seed), ..p };
        ping(&p, &moving(0.0, 0.0, 0.0)).unwrap().sample.velocity[0]
    };
    let firsts: Vec<f64> = (0..4000).map(first).collect();
    assert_relative_eq!(sigma(&firsts), 0.02, max_relative = 0.05);
}

#[test]
fn outliers_come_at_their_rate_with_their_size() {
    let outlier = Outliers { probability: 0.05, sigma: 1.0 };
    let p = DvlParameters { outlier, ..quiet() };
    let all: Vec<DvlPing> = pings(&p, &moving(0.0, 0.0, 0.0), N).into_iter().flatten().collect();
    let off: Vec<f64> =
        all.iter().map(|ping| ping.sample.velocity[0]).filter(|u| *u != 0.0).collect();
    assert_relative_eq!(off.len() as f64 / N as f64, 0.05, epsilon = 0.004);
    assert_relative_eq!(sigma(&off), 1.0, epsilon = 0.05);
    let outlying = all.iter().filter(|ping| ping.error_velocity != 0.0).count();
    assert_eq!(outlying, off.len(), "the beams of an outlier disagree");
}

#[test]
fn a_lost_ping_is_no_sample() {
    let p = DvlParameters { dropout_probability: 0.3, ..quiet() };
    let lost = pings(&p, &moving(0.0, 0.0, 0.0), N).iter().filter(|ping| ping.is_none()).count();
    assert_relative_eq!(lost as f64 / N as f64, 0.3, epsilon = 0.01);
}

/// A log at this altitude and roll over a seabed in 200 m.
fn over_ground(altitude: f64, roll_deg: f64, p: DvlParameters) -> Option<DvlPing> {
    let p = DvlParameters { seabed_depth: 200.0, ..p };
    let tilt = [roll_deg.to_radians(), 0.0];
    ping(&p, &DvlTruth { z: 200.0 - altitude, tilt, ..Default::default() })
}

#[test]
fn bottom_lock_ends_at_the_altitudes_of_the_instrument() {
    for (altitude, locked) in [(0.69, false), (0.71, true), (89.9, true), (90.1, false)] {
        let ping = over_ground(altitude, 0.0, quiet());
        assert_eq!(ping.is_some(), locked, "{altitude} m");
        if let Some(ping) = ping {
            assert_relative_eq!(ping.altitude, altitude, epsilon = 1e-10);
        }
    }
    assert!(over_ground(-1.0, 0.0, quiet()).is_none(), "within the ground");
    // The log is 0.312 m below the centre of gravity.
    let nominal = DvlParameters { position: [-1.4, 0.0, 0.312], ..quiet() };
    let ping = over_ground(30.0, 0.0, nominal).unwrap();
    assert_relative_eq!(ping.altitude, 29.688, epsilon = 1e-10);
}

#[test]
fn tilt_takes_beams_out_of_range_one_after_the_other() {
    // Rolled to starboard, the beams to port are longer by 14 % at 10 degrees.
    let beams = |altitude, roll| over_ground(altitude, roll, quiet());
    assert_eq!(valid(&beams(75.0, 10.0).unwrap()), 4);
    assert!(beams(85.0, 10.0).is_none());
    // With some pitch only one of them is out of range.
    let p = DvlParameters { seabed_depth: 200.0, ..quiet() };
    let tilt = [7.0_f64.to_radians(); 2];
    let truth = DvlTruth { nu: [0.4, 0.1, 0.0, 0.0, 0.0, 0.0], z: 200.0 - 80.0, tilt };
    let ping = ping(&p, &truth).unwrap();
    assert_eq!(ping.beams.map(|beam| beam.is_some()), [true, true, true, false]);
    assert_relative_eq!(ping.sample.velocity[0], 0.4, epsilon = 1e-14);
}

#[test]
fn bottom_lock_ends_at_the_greatest_tilt_with_or_without_a_seabed() {
    let p = DvlParameters { max_tilt_deg: 15.0, ..quiet() };
    for (roll, locked) in [(0.0, true), (14.9, true), (15.1, false), (-15.1, false)] {
        assert_eq!(over_ground(20.0, roll, p).is_some(), locked, "{roll} deg");
        let tilt = [roll.to_radians(), 0.0];
        let somewhere = DvlTruth { tilt, ..Default::default() };
        assert_eq!(ping(&p, &somewhere).is_some(), locked, "{roll} deg, no seabed");
    }
    // A beam that points above the horizon sees no ground, whatever tilt is allowed.
    let p = DvlParameters { max_tilt_deg: 180.0, ..quiet() };
    assert!(over_ground(20.0, 75.0, p).is_none());
}

#[test]
fn faults_of_one_kind_leave_the_noise_of_the_others() {
    let noisy = DvlParameters { sigma: 0.01, ..quiet() };
    let faulty = DvlParameters {
        outlier: Outliers { probability: 0.1, sigma: 1.0 },
        dropout_probability: 0.2,
        beam_dropout_probability: 0.1,
        ..noisy
    };
    let truth = moving(0.3, 0.0, 0.0);
    let (sound, faulty) = (pings(&noisy, &truth, 1000), pings(&faulty, &truth, 1000));
    let same = sound.iter().zip(&faulty).filter(|(a, b)| a == b).count();
    // 0.8 of the pings are present, 0.9 no outliers, 0.9^4 with all beams.
    assert_relative_eq!(same as f64 / 1000.0, 0.472, epsilon = 0.05);
}

#[test]
fn models_are_those_of_their_data_sheets_and_the_default_is_the_simulators() {
    let default = DvlParameters::default();
    assert_eq!(
        (default.instrument.rate_hz, default.sigma, default.beam_angle_deg),
        (7.0, 0.001, 30.0)
    );
    assert_eq!(default.position, [-1.4, 0.0, 0.312]);
    let nortek = DvlModel::NortekDvl1000.parameters();
    assert_eq!(
        (nortek.instrument.rate_hz, nortek.beam_angle_deg, nortek.max_altitude),
        (8.0, 25.0, 75.0)
    );
    assert!(Dvl::new(&DvlModel::WorkhorseNavigator300.parameters()).is_ok());
}
