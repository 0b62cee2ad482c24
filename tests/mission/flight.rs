//! The vehicle, its control and its sensors, instant by instant.

use super::instruments::Instruments;
use super::plant::Plant;
use super::{Mission, Options, Truth};
use rexrov::control::{ControllerMemory, ControllerParameters, VelocityController};
use rexrov::guidance::{Course, PurePursuit, PursuitMemory, PursuitParameters};
use rexrov::sensors::Gaussian;
use rexrov::vehicle::Outputs;

/// Period of controller, IMU and plant (ns).
pub(super) const TICK: i64 = 20_000_000;
/// Period of guidance and of the recorded truth (ns).
const CYCLE: i64 = 100_000_000;
const INITIAL_SIGMA: f64 = 0.5;

/// Streams of the seed. Streams below 1000 are those of the instruments.
#[derive(Clone, Copy)]
pub(super) enum Stream {
    Gain = 1000,
    Disturbance,
    Ahrs,
    Dvl,
    Fix,
    Depth,
    Initial,
    Kidnap,
}

pub(super) fn stream(options: &Options, stream: Stream) -> Gaussian {
    Gaussian::new(options.seed, stream as u64)
}

pub(super) fn draw<const N: usize>(noise: &mut Gaussian, sigma: f64) -> [f64; N] {
    core::array::from_fn(|_| sigma * noise.draw())
}

pub(super) fn seconds(ns: i64) -> f64 {
    ns as f64 / 1e9
}

/// Flies a mission.
pub fn fly(options: &Options) -> Mission {
    let mut plant = Plant::new(options);
    let mut pilot = Pilot::new(options);
    let mut instruments = Instruments::new(options);
    let mut mission = Mission {
        truth: Vec::new(),
        events: Vec::new(),
        initial_error: draw(&mut stream(options, Stream::Initial), INITIAL_SIGMA),
        finished: false,
    };
    let mut kidnap = options.kidnap;
    let mut now = 0;
    while seconds(now) <= options.duration_s {
        if kidnap.take_if(|time| seconds(now) >= *time).is_some() {
            plant.jump();
        }
        if now % TICK == 0 {
            plant.disturb();
        }
        let truth = plant.outputs(now);
        if now % CYCLE == 0 {
            mission.truth.push(record(now, &truth, options));
            mission.finished = pilot.steer(now, &truth);
        }
        if now % TICK == 0 {
            plant.command(now, pilot.control(&truth));
        }
        instruments.sample(now, &truth, plant.measured_thrust(), &mut mission.events);
        if mission.finished {
            break;
        }
        let next = instruments.next().min((now / TICK + 1) * TICK);
        plant.advance(seconds(next - now));
        now = next;
    }
    mission
}

fn record(now: i64, truth: &Outputs, options: &Options) -> Truth {
    Truth {
        time: seconds(now),
        position: truth.p_ned,
        euler: truth.euler,
        quaternion: truth.quaternion,
        nu: truth.nu,
        current: options.current,
    }
}

/// Guidance and control with the truth.
struct Pilot<'a> {
    options: &'a Options,
    pursuit: PurePursuit,
    pursuit_memory: PursuitMemory,
    controller: VelocityController,
    controller_memory: ControllerMemory,
    command: [f64; 4],
}

impl<'a> Pilot<'a> {
    fn new(options: &'a Options) -> Self {
        let course = Course::parse(options.course).unwrap();
        Self {
            options,
            pursuit: PurePursuit::new(&PursuitParameters::default(), course).unwrap(),
            pursuit_memory: PursuitMemory::default(),
            controller: VelocityController::new(&ControllerParameters::default()).unwrap(),
            controller_memory: ControllerMemory::default(),
            command: [0.0; 4],
        }
    }

    /// Whether the course is finished.
    fn steer(&mut self, now: i64, truth: &Outputs) -> bool {
        let ([x, y, z], yaw) = (truth.p_ned, truth.euler[2]);
        let guidance = self.pursuit.update(&mut self.pursuit_memory, [x, y, z, yaw]);
        let [_, sway, _, turn_rate] = guidance.command;
        let speed = self.options.speed.at(seconds(now));
        let p = PursuitParameters::default();
        let (depth, rate) = self.options.depth_at(seconds(now));
        let heave = rate + (p.depth_gain * (depth - z)).clamp(-p.heave_limit, p.heave_limit);
        // The same curvature at another speed.
        self.command = [speed, sway, heave, turn_rate * speed / p.speed];
        assert!(now < 3_600_000_000_000, "lost {:.1} m along the course", guidance.distance);
        guidance.finished
    }

    fn control(&mut self, truth: &Outputs) -> [f64; 8] {
        self.controller.update(&mut self.controller_memory, self.command, truth.nu, &[0.0; 8]).force
    }
}
