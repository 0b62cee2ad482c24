//! Common properties of all sensors: their own noise, and checked parameters.

use std::collections::HashSet;

use crate::statistics::correlation;
use rexrov::ParameterError;
use rexrov::sensors::*;

const N: usize = 40_000;

/// White noise of every channel of every instrument of one seed, in its standard deviations.
fn channels(seed: i32) -> Vec<Vec<f64>> {
    let bias = BiasNoise {
        noise_density: 1.0 / 50.0_f64.sqrt(),
        random_walk: 0.0,
        correlation_time: 1.0,
        turn_on_sigma: 0.0,
    };
    let p = ImuParameters {
        instrument: Instrument::new(50.0, seed),
        accelerometer: bias,
        gyro: bias,
        ..Default::default()
    };
    let imu = Imu::new(&p).unwrap();
    let dvl = Dvl::new(&DvlParameters {
        instrument: Instrument::new(7.0, seed),
        sigma: 1.0,
        ..Default::default()
    })
    .unwrap();
    let gps = Gps::new(&GpsParameters {
        instrument: Instrument::new(10.0, seed),
        sigma: 1.0,
        ..Default::default()
    })
    .unwrap();
    let p = PressureParameters {
        instrument: Instrument::new(10.0, seed),
        position: [0.0; 3],
        ..Default::default()
    };
    let pressure = PressureSensor::new(&p).unwrap();
    let ahrs = Ahrs::new(&AhrsParameters {
        instrument: Instrument::new(10.0, seed),
        ..Default::default()
    })
    .unwrap();
    let p = TachometerParameters {
        instrument: Instrument::new(50.0, seed),
        sigma: 1.0,
        ..Default::default()
    };
    let rotors = Tachometer::new(&p).unwrap();
    let (mut m_imu, mut m_dvl, mut m_gps) = (imu.memory(), dvl.memory(), gps.memory());
    let (mut m_pressure, mut m_ahrs, mut m_rotors) =
        (pressure.memory(), ahrs.memory(), rotors.memory());
    let mut channels = vec![Vec::new(); 3 + 3 + 3 + 4 + 2 + 1 + 3 + 8];
    for _ in 0..N {
        let motion = imu.sample(&mut m_imu, &ImuTruth::default());
        let ping = dvl.sample(&mut m_dvl, &DvlTruth::default()).unwrap();
        let fix = gps.sample(&mut m_gps, &GpsTruth::default()).unwrap();
        let depth = pressure.sample(&mut m_pressure, &PressureTruth::default()).depth;
        let attitude = ahrs.sample(&mut m_ahrs, &AhrsTruth::default());
        let speed = rotors.sample(&mut m_rotors, &TachometerTruth::default()).speed;
        let angles = [motion.euler, attitude].map(|euler| euler.map(|angle| angle / 0.01));
        let beams = ping.beams.map(|beam| beam.unwrap() * 2.0_f64.sqrt());
        let acoustic = [&beams[..], &fix.sample.position, &[depth * 9806.38 / 3000.0]].concat();
        let inertial = [motion.specific_force, motion.rate].concat();
        let all = [&inertial[..], &acoustic, angles.as_flattened(), &speed].concat();
        channels.iter_mut().zip(all).for_each(|(channel, value)| channel.push(value));
    }
    channels
}

#[test]
fn channels_of_all_instruments_are_independent_at_equal_seeds() {
    let channels = channels(7);
    for (i, a) in channels.iter().enumerate() {
        for (j, b) in channels.iter().enumerate().skip(i + 1) {
            let limit = 5.0 / (N as f64).sqrt();
            assert!(correlation(a, b).abs() < limit, "channels {i} and {j}");
        }
    }
}

/// Not even at other instants: a stream shared by two of them would give each of its numbers twice.
#[test]
fn no_number_is_drawn_twice_at_equal_seeds() {
    let channels = channels(7);
    let mut seen = HashSet::new();
    let drawn = channels.iter().flat_map(|channel| &channel[..2000]);
    let twice = drawn.filter(|n| !seen.insert((**n * 1e11).round() as i64)).count();
    assert!(twice < 3, "{twice} of {}", 2000 * channels.len());
}

