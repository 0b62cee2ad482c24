//! Runs filters over missions and scores them.
#![allow(dead_code, unreachable_pub, reason = "each test binary uses a part of this module")]

use crate::mission::{self, Data, Event, Mission, Options};
use nalgebra::{Matrix2, Matrix4, Vector2, Vector4};
use rexrov::attitude::wrap;
use rexrov::estimation::*;
use rexrov::vehicle::Parameters;

/// The filters compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    ConstantAcceleration,
    Dynamic,
    Inertial,
    ModelAided,
}

/// A filter's assumptions about a mission: the true noise, the nominal vehicle.
pub fn parameters(options: &Options, initial_error: [f64; 2]) -> NavigationParameters {
    let mut p = NavigationParameters::default();
    let (accelerometer, gyro) = options.imu.noise();
    p.sensors = SensorErrors {
        accelerometer,
        gyro,
        tilt_sigma: options.tilt_sigma,
        heading_sigma: options.heading_sigma,
        dvl_sigma: options.dvl_sigma,
        fix_sigma: options.fix_sigma,
        depth_sigma: options.depth_sigma,
        ..p.sensors
    };
    p.start.position = [initial_error[0], initial_error[1], 20.0];
    p
}

pub fn disturbances(which: Which, options: &Options) -> Disturbances {
    let moment_density = match which {
        Which::Dynamic if options.imu == mission::Grade::Adis => 2.0,
        Which::Dynamic => 5.0,
        _ => 10.0,
    };
    Disturbances { moment_density, ..Disturbances::default() }
}

/// Errors at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    pub time: f64,
    pub error: [f64; 3],
    pub heading: f64,
    pub nees2: f64,
    pub nees4: f64,
    pub sigma2: f64,
}

/// A run of a filter.
#[derive(Clone, Debug)]
pub struct Run {
    pub samples: Vec<Sample>,
    /// Sum of NIS and number, for tilt, heading, depth, velocity log, fix.
    pub nis: [(f64, u32); CHANNELS],
    pub last: Estimate,
    pub path: Vec<Estimate>,
}

impl Run {
    fn empty() -> Self {
        Self {
            samples: Vec::new(),
            nis: [(0.0, 0); CHANNELS],
            last: Estimate::default(),
            path: Vec::new(),
        }
    }
    pub fn rmse(&self, from: f64, to: f64) -> f64 {
        let s: Vec<f64> =
            self.within(from, to).map(|s| s.error[0].powi(2) + s.error[1].powi(2)).collect();
        (s.iter().sum::<f64>() / s.len() as f64).sqrt()
    }
    pub fn rms(&self, from: f64, f: impl Fn(&Sample) -> f64) -> f64 {
        let s: Vec<f64> = self.within(from, f64::MAX).map(|s| f(s).powi(2)).collect();
        (s.iter().sum::<f64>() / s.len() as f64).sqrt()
    }
    pub fn mean(&self, from: f64, to: f64, f: impl Fn(&Sample) -> f64) -> f64 {
        let s: Vec<f64> = self.within(from, to).map(f).collect();
        s.iter().sum::<f64>() / s.len() as f64
    }
    pub fn at(&self, time: f64) -> &Sample {
        self.samples.iter().find(|s| (s.time - time).abs() < 1e-6).unwrap()
    }
    pub fn final_error(&self, time: f64) -> f64 {
        let s = self.at(time);
        s.error[0].hypot(s.error[1])
    }
    fn within(&self, from: f64, to: f64) -> impl Iterator<Item = &Sample> {
        self.samples.iter().filter(move |s| s.time >= from && s.time < to)
    }
}

pub fn run(
    which: Which,
    options: &Options,
    mission: &Mission,
    change: impl Fn(&mut NavigationParameters),
) -> Run {
    with_process(which, options, mission, change, Follow)
}

/// The smoothed estimate at every tenth of a second.
pub fn smooth(
    which: Which,
    options: &Options,
    mission: &Mission,
    change: impl Fn(&mut NavigationParameters),
) -> Run {
    with_process(which, options, mission, change, Smooth)
}

/// What to do with a filter.
trait Use {
    fn with(self, filter: &(impl Navigation + Smoothing), mission: &Mission) -> Run;
}

struct Follow;
struct Smooth;

impl Use for Follow {
    fn with(self, filter: &(impl Navigation + Smoothing), mission: &Mission) -> Run {
        follow_navigation(filter, mission)
    }
}

