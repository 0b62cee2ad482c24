//! The vehicle, its control and its sensors from instant to instant.

use super::{DEPTH_POSITION, DVL_POSITION, Data, Event, Mission, Options, Truth};
use rexrov::attitude::{rotation, wrap};
use rexrov::control::{ControllerMemory, ControllerParameters, VelocityController};
use rexrov::guidance::{Course, PurePursuit, PursuitMemory, PursuitParameters};
use rexrov::sensors::{BiasNoise, Gaussian, Imu, ImuMemory, ImuParameters, ImuTruth};
use rexrov::vehicle::{Inputs, Outputs, Parameters, Propulsion, State, Vehicle};

/// Period of controller, IMU and plant (ns).
const TICK: i64 = 20_000_000;
/// Period of guidance and of the recorded truth (ns).
const CYCLE: i64 = 100_000_000;
const DISTURBANCE_TIME: f64 = 5.0;
const START: [f64; 3] = [0.0, 0.0, 20.0];
const KIDNAP_DISTANCE: f64 = 10.0;
const INITIAL_SIGMA: f64 = 0.5;

/// Streams of the seed. The IMU uses the first ones.
#[derive(Clone, Copy)]
enum Stream {
    Gain = 16,
    Disturbance,
    Ahrs,
    Dvl,
    Fix,
    Depth,
    Initial,
    Kidnap,
}

fn stream(options: &Options, stream: Stream) -> Gaussian {
    Gaussian::new(options.seed, stream as u64)
}

fn draw<const N: usize>(noise: &mut Gaussian, sigma: f64) -> [f64; N] {
    core::array::from_fn(|_| sigma * noise.draw())
}

fn seconds(ns: i64) -> f64 {
    ns as f64 / 1e9
}

/// Flies a mission.
pub fn fly(options: &Options) -> Mission {
    let mut plant = Plant::new(options);
    let mut pilot = Pilot::new(options);
    let mut sensors = Sensors::new(options);
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
            plant.jump(options);
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
        sensors.sample(now, &truth, plant.measured_thrust(), &mut mission.events);
        if mission.finished {
            break;
        }
        let next = sensors.next().min((now / TICK + 1) * TICK);
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

/// The vehicle under its disturbances, with thrusters of unequal gain.
struct Plant<'a> {
    options: &'a Options,
    vehicle: Vehicle,
    propulsion: Propulsion,
    columns: [[f64; 6]; 8],
    gain_error: [f64; 8],
    disturbance: [f64; 6],
    disturbance_noise: Gaussian,
    state: State,
    /// Commands and current.
    inputs: Inputs,
}

impl<'a> Plant<'a> {
    fn new(options: &'a Options) -> Self {
        let nominal = Parameters::default();
        let mut parameters = nominal;
        parameters.mass *= options.mass_scale;
        let i = &mut parameters.inertia;
        for element in [&mut i.xx, &mut i.yy, &mut i.zz, &mut i.xy, &mut i.xz, &mut i.yz] {
            *element *= options.mass_scale;
        }
        let ballast = parameters.weight() - nominal.weight();
        parameters.buoyancy = Some(nominal.buoyancy_force() + ballast);
        let scaled = |d: [f64; 6]| d.map(|x| options.damping_scale * x);
        parameters.linear_damping = scaled(nominal.linear_damping);
        parameters.quadratic_damping = scaled(nominal.quadratic_damping);
        let [north, east] = options.current;
        let mut disturbance_noise = stream(options, Stream::Disturbance);
        let normal = draw(&mut disturbance_noise, 1.0);
        let mut state = State::at_rest(START, [0.0; 3]);
        state.nu[0] = options.speed.at(0.0);
        Self {
            options,
            vehicle: Vehicle::new(&parameters).unwrap(),
            propulsion: parameters.propulsion,
            columns: parameters.propulsion.thrusters.map(|t| t.unit_wrench()),
            gain_error: draw(&mut stream(options, Stream::Gain), options.thrust_gain_sigma),
            disturbance: scaled_by(&disturbance_sigma(options), &normal),
            disturbance_noise,
            state,
            inputs: Inputs { current_ned: [north, east, 0.0], ..Inputs::default() },
        }
    }

