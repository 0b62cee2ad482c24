//! The simulated missions have the properties they claim.

use crate::mission::*;
use approx::{assert_abs_diff_eq, assert_relative_eq};
use rexrov::attitude::{from_euler, rotation, wrap};
use rexrov::guidance::Course;
use rexrov::vehicle::{Inertia, Inputs, Parameters, State, ThrusterMode, Vehicle};

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

fn ideal(course: &'static str, seed: u64) -> Options {
    Options { ideal: true, ..Options::nominal(course, seed) }
}

/// Without effects that the nominal model omits.
fn calm(seed: u64) -> Options {
    Options { thrust_gain_sigma: 0.0, disturbance: [0.0; 2], ..ideal(Course::BE1, seed) }
}

fn of(events: &[Event], kind: Kind) -> Vec<Event> {
    events.iter().filter(|e| e.data.kind() == kind).copied().collect()
}

/// Errors of a sensor, channel by channel: its samples minus those of the mission without noise.
fn errors(noisy: &Mission, ideal: &Mission, kind: Kind) -> Vec<Vec<f64>> {
    let pairs = of(&noisy.events, kind).into_iter().zip(of(&ideal.events, kind));
    let mut channels = vec![Vec::new(); channel_count(kind)];
    for (a, b) in pairs {
        assert_eq!(a.stamp, b.stamp);
        let difference = a.data.values().into_iter().zip(b.data.values()).map(|(x, y)| x - y);
        channels.iter_mut().zip(difference).for_each(|(c, d)| c.push(wrap(d)));
    }
    channels
}

fn channel_count(kind: Kind) -> usize {
    match kind {
        Kind::Imu => 6,
        Kind::Thrust => 8,
        Kind::Ahrs | Kind::Dvl => 3,
        Kind::Fix => 2,
        Kind::Depth => 1,
    }
}

#[test]
fn errors_of_the_sensors_are_white_and_of_their_sigmas() {
    let options = Options::nominal(Course::BE3, 7);
    let (noisy, ideal) = (fly(&options), fly(&ideal(Course::BE3, 7)));
    let sigmas = [
        (Kind::Ahrs, vec![0.01; 3]),
        (Kind::Dvl, vec![0.01; 3]),
        (Kind::Fix, vec![0.5; 2]),
        (Kind::Depth, vec![0.306]),
    ];
    for (kind, sigmas) in sigmas {
        for (error, sigma) in errors(&noisy, &ideal, kind).iter().zip(sigmas) {
            let n = error.len() as f64;
            let mean = error.iter().sum::<f64>() / n;
            let lag = error.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / n;
            assert!(mean.abs() < 3.5 * sigma / n.sqrt(), "{kind:?}: mean {mean}");
            assert!((rms(error) / sigma - 1.0).abs() < 3.5 / (2.0 * n).sqrt(), "{kind:?}");
            assert!(lag.abs() < 3.5 * sigma * sigma / n.sqrt(), "{kind:?}: lag {lag}");
        }
    }
    assert!(errors(&noisy, &ideal, Kind::Thrust).concat().iter().all(|&e| e == 0.0));
}

#[test]
fn imu_has_the_noise_of_its_grade() {
    for (grade, force, rate) in [
        (Grade::Adis, 0.004, 3.394e-4),
        (Grade::Industrial, 1e-3, 1e-4),
        (Grade::Tactical, 5e-4, 3e-5),
    ] {
        let noisy = fly(&Options::nominal(Course::BE1, 3).with_imu(grade));
        let channels = errors(&noisy, &fly(&ideal(Course::BE1, 3)), Kind::Imu);
        for (error, density) in channels.iter().zip([force, force, force, rate, rate, rate]) {
            // Differences contain only the white noise, with twice its variance.
            let steps: Vec<f64> = error.windows(2).map(|w| w[1] - w[0]).collect();
            let sigma = density * 50.0_f64.sqrt();
            assert_relative_eq!(rms(&steps) / 2.0_f64.sqrt(), sigma, max_relative = 0.03);
        }
    }
}