impl Use for Smooth {
    fn with(self, filter: &(impl Navigation + Smoothing), mission: &Mission) -> Run {
        let mut recording = filter.recording();
        let mut measured = Measurements::default();
        for at_once in mission.events.chunk_by(|a, b| a.arrival == b.arrival) {
            at_once.iter().for_each(|event| set(&mut measured, event));
            recording.add(at_once[0].arrival, &measured);
        }
        let mut run = Run::empty();
        for Smoothed { time, estimate } in filter.smooth(&recording) {
            run.samples.push(score(&estimate, mission.truth_at(time)));
            run.path.push(estimate);
        }
        run
    }
}

fn with_process(
    which: Which,
    options: &Options,
    mission: &Mission,
    change: impl Fn(&mut NavigationParameters),
    what: impl Use,
) -> Run {
    let mut p = parameters(options, mission.initial_error);
    change(&mut p);
    let vehicle = Parameters::default();
    let d = disturbances(which, options);
    let errors = ModelErrors { disturbances: d, ..ModelErrors::default() };
    match which {
        Which::ConstantAcceleration => {
            let process = ConstantAcceleration::new(&p).unwrap();
            what.with(&ConstantAccelerationFilter::new(process, &p).unwrap(), mission)
        }
        Which::Dynamic => {
            let process = PlanarDynamic::new(&p, &vehicle, &d).unwrap();
            what.with(&DynamicFilter::new(process, &p).unwrap(), mission)
        }
        Which::Inertial => {
            let process = InertialProcess::new(&p, None).unwrap();
            what.with(&InertialFilter::new(process, &p).unwrap(), mission)
        }
        Which::ModelAided => what.with(&AidedFilter::new(&p, &vehicle, &errors).unwrap(), mission),
    }
}

/// Feeds the events as they arrive, and scores at every tenth of a second.
pub fn follow_navigation(filter: &impl Navigation, mission: &Mission) -> Run {
    let mut memory = filter.memory();
    let mut measured = Measurements::default();
    let mut run = Run::empty();
    let mut used = [0; CHANNELS];
    let mut i = 0;
    for truth in &mission.truth {
        while let Some(event) = mission.events.get(i).filter(|e| e.arrival <= truth.time + 1e-9) {
            let now = event.arrival;
            while let Some(event) = mission.events.get(i).filter(|e| e.arrival <= now + 1e-9) {
                set(&mut measured, event);
                i += 1;
            }
            let estimate = filter.update(&mut memory, now, &measured);
            for ((channel, used), nis) in estimate.channels.iter().zip(&mut used).zip(&mut run.nis)
            {
                if channel.used > *used {
                    *used = channel.used;
                    if now > 30.0 {
                        nis.0 += channel.nis;
                        nis.1 += 1;
                    }
                }
            }
        }
        let estimate = filter.update(&mut memory, truth.time, &measured);
        run.samples.push(score(&estimate, truth));
        run.path.push(estimate);
        run.last = estimate;
    }
    run
}

pub fn set(m: &mut Measurements, e: &Event) {
    let s = e.stamp;
    match e.data {
        Data::Imu { specific_force: [a, b, c], rate: [p, q, r] } => {
            m.imu = Reading::at(s, [a, b, c, p, q, r])
        }
        Data::Thrust(t) => m.thrust = Reading::at(s, t),
        Data::Ahrs(a) => m.ahrs = Reading::at(s, a),
        Data::Dvl(v) => m.dvl = Reading::at(s, v),
        Data::Fix([x, y]) => m.fix = Reading::at(s, [x, y, 0.0]),
        Data::Depth(z) => m.depth = Reading::at(s, [z]),
    }
}

fn score(e: &Estimate, truth: &mission::Truth) -> Sample {
    let error: [f64; 3] = core::array::from_fn(|i| e.position[i] - truth.position[i]);
    let heading = wrap(e.euler[2] - truth.euler[2]);
    let p = &e.covariance;
    let p2 = Matrix2::new(p[0][0], p[0][1], p[1][0], p[1][1]);
    let e2 = Vector2::new(error[0], error[1]);
    let index = [0, 1, 2, 5];
    let p4 = Matrix4::from_fn(|i, j| p[index[i]][index[j]]);
    let e4 = Vector4::new(error[0], error[1], error[2], heading);
    Sample {
        time: truth.time,
        error,
        heading,
        nees2: e2.dot(&(p2.try_inverse().unwrap() * e2)),
        nees4: e4.dot(&(p4.try_inverse().unwrap() * e4)),
        sigma2: p[0][0] + p[1][1],
    }
}

pub fn quantile(values: &[f64], q: f64) -> f64 {
    let mut v = values.to_vec();
    v.sort_by(f64::total_cmp);
    v[((v.len() - 1) as f64 * q).round() as usize]
}
