//! The outputs of the sensors: positions, statistics of their noise, and independence of its draws.

use approx::assert_relative_eq;
use rexrov::sampling::Rate;
use rexrov::sensors::*;

fn mean_and_sigma(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt())
}

fn quiet() -> BiasNoise {
    BiasNoise { noise_density: 0.0, random_walk: 0.0, correlation_time: 1.0, turn_on_sigma: 0.0 }
}

fn quiet_imu() -> ImuParameters {
    ImuParameters {
        accelerometer: quiet(),
        gyro: quiet(),
        attitude_sigma: 0.0,
        ..Default::default()
    }
}

#[test]
fn gaussian_numbers_have_the_moments_of_the_normal_distribution() {
    let mut noise = Gaussian::new(7, Stream::DvlBeams);
    let values: Vec<f64> = (0..200_000).map(|_| noise.draw()).collect();
    let (mean, sigma) = mean_and_sigma(&values);
    let moment = |k| values.iter().map(|x: &f64| x.powi(k)).sum::<f64>() / values.len() as f64;
    assert_relative_eq!(mean, 0.0, epsilon = 0.01);
    assert_relative_eq!(sigma, 1.0, epsilon = 0.01);
    assert_relative_eq!(moment(3), 0.0, epsilon = 0.03);
    assert_relative_eq!(moment(4), 3.0, epsilon = 0.06);
    let lag: f64 = values.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / values.len() as f64;
    assert_relative_eq!(lag, 0.0, epsilon = 0.01);
}

#[test]
fn streams_and_seeds_differ_and_repeat() {
    let draw = |seed, stream| {
        let mut noise = Gaussian::new(seed, stream);
        [noise.draw(), noise.draw(), noise.draw()]
    };
    assert_eq!(draw(1, Stream::DvlBeams), draw(1, Stream::DvlBeams));
    assert_ne!(draw(1, Stream::DvlBeams), draw(1, Stream::GpsPosition));
    assert_ne!(draw(1, Stream::DvlBeams), draw(2, Stream::DvlBeams));
}

#[test]
fn accelerometer_noise_is_its_density_times_the_root_of_the_rate() {
    let mut p = quiet_imu();
    p.accelerometer.noise_density = 0.004;
    let imu = Imu::new(&p).unwrap();
    let mut memory = imu.memory();
    let truth = ImuTruth { specific_force: [0.0, 0.0, -9.81], ..Default::default() };
    let z: Vec<f64> =
        (0..20_000).map(|_| imu.sample(&mut memory, &truth).specific_force[2]).collect();
    let (mean, sigma) = mean_and_sigma(&z);
    assert_relative_eq!(mean, -9.81, epsilon = 0.001);
    assert_relative_eq!(sigma, 0.0283, epsilon = 0.0005);
}

#[test]
fn slow_bias_has_the_stationary_variance_of_a_gauss_markov_process() {
    let mut p = quiet_imu();
    p.gyro = BiasNoise { random_walk: 0.01, correlation_time: 2.0, ..quiet() };
    let imu = Imu::new(&p).unwrap();
    let mut memory = imu.memory();
    let rates: Vec<f64> =
        (0..400_000).map(|_| imu.sample(&mut memory, &ImuTruth::default()).rate[0]).collect();
    // b sqrt(tau / 2), and a correlation that falls to 1/e within tau.
    let (_, sigma) = mean_and_sigma(&rates);
    assert_relative_eq!(sigma, 0.01, epsilon = 0.0008);
    let covariance: f64 =
        rates.windows(101).map(|w| w[0] * w[100]).sum::<f64>() / rates.len() as f64;
    assert_relative_eq!(covariance / (sigma * sigma), (-1.0_f64).exp(), epsilon = 0.08);
}

#[test]
fn turn_on_bias_is_constant_in_a_run_and_spread_over_seeds() {
    let bias = |seed| {
        let gyro = BiasNoise { turn_on_sigma: 0.0087, ..quiet() };
        let imu = Imu::new(&ImuParameters {
            instrument: Instrument::new(50.0, seed),
            gyro,
            ..quiet_imu()
        })
        .unwrap();
        let mut memory = imu.memory();
        let first = imu.sample(&mut memory, &ImuTruth::default()).rate[2];
        assert_eq!(first, imu.sample(&mut memory, &ImuTruth::default()).rate[2]);
        first
    };
    let biases: Vec<f64> = (0..4000).map(bias).collect();
    assert_relative_eq!(mean_and_sigma(&biases).1, 0.0087, epsilon = 0.0003);
}

#[test]
fn imu_feels_its_lever_arm_and_its_mounting() {
    let turning =
        ImuTruth { rate: [0.0, 0.0, 2.0], rate_dot: [0.0, 0.0, 3.0], ..Default::default() };
    let mut p = ImuParameters { position: [0.5, 0.0, 0.0], ..quiet_imu() };
    let sample = |p: &ImuParameters| {
        let imu = Imu::new(p).unwrap();
        imu.sample(&mut imu.memory(), &turning)
    };
    // Towards the axis by w^2 r, along the path by w' r.
    let force = sample(&p).specific_force;
    assert_relative_eq!(force[0], -2.0, epsilon = 1e-12);
    assert_relative_eq!(force[1], 1.5, epsilon = 1e-12);
    // Turned by 90 degrees about z, the x axis of the IMU points to starboard.
    p.orientation_deg = [0.0, 0.0, 90.0];
    let turned = sample(&p);
    assert_relative_eq!(turned.specific_force[0], 1.5, epsilon = 1e-12);
    assert_relative_eq!(turned.specific_force[1], 2.0, epsilon = 1e-12);
    assert_relative_eq!(turned.rate[2], 2.0, epsilon = 1e-12);
}