#[test]
fn biases_and_the_initial_error_are_spread_over_seeds() {
    let options = |seed| Options { duration_s: 5.0, ..Options::nominal(Course::BE1, seed) };
    let runs = parallel(0..400, |seed| {
        let noisy = fly(&options(seed));
        let ideal = fly(&Options { ideal: true, ..options(seed) });
        let mean = |error: &Vec<f64>| error.iter().sum::<f64>() / error.len() as f64;
        let imu: Vec<f64> = errors(&noisy, &ideal, Kind::Imu).iter().map(mean).collect();
        (imu, noisy.initial_error)
    });
    let all =
        |pick: fn(&(Vec<f64>, [f64; 2])) -> f64| rms(&runs.iter().map(pick).collect::<Vec<_>>());
    assert_relative_eq!(all(|(imu, _)| imu[2]), 0.196, max_relative = 0.12);
    assert_relative_eq!(all(|(imu, _)| imu[5]), 0.0087, max_relative = 0.12);
    assert_relative_eq!(all(|(_, initial)| initial[0]), 0.5, max_relative = 0.12);
    assert_relative_eq!(all(|(_, initial)| initial[1]), 0.5, max_relative = 0.12);
}

#[test]
fn without_noise_sensors_show_the_truth_at_their_places() {
    let mission = fly(&ideal(Course::BE3, 2));
    let mut seen = 0;
    for event in &mission.events {
        let tenths = event.stamp * 10.0;
        if (tenths - tenths.round()).abs() > 1e-6 {
            continue;
        }
        seen += 1;
        let truth = mission.truth_at(event.stamp);
        let ([x, y, z], nu) = (truth.position, truth.nu);
        let r_nb = rotation(from_euler(truth.euler));
        let down = |place: [f64; 3]| (0..3).map(|i| r_nb[2][i] * place[i]).sum::<f64>();
        match event.data {
            Data::Imu { rate, .. } => assert_eq!(rate, [nu[3], nu[4], nu[5]]),
            Data::Thrust(_) => {}
            Data::Ahrs(euler) => assert_eq!(euler, truth.euler),
            Data::Dvl([u, v, w]) => {
                assert_abs_diff_eq!(u, nu[0] + 0.312 * nu[4], epsilon = 1e-12);
                assert_abs_diff_eq!(v, nu[1] - 1.4 * nu[5] - 0.312 * nu[3], epsilon = 1e-12);
                assert_abs_diff_eq!(w, nu[2] + 1.4 * nu[4], epsilon = 1e-12);
            }
            Data::Fix(place) => assert_eq!(place, [x, y]),
            Data::Depth(depth) => {
                assert_abs_diff_eq!(depth, z + down([-1.32, -0.5, -0.85]), epsilon = 1e-12);
            }
        }
    }
    assert!(seen > 13_000, "{seen}");
}

#[test]
fn heading_bias_and_dvl_scale_add_to_what_sensors_show() {
    let plain = ideal(Course::BE1, 2);
    let biased = fly(&Options { heading_bias: 0.05, dvl_scale: 0.01, ..plain });
    let plain = fly(&plain);
    let yaw = &errors(&biased, &plain, Kind::Ahrs)[2];
    assert!(yaw.iter().all(|e| (e - 0.05).abs() < 1e-12));
    let surge = &errors(&biased, &plain, Kind::Dvl)[0];
    for (error, event) in surge.iter().zip(of(&plain.events, Kind::Dvl)) {
        assert_abs_diff_eq!(*error, 0.01 * event.data.values()[0], epsilon = 1e-12);
    }
}