    fn jump(&mut self, options: &Options) {
        let [a, b] = draw(&mut stream(options, Stream::Kidnap), 1.0);
        let scale = KIDNAP_DISTANCE / f64::hypot(a, b);
        self.state.p_ned[0] += scale * a;
        self.state.p_ned[1] += scale * b;
    }

    /// The disturbance of the next tick; the first one is there from the start.
    fn disturb(&mut self) {
        let decay = (-seconds(TICK) / DISTURBANCE_TIME).exp();
        let sigma = disturbance_sigma(self.options).map(|s| s * (1.0 - decay * decay).sqrt());
        let normal = draw(&mut self.disturbance_noise, 1.0);
        let drive = scaled_by(&sigma, &normal);
        self.disturbance = core::array::from_fn(|i| decay * self.disturbance[i] + drive[i]);
    }

    fn command(&mut self, now: i64, mut force: [f64; 8]) {
        let since = |time: f64| seconds(now) >= time;
        if let Some((i, _)) = self.options.dead_thruster.filter(|(_, time)| since(*time)) {
            force[i] = 0.0;
        }
        self.inputs.thruster_force = force;
    }

    /// Wrench of what the thrusters give more than their rotor speeds say, and the disturbance.
    fn extra(&self, thrust: &[f64; 8]) -> [f64; 6] {
        let mut wrench = self.disturbance;
        for i in 0..8 {
            let surplus = self.gain_error[i] * thrust[i];
            for (w, c) in wrench.iter_mut().zip(&self.columns[i]) {
                *w += surplus * c;
            }
        }
        wrench
    }

    fn outputs(&mut self, now: i64) -> Outputs {
        let lost = self.options.lost_thruster.filter(|(_, time)| seconds(now) >= *time);
        if let Some((i, _)) = lost {
            self.gain_error[i] = -self.options.lost_fraction;
        }
        let inputs = Inputs { wrench: self.extra(&self.measured_thrust()), ..self.inputs };
        self.vehicle.outputs(&self.state, &inputs)
    }

    fn measured_thrust(&self) -> [f64; 8] {
        self.state.rotor_speed.map(|speed| self.propulsion.thrust(speed))
    }

    /// The rotors' way is known in advance: Simpson's rule gives the mean surplus of a step.
    fn advance(&mut self, h: f64) {
        let p = &self.propulsion;
        let target = self.inputs.thruster_force.map(|force| p.speed(force));
        let thrust_after = |time: f64| {
            let rest = (-time / p.rotor_time_constant).exp();
            let speed = |i: usize| target[i] + rest * (self.state.rotor_speed[i] - target[i]);
            core::array::from_fn(|i| p.thrust(speed(i)))
        };
        let (begin, middle, end): ([f64; 8], [f64; 8], [f64; 8]) =
            (self.measured_thrust(), thrust_after(0.5 * h), thrust_after(h));
        let mean = core::array::from_fn(|i| (begin[i] + 4.0 * middle[i] + end[i]) / 6.0);
        let inputs = Inputs { wrench: self.extra(&mean), ..self.inputs };
        self.vehicle.step(&mut self.state, &inputs, h);
    }
}

fn disturbance_sigma(options: &Options) -> [f64; 6] {
    let ([force, moment], tilt) = (options.disturbance, options.tilt_disturbance);
    [force, force, force, tilt, tilt, moment]
}

fn scaled_by(sigma: &[f64; 6], normal: &[f64; 6]) -> [f64; 6] {
    core::array::from_fn(|i| sigma[i] * normal[i])
}

/// Guidance and control on the truth.
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
        let [_, sway, heave, turn_rate] = guidance.command;
        let speed = self.options.speed.at(seconds(now));
        // The same curvature at another speed.
        self.command = [speed, sway, heave, turn_rate * speed / PursuitParameters::default().speed];
        assert!(now < 3_600_000_000_000, "lost {:.1} m along the course", guidance.distance);
        guidance.finished
    }

    fn control(&mut self, truth: &Outputs) -> [f64; 8] {
        self.controller.update(&mut self.controller_memory, self.command, truth.nu).force
    }
}

/// Instants of a sensor: multiples of its period, from zero on.
struct Clock {
    hz: f64,
    count: u64,
    next: i64,
}

impl Clock {
    fn new(hz: f64) -> Self {
        Self { hz, count: 0, next: if hz > 0.0 { 0 } else { i64::MAX } }
    }