/// The name of the rejected parameter.
fn refused<T: core::fmt::Debug>(made: Result<T, ParameterError>) -> String {
    made.unwrap_err().name
}

#[test]
fn nonsense_is_refused_by_name() {
    let imu = |change: fn(&mut ImuParameters)| {
        let mut p = ImuParameters::default();
        change(&mut p);
        refused(Imu::new(&p))
    };
    assert_eq!(imu(|p| p.accelerometer_axes.scale_error[1] = 0.6), "accelerometer.scale_error.y");
    assert_eq!(imu(|p| p.gyro_axes.misalignment[5] = f64::NAN), "gyro.misalignment.zy");
    assert_eq!(imu(|p| p.gyro_axes.range = -1.0), "gyro.range");
    assert_eq!(imu(|p| p.g_sensitivity = f64::INFINITY), "gyro.g_sensitivity");

    let dvl = |change: fn(&mut DvlParameters)| {
        let mut p = DvlParameters::default();
        change(&mut p);
        refused(Dvl::new(&p))
    };
    assert_eq!(dvl(|p| p.beam_angle_deg = 0.0), "beam_angle_deg");
    assert_eq!(dvl(|p| p.beam_angle_deg = 90.0), "beam_angle_deg");
    assert_eq!(dvl(|p| p.scale_error = 1.0), "scale_error");
    assert_eq!(dvl(|p| p.misalignment_deg = f64::NAN), "misalignment_deg");
    assert_eq!(dvl(|p| p.correlated_error.sigma = -1.0), "correlated_error.sigma");
    assert_eq!(
        dvl(|p| p.correlated_error.correlation_time = 0.0),
        "correlated_error.correlation_time"
    );
    assert_eq!(dvl(|p| p.outlier.probability = 1.1), "outlier.probability");
    assert_eq!(dvl(|p| p.outlier.sigma = -0.1), "outlier.sigma");
    assert_eq!(dvl(|p| p.dropout_probability = -0.1), "dropout_probability");
    assert_eq!(dvl(|p| p.beam_dropout_probability = f64::NAN), "beam_dropout_probability");
    assert_eq!(dvl(|p| p.seabed_depth = -1.0), "seabed_depth");
    assert_eq!(dvl(|p| p.min_altitude = -1.0), "min_altitude");
    assert_eq!(dvl(|p| p.max_altitude = 0.5), "max_altitude");
    assert_eq!(dvl(|p| p.max_tilt_deg = 181.0), "max_tilt_deg");

    let gps = |change: fn(&mut GpsParameters)| {
        let mut p = GpsParameters::default();
        change(&mut p);
        refused(Gps::new(&p))
    };
    assert_eq!(gps(|p| p.range_sigma = -0.1), "range_sigma");
    assert_eq!(gps(|p| p.beacon[2] = f64::NAN), "beacon.z");
    assert_eq!(gps(|p| p.outlier.probability = 2.0), "outlier.probability");
    assert_eq!(gps(|p| p.dropout_probability = 2.0), "dropout_probability");

    let p = PressureParameters { bias_sigma_pa: -1.0, ..Default::default() };
    assert_eq!(refused(PressureSensor::new(&p)), "bias_sigma_pa");
    let p = AhrsParameters { deviation: [0.0, 0.0, f64::NAN, 0.0], ..Default::default() };
    assert_eq!(refused(Ahrs::new(&p)), "deviation.D");
    let p = AhrsParameters { heading_bias_sigma: -1.0, ..Default::default() };
    assert_eq!(refused(Ahrs::new(&p)), "heading_bias_sigma");
    let p = TachometerParameters { thrust_gain: 0.0, ..Default::default() };
    assert_eq!(refused(Tachometer::new(&p)), "thrust_gain");
}