#[test]
fn integrating_a_perfect_imu_gives_the_path() {
    let mission = fly(&Options { duration_s: 60.0, ..ideal(Course::BE2, 5) });
    let first = mission.truth[0];
    let (mut p, mut q) = (first.position, first.quaternion);
    let start = rotation(q);
    let mut v: [f64; 3] = core::array::from_fn(|i| start[i][0] * first.nu[0]);
    let imu = of(&mission.events, Kind::Imu);
    for pair in imu.windows(2) {
        let (Data::Imu { specific_force: f, rate }, Data::Imu { rate: next, .. }) =
            (pair[0].data, pair[1].data)
        else {
            unreachable!()
        };
        let h = pair[1].stamp - pair[0].stamp;
        let turn: [f64; 3] = core::array::from_fn(|i| 0.25 * (rate[i] + next[i]) * h);
        let [w, x, y, z] = q;
        let half = |[a, b, c]: [f64; 3], s: f64| {
            [
                w - s * (x * a + y * b + z * c),
                x + s * (w * a + y * c - z * b),
                y + s * (w * b + z * a - x * c),
                z + s * (w * c + x * b - y * a),
            ]
        };
        let r_nb = rotation(half(turn, 0.5));
        for i in 0..3 {
            let gravity = if i == 2 { 9.81 } else { 0.0 };
            let a = (0..3).map(|j| r_nb[i][j] * f[j]).sum::<f64>() + gravity;
            p[i] += h * (v[i] + 0.5 * h * a);
            v[i] += h * a;
        }
        q = half(turn, 1.0);
    }
    let end = mission.truth_at(imu[imu.len() - 1].stamp);
    let error: Vec<f64> = (0..3).map(|i| p[i] - end.position[i]).collect();
    assert!(rms(&error) < 0.1, "{error:?}");
}

/// Specific force expected by the model from truth and reported thrust, minus the measured one.
fn residuals(options: &Options, parameters: &Parameters) -> Vec<[f64; 3]> {
    let mut parameters = *parameters;
    parameters.propulsion.mode = ThrusterMode::Force;
    let vehicle = Vehicle::new(&parameters).unwrap();
    let mission = fly(options);
    let (imu, thrust) = (of(&mission.events, Kind::Imu), of(&mission.events, Kind::Thrust));
    let pairs = imu.iter().zip(&thrust).step_by(5).zip(&mission.truth);
    let residual = |((imu, thrust), truth): ((&Event, &Event), &Truth)| {
        let (Data::Imu { specific_force, .. }, Data::Thrust(force)) = (imu.data, thrust.data)
        else {
            unreachable!()
        };
        assert_eq!(imu.stamp, truth.time);
        let [north, east] = truth.current;
        let state = State {
            p_ned: truth.position,
            quaternion: truth.quaternion,
            nu: truth.nu,
            rotor_speed: [0.0; 8],
        };
        let inputs =
            Inputs { thruster_force: force, current_ned: [north, east, 0.0], ..Inputs::default() };
        let expected = vehicle.outputs(&state, &inputs).specific_force;
        core::array::from_fn(|i| specific_force[i] - expected[i])
    };
    pairs.map(residual).collect()
}

fn largest(residuals: &[[f64; 3]]) -> f64 {
    residuals.iter().flatten().fold(0.0, |a, r| a.max(r.abs()))
}

#[test]
fn the_nominal_model_explains_a_calm_mission() {
    let known = Options { current: [0.1, -0.15], ..calm(1) };
    let unknown = [
        Options { thrust_gain_sigma: 0.03, ..known },
        Options { disturbance: [20.0, 0.0], ..known },
        Options { disturbance: [0.0, 10.0], ..known },
        Options { tilt_disturbance: 10.0, ..known },
        Options { lost_thruster: Some((4, 50.0)), ..known },
    ];
    let nominal = Parameters::default();
    assert!(largest(&residuals(&known, &nominal)) < 1e-12);
    for options in unknown {
        assert!(largest(&residuals(&options, &nominal)) > 1e-4, "{options:?}");
    }
}