#[test]
fn channels_draw_independently_of_each_other() {
    let noisy = ImuParameters::default();
    let silent_gyro = ImuParameters { gyro: quiet(), ..noisy };
    let run = |p: &ImuParameters| {
        let imu = Imu::new(p).unwrap();
        let mut memory = imu.memory();
        (0..50).map(|_| imu.sample(&mut memory, &ImuTruth::default())).last().unwrap()
    };
    let (a, b) = (run(&noisy), run(&silent_gyro));
    assert_ne!(a.rate, b.rate);
    assert_eq!((a.specific_force, a.euler), (b.specific_force, b.euler));
}

#[test]
fn orientation_stays_wrapped() {
    let imu = Imu::new(&ImuParameters { attitude_sigma: 0.5, ..quiet_imu() }).unwrap();
    let mut memory = imu.memory();
    let truth = ImuTruth { euler: [0.0, 0.0, core::f64::consts::PI], ..Default::default() };
    for _ in 0..1000 {
        let yaw = imu.sample(&mut memory, &truth).euler[2];
        assert!(yaw > -core::f64::consts::PI && yaw <= core::f64::consts::PI);
    }
}

#[test]
fn dvl_gps_and_pressure_measure_at_their_own_places() {
    let dvl = Dvl::new(&DvlParameters { sigma: 0.0, ..Default::default() }).unwrap();
    let truth = DvlTruth { nu: [0.3, 0.0, 0.0, 0.0, 0.0, 0.1], ..Default::default() };
    let v = dvl.sample(&mut dvl.memory(), &truth).unwrap().sample.velocity;
    assert_relative_eq!(v[1], -0.14, epsilon = 1e-12);

    let p = GpsParameters { sigma: 0.0, position: [2.0, 0.0, 0.0], ..Default::default() };
    let gps = Gps::new(&p).unwrap();
    let east = [0.0, 0.0, core::f64::consts::FRAC_PI_2];
    let truth = GpsTruth { p_ned: [1.0, 1.0, 0.0], euler: east };
    let fix = gps.sample(&mut gps.memory(), &truth).unwrap().sample.position;
    assert_relative_eq!(fix[0], 1.0, epsilon = 1e-12);
    assert_relative_eq!(fix[1], 3.0, epsilon = 1e-12);

    let p = PressureParameters { sigma_pa: 0.0, ..Default::default() };
    let sensor = PressureSensor::new(&p).unwrap();
    let truth = PressureTruth { z: 20.0, tilt: [0.0; 2] };
    let sample = sensor.sample(&mut sensor.memory(), &truth);
    assert_relative_eq!(sample.depth, 19.15, epsilon = 1e-12);
    assert_relative_eq!(sample.pressure_pa, 101_325.0 + 9806.38 * 19.15, epsilon = 1e-6);
}

#[test]
fn position_and_depth_noise_have_their_standard_deviations() {
    let gps = Gps::new(&GpsParameters::default()).unwrap();
    let mut memory = gps.memory();
    let fix = |memory: &mut GpsMemory| gps.sample(memory, &GpsTruth::default()).unwrap();
    let fixes: Vec<[f64; 2]> = (0..20_000).map(|_| fix(&mut memory).sample.position).collect();
    for axis in 0..2 {
        let values: Vec<f64> = fixes.iter().map(|f| f[axis]).collect();
        assert_relative_eq!(mean_and_sigma(&values).1, 1.5, epsilon = 0.03);
    }
    let sensor = PressureSensor::new(&PressureParameters::default()).unwrap();
    let mut memory = sensor.memory();
    let depths: Vec<f64> =
        (0..20_000).map(|_| sensor.sample(&mut memory, &PressureTruth::default()).depth).collect();
    assert_relative_eq!(mean_and_sigma(&depths).1, 0.306, epsilon = 0.006);
}

#[test]
fn unusable_rates_are_refused() {
    for rate in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
        assert_eq!(Rate::new(rate).unwrap_err().name, "rate_hz");
    }
}

#[test]
fn unusable_parameters_are_named() {
    let gps = Gps::new(&GpsParameters { sigma: -1.0, ..Default::default() });
    assert_eq!(
        gps.unwrap_err().to_string(),
        "parameter `sigma` = -1: must be zero or positive, and finite"
    );
    let p = DvlParameters { position: [0.0, f64::NAN, 0.0], ..Default::default() };
    assert_eq!(Dvl::new(&p).unwrap_err().name, "mounting.y");
    let gyro = BiasNoise { correlation_time: 0.0, ..quiet() };
    let imu = Imu::new(&ImuParameters { gyro, ..Default::default() });
    assert_eq!(imu.unwrap_err().name, "gyro.correlation_time");
}