    fn fires(&mut self, now: i64) -> bool {
        let due = self.next == now;
        if due {
            self.count += 1;
            self.next = (self.count as f64 * 1e9 / self.hz).round() as i64;
        }
        due
    }
}

struct Sensors<'a> {
    options: &'a Options,
    imu: Imu,
    imu_memory: ImuMemory,
    imu_clock: Clock,
    ahrs: (Clock, Gaussian),
    dvl: (Clock, Gaussian),
    fix: (Clock, Gaussian),
    depth: (Clock, Gaussian),
}

impl<'a> Sensors<'a> {
    fn new(options: &'a Options) -> Self {
        let (accelerometer, gyro) = options.imu.noise();
        let quiet = |noise: BiasNoise| match options.ideal {
            true => BiasNoise { noise_density: 0.0, random_walk: 0.0, turn_on_sigma: 0.0, ..noise },
            false => noise,
        };
        let imu = Imu::new(&ImuParameters {
            seed: options.seed,
            accelerometer: quiet(accelerometer),
            gyro: quiet(gyro),
            ..ImuParameters::default()
        })
        .unwrap();
        let sensor = |hz, of| (Clock::new(hz), stream(options, of));
        Self {
            options,
            imu_memory: imu.memory(),
            imu_clock: Clock::new(imu.rate.hz()),
            imu,
            ahrs: sensor(options.ahrs_hz, Stream::Ahrs),
            dvl: sensor(options.dvl_hz, Stream::Dvl),
            fix: sensor(options.fix_hz, Stream::Fix),
            depth: sensor(options.depth_hz, Stream::Depth),
        }
    }

    /// The next instant of any of them (ns).
    fn next(&self) -> i64 {
        let others = [&self.ahrs, &self.dvl, &self.fix, &self.depth];
        others.iter().map(|s| s.0.next).fold(self.imu_clock.next, i64::min)
    }

    fn sample(&mut self, now: i64, truth: &Outputs, thrust: [f64; 8], events: &mut Vec<Event>) {
        let stamp = seconds(now);
        let mut push = |data| events.push(Event { stamp, arrival: stamp, data });
        let o = self.options;
        let sigma = |sigma: f64| if o.ideal { 0.0 } else { sigma };
        let [_, _, _, p, q, r] = truth.nu;
        if self.imu_clock.fires(now) {
            let [.., dp, dq, dr] = truth.nu_dot;
            let truth = ImuTruth {
                specific_force: truth.specific_force,
                rate: [p, q, r],
                rate_dot: [dp, dq, dr],
                euler: truth.euler,
            };
            let sample = self.imu.sample(&mut self.imu_memory, &truth);
            push(Data::Imu { specific_force: sample.specific_force, rate: sample.rate });
            push(Data::Thrust(thrust));
        }
        if self.ahrs.0.fires(now) {
            let ([roll, pitch, yaw], n) = (truth.euler, draw::<3>(&mut self.ahrs.1, sigma(1.0)));
            let yaw = yaw + o.heading_bias + o.heading_sigma * n[2];
            let (roll, pitch) = (roll + o.tilt_sigma * n[0], pitch + o.tilt_sigma * n[1]);
            push(Data::Ahrs([wrap(roll), pitch, wrap(yaw)]));
        }
        if self.dvl.0.fires(now) {
            let ([u, v, w, ..], [x, y, z]) = (truth.nu, DVL_POSITION);
            let there = [u + q * z - r * y, v + r * x - p * z, w + p * y - q * x];
            let n = draw::<3>(&mut self.dvl.1, sigma(o.dvl_sigma));
            push(Data::Dvl(core::array::from_fn(|i| (1.0 + o.dvl_scale) * there[i] + n[i])));
        }
        if self.fix.0.fires(now) {
            let n = draw::<2>(&mut self.fix.1, sigma(o.fix_sigma));
            push(Data::Fix([truth.p_ned[0] + n[0], truth.p_ned[1] + n[1]]));
        }
        if self.depth.0.fires(now) {
            let (down, [x, y, z]) = (rotation(truth.quaternion)[2], DEPTH_POSITION);
            let above = down[0] * x + down[1] * y + down[2] * z;
            let [n] = draw::<1>(&mut self.depth.1, sigma(o.depth_sigma));
            push(Data::Depth(truth.p_ned[2] + above + n));
        }
    }
}