#[test]
fn a_model_changed_like_the_plant_explains_its_mission() {
    let nominal = Parameters::default();
    let i = nominal.inertia;
    let heavier = Parameters {
        mass: 1.2 * nominal.mass,
        inertia: Inertia {
            xx: 1.2 * i.xx,
            yy: 1.2 * i.yy,
            zz: 1.2 * i.zz,
            xy: 1.2 * i.xy,
            xz: 1.2 * i.xz,
            yz: 1.2 * i.yz,
        },
        // It floats as before.
        buoyancy: Some(nominal.buoyancy_force() + 0.2 * nominal.weight()),
        ..nominal
    };
    let smoother = Parameters {
        linear_damping: nominal.linear_damping.map(|d| 0.8 * d),
        quadratic_damping: nominal.quadratic_damping.map(|d| 0.8 * d),
        ..nominal
    };
    let tender = Parameters { centre_of_buoyancy: [0.0, 0.0, -0.05], ..nominal };
    for (options, parameters) in [
        (Options { mass_scale: 1.2, ..calm(1) }, heavier),
        (Options { damping_scale: 0.8, ..calm(1) }, smoother),
        (Options { metacentre: 0.05, ..calm(1) }, tender),
    ] {
        assert!(largest(&residuals(&options, &nominal)) > 1e-4, "{options:?}");
        assert!(largest(&residuals(&options, &parameters)) < 1e-12, "{options:?}");
    }
}

/// Thrusts of one thruster.
fn thrusts(options: &Options, thruster: usize) -> Vec<f64> {
    let thrust = |e: &Event| e.data.values()[thruster];
    of(&fly(options).events, Kind::Thrust).iter().map(thrust).collect()
}

#[test]
fn a_lost_propeller_is_not_in_the_reported_thrust_but_a_stopped_rotor_is() {
    let healthy = thrusts(&Options { rotor_lag: 0.1, ..calm(1) }, 4);
    let stopped = Options { dead_thruster: Some((4, 50.0)), rotor_lag: 0.1, ..calm(1) };
    assert!(largest(&residuals(&stopped, &Parameters::default())) < 1e-12);
    let stopped = thrusts(&stopped, 4);
    assert_eq!(stopped[..2500], healthy[..2500]);
    // The speed falls to 1/e in 0.1 s, the thrust to its square.
    assert_relative_eq!(stopped[2505] / stopped[2500], (-2.0_f64).exp(), max_relative = 0.01);
    assert!(stopped[2550..].iter().all(|t| t.abs() < 1e-3));

    let lost = Options { lost_thruster: Some((4, 50.0)), ..calm(1) };
    assert!(rms(&thrusts(&lost, 4)[2550..]) > 10.0);
    let missing = |options: &Options| {
        let residuals = residuals(options, &Parameters::default());
        assert!(largest(&residuals[..500]) < 1e-12);
        residuals[500][0]
    };
    let half = Options { lost_fraction: 0.5, ..lost };
    assert!(missing(&half).abs() > 1e-3);
    assert_relative_eq!(missing(&lost), 2.0 * missing(&half), max_relative = 1e-9);
}

#[test]
fn the_disturbance_is_an_ornstein_uhlenbeck_process() {
    let nominal = Parameters::default();
    let mass = nominal.mass + nominal.added_mass[0][0];
    let runs = parallel(0..24, |seed| {
        let options = Options { disturbance: [20.0, 0.0], ..calm(seed) };
        residuals(&options, &nominal).iter().map(|r| r[0] * mass).collect::<Vec<f64>>()
    });
    let sigma = rms(&runs.concat());
    let covariance = |lag: usize| {
        let products = runs.iter().flat_map(|x| x.iter().zip(&x[lag..]).map(|(a, b)| a * b));
        let products: Vec<f64> = products.collect();
        products.iter().sum::<f64>() / products.len() as f64
    };
    assert_relative_eq!(sigma, 20.0, max_relative = 0.1);
    assert_relative_eq!(covariance(50) / covariance(0), (-1.0_f64).exp(), epsilon = 0.1);
}

