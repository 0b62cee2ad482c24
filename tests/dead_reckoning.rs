//! Logs of a velocity log, an attitude and a depth, without an inertial unit and without thrusts.

use crate::mission::{
    DVL_POSITION, Data, Event, Kind, Mission, Options, Speed, Truth, delay, drop, fly, parallel,
};
use crate::scoring::{Run, follow_navigation, parameters, set};
use rexrov::attitude::{from_euler, wrap};
use rexrov::estimation::{
    AidedFilter, Belief, Disturbances, DynamicFilter, InertialFilter, InertialProcess,
    Measurements, Memory, ModelErrors, Navigation, NavigationParameters, PlanarDynamic,
    UnmonitoredDynamicFilter,
};
use rexrov::guidance::Course;
use rexrov::sensors::Gaussian;
use rexrov::vehicle::Parameters;

const HEADING_BIAS: f64 = 0.1;
const SCALE: f64 = 0.02;
const MISALIGNMENT: f64 = 0.02;

/// Speed and heading change; the velocity log gives one sample per second.
fn options() -> Options {
    Options {
        speed: Speed::Switching { high: 0.5, low: 0.15, period_s: 12.0 },
        dvl_hz: 1.0,
        duration_s: 240.0,
        ..Options::nominal(Course::BE3, 1)
    }
}

fn keep(mission: &mut Mission, kinds: &[Kind]) {
    mission.events.retain(|e| kinds.contains(&e.data.kind()));
}

/// Sensor errors.
#[derive(Clone, Copy)]
struct Wrong {
    heading_bias: f64,
    scale: f64,
    misalignment: f64,
}

fn spoil(mission: &Mission, wrong: Wrong) -> Mission {
    let mut spoilt = mission.clone();
    let (sin, cos) = wrong.misalignment.sin_cos();
    for event in &mut spoilt.events {
        match &mut event.data {
            Data::Ahrs([.., yaw]) => *yaw = wrap(*yaw + wrong.heading_bias),
            Data::Dvl(v) => {
                let [x, y, z] = v.map(|v| v * (1.0 + wrong.scale));
                *v = [cos * x + sin * y, cos * y - sin * x, z];
            }
            _ => {}
        }
    }
    spoilt
}

/// A filter that knows the position at the start.
fn start(o: &Options) -> NavigationParameters {
    let mut p = parameters(o, [0.0; 2]);
    p.start.position_sigma = [0.01, 0.01, 0.5];
    p.sensors.heading_bias_sigma = 0.0;
    p
}

fn doubting(o: &Options) -> NavigationParameters {
    let mut p = start(o);
    p.sensors.heading_bias_sigma = HEADING_BIAS;
    p.sensors.dvl_scale_sigma = SCALE;
    p.sensors.dvl_misalignment_sigma = MISALIGNMENT;
    p
}

/// A filter's run.
type Follow = fn(&NavigationParameters, &Mission) -> Run;

