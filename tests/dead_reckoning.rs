//! Logs of a velocity log, an attitude and a depth, without an inertial unit and without thrusts.

#[path = "mission/mod.rs"]
mod mission;
#[path = "scoring/mod.rs"]
mod scoring;

use mission::*;
use rexrov::attitude::wrap;
use rexrov::estimation::process::Process;
use rexrov::estimation::*;
use rexrov::guidance::Course;
use rexrov::sensors::Gaussian;
use rexrov::vehicle::Parameters;
use scoring::{LARGE, SMALL, Run, follow_navigation, parameters, set};

const HEADING_BIAS: f64 = 0.1;
const SCALE: f64 = 0.02;
const MISALIGNMENT: f64 = 0.02;

/// Speed and heading change; the velocity log gives a sample a second.
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

/// What is wrong with the sensors.
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
            follow_navigation(&Filter::<_, SMALL>::new(process, p).unwrap(), m)
        }),
        ("model-aided", |p, m| {
            let (vehicle, d) = (Parameters::default(), Disturbances::default());
            follow_navigation(&AidedFilter::new(p, &vehicle, &d).unwrap(), m)
        }),
    ]
}

fn log() -> Mission {
    let mut mission = fly(&options());
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

#[test]
fn what_a_velocity_log_cannot_observe_does_not_bend_the_path() {
    let mission = log();
    let wrong =
        Wrong { heading_bias: HEADING_BIAS, scale: -SCALE, misalignment: MISALIGNMENT };
    for mission in [mission.clone(), spoil(&mission, wrong)] {
        for (name, follow) in filters() {
            let plain = follow(&start(&options()), &mission);
            let doubting = follow(&doubting(&options()), &mission);
            let apart = plain.path.iter().zip(&doubting.path).map(|(a, b)| {
                (a.position[0] - b.position[0]).hypot(a.position[1] - b.position[1])
            });
            let widest = apart.fold(0.0, f64::max) / distance(&mission);
            println!("{name}: {:.4} % apart", 100.0 * widest);
            assert!(widest < 1e-3, "{name}: {:.3} % of the distance apart", 100.0 * widest);
        }
    }
}

#[test]
fn the_claimed_uncertainty_covers_what_cannot_be_observed() {
    let mission = log();
    let wrong = Wrong { heading_bias: HEADING_BIAS, scale: SCALE, misalignment: -MISALIGNMENT };
    let one_sigma = spoil(&mission, wrong);
    let mut normal = Gaussian::new(1, 3000_u64);
    let drawn: Vec<Mission> = (0..24)
        .map(|_| {
            let [a, b, c] = core::array::from_fn(|_| normal.draw());
            let (heading_bias, scale) = (a * HEADING_BIAS, b * SCALE);
            spoil(&mission, Wrong { heading_bias, scale, misalignment: c * MISALIGNMENT })
        })
        .collect();
    for (name, follow) in filters() {
        let p = doubting(&options());
        let last = *follow(&p, &one_sigma).samples.last().unwrap();
        let error = last.error[0].hypot(last.error[1]);
        println!("{name}: {error:.2} m, sigma {:.2} m, NEES {:.2}", last.sigma2.sqrt(), last.nees2);
        assert!(last.nees2 < 5.99, "{name}: {last:?}");
        let nees = parallel(0..24, |k| follow(&p, &drawn[k as usize]).samples.last().unwrap().nees2);
        let mean = nees.iter().sum::<f64>() / nees.len() as f64;
        println!("{name}: mean NEES {mean:.2}");
        // 99.9 % of the mean of 24 pairs: chi-square of 48 degrees of freedom.
        assert!((0.95..3.6).contains(&mean), "{name}: mean NEES {mean} of 2");
    }
}

/// Follows a mission; the belief at its end, and the error of the position there (m).
fn end<P: Process<N>, const N: usize>(
    filter: &Filter<P, N>,
    mission: &Mission,
) -> (Belief<N>, f64) {
    let (mut memory, mut measured) = (filter.memory(), Measurements::default());
    let mut estimate = filter.update(&mut memory, 0.0, &measured);
    for event in &mission.events {
        set(&mut measured, event);
        estimate = filter.update(&mut memory, event.arrival, &measured);
    }
    let truth = mission.truth.last().unwrap();
    estimate = filter.update(&mut memory, truth.time, &measured);
    let [x, y] = [0, 1].map(|i| estimate.position[i] - truth.position[i]);
    (*memory.belief().unwrap(), x.hypot(y))
}

#[test]
fn the_delay_of_a_velocity_log_is_learned_from_fixes() {
    const DELAY: f64 = 0.3;
    const STATE: usize = 15;
    let o = Options { fix_sigma: 0.1, ..options() };
    let mut mission = fly(&o);
    keep(&mut mission, &[Kind::Ahrs, Kind::Dvl, Kind::Depth, Kind::Fix]);
    drop(&mut mission.events, Kind::Fix, 0.5 * o.duration_s, f64::MAX);
    for event in mission.events.iter_mut().filter(|e| e.data.kind() == Kind::Dvl) {
        event.stamp += DELAY;
    }
    delay(&mut mission.events, Kind::Dvl, DELAY);
    let mut p = start(&o);
    let without = p;
    p.sensors.dvl_delay_sigma = DELAY;
    macro_rules! check {
        ($name:expr, $make:expr) => {{
            let make = $make;
            let (belief, error) = end(&make(&p), &mission);
            let (mean, sigma) = (belief.mean[STATE], belief.covariance[(STATE, STATE)].sqrt());
            let (_, plain) = end(&make(&without), &mission);
            println!("{}: delay {mean:.3} sigma {sigma:.3} s, {error:.2} m, without {plain:.2} m", $name);
        }};
    }
    let (v, d) = (Parameters::default(), Disturbances::default());
    check!("constant acceleration", |p: &NavigationParameters| {
        Filter::<_, SMALL>::new(ConstantAcceleration::new(p).unwrap(), p).unwrap()
    });
    check!("dynamic", |p: &NavigationParameters| {
        Filter::<_, SMALL>::new(PlanarDynamic::new(p, &v, &d).unwrap(), p).unwrap()
    });
    check!("inertial", |p: &NavigationParameters| {
        Filter::<_, SMALL>::new(InertialProcess::new(p, None).unwrap(), p).unwrap()
    });
    check!("model-aided without thrusts", |p: &NavigationParameters| {
        let aid = ModelAid::new(&v, &d).unwrap();
        Filter::<_, LARGE>::new(InertialProcess::new(p, Some(aid)).unwrap(), p).unwrap()
    });
}