#[test]
fn missions_repeat_and_their_path_depends_on_no_sensor() {
    let options = Options::nominal(Course::BE1, 11);
    let mission = fly(&options);
    assert_eq!(mission, fly(&options));
    let other = fly(&Options { fix_hz: 0.0, dvl_hz: 3.0, ahrs_hz: 7.0, ..options });
    assert_ne!(of(&mission.events, Kind::Dvl), of(&other.events, Kind::Dvl));
    assert_eq!(of(&mission.events, Kind::Depth).len(), of(&other.events, Kind::Depth).len());
    for (a, b) in mission.truth.iter().zip(&other.truth) {
        // Steps are split at other instants.
        assert!(rms(&[a.position[0] - b.position[0], a.position[1] - b.position[1]]) < 1e-4);
    }
    assert_ne!(mission.truth, fly(&Options::nominal(Course::BE1, 12)).truth);
}

#[test]
fn courses_are_followed_to_their_ends_on_time() {
    for (course, seconds) in [(Course::BE1, 193.0), (Course::BE2, 295.0), (Course::BE3, 321.0)] {
        let mission = fly(&Options::nominal(course, 4));
        let end = mission.truth[mission.truth.len() - 1];
        assert!(mission.finished);
        assert_abs_diff_eq!(end.time, seconds, epsilon = 2.0);
        let course = Course::parse(course).unwrap();
        let far = |t: &Truth| {
            let place = [t.position[0], t.position[1]];
            course.cross_track(place, course.nearest(place, 0.0, course.length())).abs()
        };
        assert!(mission.truth.iter().map(far).fold(0.0, f64::max) < 0.6);
        assert!(mission.truth.iter().all(|t| (t.position[2] - 20.0).abs() < 0.05));
        let count = |hz: f64| (end.time * hz + 1e-6) as usize + 1;
        for (kind, hz) in [
            (Kind::Imu, 50.0),
            (Kind::Thrust, 50.0),
            (Kind::Ahrs, 10.0),
            (Kind::Dvl, 50.0 / 7.0),
            (Kind::Fix, 1.0),
            (Kind::Depth, 10.0),
        ] {
            assert_eq!(of(&mission.events, kind).len(), count(hz), "{kind:?}");
        }
        assert!(mission.events.is_sorted_by(|a, b| a.stamp <= b.stamp));
    }
}

#[test]
fn speed_depth_current_and_position_change_as_chosen() {
    let switching = Speed::Switching { high: 0.3, low: 0.1, period_s: 20.0 };
    let dive = Some(Dive { start_s: 30.0, rate: 0.1, duration_s: 100.0 });
    let options = Options { speed: switching, dive, current: [0.0, 0.2], ..ideal(CIRCLES, 9) };
    let mission = fly(&options);
    assert_abs_diff_eq!(mission.truth_at(15.0).nu[0], 0.3, epsilon = 0.01);
    assert_abs_diff_eq!(mission.truth_at(35.0).nu[0], 0.1, epsilon = 0.01);
    assert_abs_diff_eq!(mission.truth_at(25.0).position[2], 20.0, epsilon = 0.05);
    assert_abs_diff_eq!(mission.truth_at(80.0).position[2], 25.0, epsilon = 0.1);
    assert_abs_diff_eq!(mission.truth_at(150.0).position[2], 30.0, epsilon = 0.05);
    assert_eq!(mission.truth[0].current, [0.0, 0.2]);

    let mission = fly(&Options { kidnap: Some(60.0), ..ideal(Course::BE3, 9) });
    let place = |t: f64| mission.truth_at(t).position;
    let moved = |a: [f64; 3], b: [f64; 3]| (a[0] - b[0]).hypot(a[1] - b[1]);
    assert_abs_diff_eq!(moved(place(60.0), place(59.9)), 10.0, epsilon = 0.05);
    assert!(mission.finished);
}