/// All filters that coast without an inertial unit.
fn filters() -> [(&'static str, Follow); 3] {
    [
        ("dynamic", |p, m| {
            let (vehicle, d) = (Parameters::default(), Disturbances::default());
            let process = PlanarDynamic::new(p, &vehicle, &d).unwrap();
            follow_navigation(&DynamicFilter::new(process, p).unwrap(), m)
        }),
        ("inertial", |p, m| {
            let process = InertialProcess::new(p, None).unwrap();
            follow_navigation(&InertialFilter::new(process, p).unwrap(), m)
        }),
        ("model-aided", |p, m| {
            let (vehicle, d) = (Parameters::default(), ModelErrors::default());
            follow_navigation(&AidedFilter::new(p, &vehicle, &d).unwrap(), m)
        }),
    ]
}

fn log(options: &Options) -> Mission {
    let mut mission = fly(options);
    keep(&mut mission, &[Kind::Ahrs, Kind::Dvl, Kind::Depth]);
    mission
}

fn distance(mission: &Mission) -> f64 {
    let steps = mission.truth.windows(2).map(|pair| {
        let [x, y] = [0, 1].map(|i| pair[1].position[i] - pair[0].position[i]);
        x.hypot(y)
    });
    steps.sum()
}

/// Largest difference of two paths.
fn apart(a: &Run, b: &Run) -> f64 {
    let pairs = a.path.iter().zip(&b.path);
    let distances = pairs.map(|(a, b)| {
        let [x, y] = [0, 1].map(|i| a.position[i] - b.position[i]);
        x.hypot(y)
    });
    distances.fold(0.0, f64::max)
}

/// With a depth the filters treat the cause of vertical motion as weak information about the scale.
#[test]
fn what_a_velocity_log_cannot_observe_does_not_bend_the_path() {
    let wrong = Wrong { heading_bias: HEADING_BIAS, scale: -SCALE, misalignment: MISALIGNMENT };
    for sigma in [0.002, 0.01] {
        let o = Options { tilt_sigma: sigma, heading_sigma: sigma, ..options() };
        let right = log(&o);
        for depth in [false, true] {
            for mut mission in [right.clone(), spoil(&right, wrong)] {
                if !depth {
                    keep(&mut mission, &[Kind::Ahrs, Kind::Dvl]);
                }
                for (name, follow) in filters() {
                    let (plain, doubting) =
                        (follow(&start(&o), &mission), follow(&doubting(&o), &mission));
                    let off = apart(&plain, &doubting) / distance(&mission);
                    println!("{name}, {sigma} rad, depth {depth}: {off:.2e}");
                    assert!(off < 1e-3, "{name}, {sigma} rad, depth {depth}: {off:.2e}");
                }
            }
        }
    }
}

#[test]
fn the_claimed_uncertainty_covers_what_cannot_be_observed() {
    let mission = log(&options());
    let wrong = Wrong { heading_bias: HEADING_BIAS, scale: SCALE, misalignment: -MISALIGNMENT };
    let one_sigma = spoil(&mission, wrong);
    let mut normal = Gaussian::new(1, 3000_u64);
    let draw = |seed| {
        let [a, b, c] = core::array::from_fn(|_| normal.draw());
        let (heading_bias, scale) = (a * HEADING_BIAS, b * SCALE);
        spoil(
            &log(&Options { seed, ..options() }),
            Wrong { heading_bias, scale, misalignment: c * MISALIGNMENT },
        )
    };
    let drawn: Vec<Mission> = (1..25).map(draw).collect();
    for (name, follow) in filters() {
        let p = doubting(&options());
        let last = *follow(&p, &one_sigma).samples.last().unwrap();
        assert!(last.nees2 < 5.99, "{name}: {last:?}");
        let nees =
            parallel(0..24, |k| follow(&p, &drawn[k as usize]).samples.last().unwrap().nees2);
        let mean = nees.iter().sum::<f64>() / nees.len() as f64;
        // 99.9 % of the mean of 24 pairs: chi-square of 48 degrees of freedom.
        assert!((0.95..3.6).contains(&mean), "{name}: mean NEES {mean} of 2");
    }
}

/// Follows a mission; returns the belief at its end, and the error of the position there (m).
fn end<const N: usize>(
    filter: &impl Navigation<Memory = Memory<N>>,
    mission: &Mission,
) -> (Belief<N>, f64) {
    let (mut memory, mut measured) = (filter.memory(), Measurements::default());
    filter.update(&mut memory, 0.0, &measured);
    for event in &mission.events {
        set(&mut measured, event);
        filter.update(&mut memory, event.arrival, &measured);
    }
    let truth = mission.truth.last().unwrap();
    let estimate = filter.update(&mut memory, truth.time, &measured);
    let [x, y] = [0, 1].map(|i| estimate.position[i] - truth.position[i]);
    (*memory.belief().unwrap(), x.hypot(y))
}

/// While only the velocity log shows how the velocity changes, its delay is not observable; with
/// thrusts or accelerometers it is.
#[test]
fn the_delay_of_a_velocity_log_is_learned_from_fixes() {
    const DELAY: f64 = 0.3;
    const STATE: usize = 15;
    let o = Options { fix_sigma: 0.1, ..options() };
    let mut flown = fly(&o);
    drop(&mut flown.events, Kind::Fix, 0.5 * o.duration_s, f64::MAX);
    for event in flown.events.iter_mut().filter(|e| e.data.kind() == Kind::Dvl) {
        event.stamp += DELAY;
    }
    delay(&mut flown.events, Kind::Dvl, DELAY);
    let mut p = start(&o);
    p.sensors.dvl_delay_sigma = DELAY;
    let log = [Kind::Ahrs, Kind::Dvl, Kind::Depth, Kind::Fix];
    let with = |kind: Kind| {
        let mut mission = flown.clone();
        keep(&mut mission, &[&log[..], &[kind]].concat());
        mission
    };
    let (vehicle, d) = (Parameters::default(), Disturbances::default());
    let dynamic =
        UnmonitoredDynamicFilter::new(PlanarDynamic::new(&p, &vehicle, &d).unwrap(), &p).unwrap();
    let inertial = InertialFilter::new(InertialProcess::new(&p, None).unwrap(), &p).unwrap();
    let ends = [end(&dynamic, &with(Kind::Thrust)), end(&inertial, &with(Kind::Imu))];
    for (belief, error) in ends {
        let (mean, sigma) = (belief.mean[STATE], belief.covariance[(STATE, STATE)].sqrt());
        println!("delay {mean:.3} sigma {sigma:.3} s, {error:.2} m");
        assert!(sigma < 0.2 * DELAY, "sigma {sigma} s");
        // A delay is a first-order term of the prediction; a speed that steps has others.
        assert!((mean - DELAY).abs() < 0.1, "delay {mean} s, sigma {sigma} s");
        assert!(error < 5e-3 * distance(&flown), "{error} m");
    }
    let mut mission = flown.clone();
    keep(&mut mission, &log);
    let (belief, error) = end(&inertial, &mission);
    assert_eq!((belief.mean[STATE], belief.covariance[(STATE, STATE)]), (0.0, DELAY * DELAY));
    assert!(error < 1e-2 * distance(&flown), "{error} m");
}

/// A vehicle that slips outwards in turns, `v' = (-r - v) / slip`, surveys an area at 1.5 m/s;
/// attitude and velocity log give one sample per second, at the same instants.
fn survey(slip: f64, seed: u64) -> Mission {
    const DT: f64 = 0.1;
    const SPEED: f64 = 1.5;
    let mut normal = Gaussian::new(seed, 4000_u64);
    let (mut p, mut yaw, mut r, mut v) = ([0.0; 2], 0.3_f64, 0.0, 0.0);
    let mut mission =
        Mission { truth: Vec::new(), events: Vec::new(), initial_error: [0.0; 2], finished: true };
    for k in 0..4000 {
        let time = f64::from(k) * DT;
        let euler = [0.0, 0.0, wrap(yaw)];
        mission.truth.push(Truth {
            time,
            position: [p[0], p[1], 20.0],
            euler,
            quaternion: from_euler(euler),
            nu: [SPEED, v, 0.0, 0.0, 0.0, r],
            current: [0.0; 2],
        });
        if k % 10 == 0 {
            let noisy = euler.map(|angle| angle + 0.002 * normal.draw());
            let log = [SPEED, v + DVL_POSITION[0] * r, 0.0].map(|x| x + 0.01 * normal.draw());
            for data in [Data::Ahrs(noisy), Data::Dvl(log)] {
                mission.events.push(Event { stamp: time, arrival: time, data });
            }
        }
        // Legs of 35 s; the turns between them take 15 s, two to starboard and two to port.
        let turning = time % 50.0 > 35.0;
        let side = if (time / 100.0) as i32 % 2 == 0 { 1.0 } else { -1.0 };
        let wanted = if turning { 0.2 * side } else { 0.0 };
        r += (wanted - r) * DT;
        v += (-r - v) / slip * DT;
        let (sin, cos) = yaw.sin_cos();
        p = [p[0] + (SPEED * cos - v * sin) * DT, p[1] + (SPEED * sin + v * cos) * DT];
        yaw += r * DT;
    }
    mission
}

/// Start and noise of [`survey`].
fn surveying() -> NavigationParameters {
    let mut p = start(&options());
    p.start.attitude = [0.0, 0.0, 0.3];
    (p.sensors.tilt_sigma, p.sensors.heading_sigma) = (0.002, 0.002);
    p.sensors.dvl_sigma = 0.01;
    p
}

/// Early stamps of the velocity log: its sway matches turns that come later.
#[test]
fn a_velocity_log_that_is_stamped_early_is_put_right() {
    const LEAD: f64 = 1.3;
    for slip in [0.5, 1.0] {
        let mut mission = survey(slip, 1);
        for event in mission.events.iter_mut().filter(|e| e.data.kind() == Kind::Dvl) {
            event.stamp = (event.stamp - LEAD).max(0.0);
        }
        for (name, follow) in filters() {
            let (p, mut trusting) = (surveying(), surveying());
            trusting.gated = false;
            let [error, trusting] =
                [p, trusting].map(|p| follow(&p, &mission).rmse(200.0, f64::MAX));
            println!("{name}, slip {slip} s: {error:.2} m, trusting {trusting:.2} m");
            assert!(error < 0.6 * trusting, "{name}, slip {slip} s: {error}, {trusting} m");
        }
    }
}

/// Slip comes after the turn, and so does a late log: neither is a lead.
#[test]
fn a_velocity_log_with_right_or_late_stamps_is_left_alone() {
    for slip in [0.2, 1.0, 3.0] {
        for late in [0.0, 0.4, 1.0] {
            let mut mission = survey(slip, 2);
            delay(&mut mission.events, Kind::Dvl, late);
            for event in mission.events.iter_mut().filter(|e| e.data.kind() == Kind::Dvl) {
                event.stamp += late;
            }
            let (p, mut trusting) = (surveying(), surveying());
            trusting.gated = false;
            for (name, follow) in filters() {
                let off = apart(&follow(&p, &mission), &follow(&trusting, &mission));
                println!("{name}, slip {slip} s, {late} s late: {off:.3} m apart");
                assert!(off < 2e-4 * distance(&mission), "{name}, {slip}, {late}: {off} m");
            }
        }
    }
}

/// The rate for the lever arm is tracked: neither the noise of a fast attitude nor the second
/// between slow ones makes the velocity uncertain.
#[test]
fn attitudes_tell_the_rate_at_any_rate_of_theirs() {
    for (hz, attitude_sigma) in [(1.0, 0.002), (10.0, 0.01), (50.0, 0.01)] {
        let o = Options {
            ahrs_hz: hz,
            tilt_sigma: attitude_sigma,
            heading_sigma: attitude_sigma,
            ..options()
        };
        let mission = log(&o);
        let p = start(&o);
        let inertial = InertialFilter::new(InertialProcess::new(&p, None).unwrap(), &p).unwrap();
        let run = follow_navigation(&inertial, &mission);
        let pairs = run.path.iter().zip(&mission.truth).skip(200);
        let squares = pairs.map(|(e, truth)| (e.velocity[1] - truth.nu[1]).powi(2));
        let rms = (squares.clone().sum::<f64>() / squares.count() as f64).sqrt();
        let claimed = run.last.velocity_sigma[1];
        println!("{hz} Hz: sway off by {rms:.3} m/s, sigma {claimed:.3} m/s");
        assert!(rms < 0.1 && claimed < 0.2, "{hz} Hz: {rms}, sigma {claimed}");
    }
}