#[test]
fn faults_act_on_their_sensor_in_their_time() {
    let mission = fly(&Options { duration_s: 30.0, ..Options::nominal(Course::BE1, 6) });
    let changed = |fault: &dyn Fn(&mut Vec<Event>)| {
        let mut events = mission.events.clone();
        fault(&mut events);
        assert!(events.is_sorted_by(|a, b| a.arrival <= b.arrival));
        let others = |events: &[Event], kind| -> Vec<Event> {
            events.iter().filter(|e| e.data.kind() != kind).copied().collect()
        };
        let kind = [Kind::Fix, Kind::Ahrs]
            .into_iter()
            .find(|&kind| of(&events, kind) != of(&mission.events, kind));
        let kind = kind.expect("no effect");
        assert_eq!(others(&events, kind), others(&mission.events, kind));
        of(&events, kind)
    };
    let fixes = of(&mission.events, Kind::Fix);
    let values =
        |events: &[Event]| -> Vec<f64> { events.iter().map(|e| e.data.values()[0]).collect() };

    let dropped = changed(&|e| drop(e, Kind::Fix, 10.0, 20.0));
    assert_eq!(dropped, [&fixes[..10], &fixes[20..]].concat());
    let late = changed(&|e| delay(e, Kind::Fix, 0.5));
    assert!(late.iter().zip(&fixes).all(|(a, b)| a.arrival == b.stamp + 0.5 && a.data == b.data));
    let shuffled = changed(&|e| jitter(e, Kind::Fix, 3.0, 1));
    assert!(!shuffled.is_sorted_by(|a, b| a.stamp <= b.stamp));
    assert!(shuffled.iter().all(|e| (0.0..3.0).contains(&(e.arrival - e.stamp))));

    let wild = changed(&|e| outliers(e, Kind::Fix, 0.3, 10.0, 50.0, 1));
    let off = |(a, b): (&Event, &Event)| {
        let (a, b) = (a.data.values(), b.data.values());
        (a[0] - b[0]).hypot(a[1] - b[1])
    };
    let off: Vec<f64> = wild.iter().zip(&fixes).map(off).filter(|&off| off > 0.0).collect();
    assert!((3..=17).contains(&off.len()), "{off:?}");
    assert!(off.iter().all(|off| (10.0..=50.0).contains(off)), "{off:?}");

    let stuck = values(&changed(&|e| stuck(e, Kind::Fix, 10.0, 20.0)));
    assert!(stuck[9..20].iter().all(|&v| v == stuck[9]) && stuck[20] != stuck[9]);
    let zeros = values(&changed(&|e| zero(e, Kind::Fix, 10.0, 20.0)));
    assert!(zeros[10..20].iter().all(|&v| v == 0.0) && zeros[9] != 0.0 && zeros[20] != 0.0);

    let jumped = changed(&|e| shift_clock(e, Kind::Fix, 10.0, -5.0));
    assert_eq!((jumped[9].stamp, jumped[10].stamp, jumped[10].arrival), (9.0, 5.0, 10.0));
    let turned = changed(&|e| heading_step(e, 10.0, 0.2));
    let ahrs = of(&mission.events, Kind::Ahrs);
    let step = |i: usize| wrap(turned[i].data.values()[2] - ahrs[i].data.values()[2]);
    assert_eq!(step(99), 0.0);
    assert_abs_diff_eq!(step(100), 0.2, epsilon = 1e-12);

    // NaN is not equal to itself.
    let mut events = mission.events.clone();
    nan(&mut events, Kind::Fix, 10.0, 20.0);
    let bad: Vec<bool> = values(&of(&events, Kind::Fix)).iter().map(|v| v.is_nan()).collect();
    assert!(bad[10..20].iter().all(|&b| b) && bad.iter().filter(|&&b| b).count() == 10);
}

#[test]
fn parallel_results_come_in_the_order_of_the_seeds() {
    // The first takes longest.
    let work = |seed| match seed {
        9 => fly(&Options::nominal(Course::BE1, seed)).truth.len() as u64 + seed,
        _ => seed,
    };
    let results = parallel([9, 3, 5, 3], work);
    assert!(results[0] > 1000);
    assert_eq!(results[1..], [3, 5, 3]);
}
