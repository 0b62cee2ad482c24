//! The sensors, each at its own instants.

use super::flight::{Stream, draw, seconds, stream};
use super::{DEPTH_POSITION, DVL_POSITION, Data, Event, Options};
use rexrov::attitude::{rotation, wrap};
use rexrov::sensors::{BiasNoise, Gaussian, Imu, ImuMemory, ImuParameters, ImuTruth, Instrument};
use rexrov::vehicle::Outputs;

/// Instants of a sensor: multiples of its period, starting at zero.
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

pub(super) struct Instruments {
    options: Options,
    imu: Imu,
    imu_memory: ImuMemory,
    imu_clock: Clock,
    ahrs: (Clock, Gaussian),
    dvl: (Clock, Gaussian),
    fix: (Clock, Gaussian),
    depth: (Clock, Gaussian),
}

impl Instruments {
    pub(super) fn new(options: &Options) -> Self {
        let (accelerometer, gyro) = options.imu.noise();
        let quiet = |noise: BiasNoise| match options.ideal {
            true => BiasNoise { noise_density: 0.0, random_walk: 0.0, turn_on_sigma: 0.0, ..noise },
            false => noise,
        };
        let imu = Imu::new(&ImuParameters {
            instrument: Instrument::new(50.0, i32::try_from(options.seed).unwrap()),
            accelerometer: quiet(accelerometer),
            gyro: quiet(gyro),
            ..ImuParameters::default()
        })
        .unwrap();
        let mut sigmas = *options;
        if options.ideal {
            (sigmas.fix_sigma, sigmas.dvl_sigma, sigmas.depth_sigma) = (0.0, 0.0, 0.0);
            (sigmas.heading_sigma, sigmas.tilt_sigma) = (0.0, 0.0);
        }
        let sensor = |hz, of| (Clock::new(hz), stream(options, of));
        Self {
            options: sigmas,
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
    pub(super) fn next(&self) -> i64 {
        let others = [&self.ahrs, &self.dvl, &self.fix, &self.depth];
        others.iter().map(|s| s.0.next).fold(self.imu_clock.next, i64::min)
    }

    /// What is due now, in the order of [`Data`].
    pub(super) fn sample(
        &mut self,
        now: i64,
        truth: &Outputs,
        thrust: [f64; 8],
        events: &mut Vec<Event>,
    ) {
        let stamp = seconds(now);
        let mut push = |data| events.push(Event { stamp, arrival: stamp, data });
        if self.imu_clock.fires(now) {
            push(self.imu(truth));
            push(Data::Thrust(thrust));
        }
        if self.ahrs.0.fires(now) {
            push(self.ahrs(truth));
        }
        if self.dvl.0.fires(now) {
            push(self.dvl(truth));
        }
        if self.fix.0.fires(now) {
            let [north, east] = draw(&mut self.fix.1, self.options.fix_sigma);
            push(Data::Fix([truth.p_ned[0] + north, truth.p_ned[1] + east]));
        }
        if self.depth.0.fires(now) {
            push(self.depth(truth));
        }
    }

    fn imu(&mut self, truth: &Outputs) -> Data {
        let ([.., p, q, r], [.., dp, dq, dr]) = (truth.nu, truth.nu_dot);
        let truth = ImuTruth {
            specific_force: truth.specific_force,
            rate: [p, q, r],
            rate_dot: [dp, dq, dr],
            euler: truth.euler,
        };
        let sample = self.imu.sample(&mut self.imu_memory, &truth);
        Data::Imu { specific_force: sample.specific_force, rate: sample.rate }
    }

    fn ahrs(&mut self, truth: &Outputs) -> Data {
        let o = &self.options;
        let [roll, pitch, yaw] = truth.euler;
        let n: [f64; 3] = draw(&mut self.ahrs.1, 1.0);
        Data::Ahrs([
            wrap(roll + o.tilt_sigma * n[0]),
            pitch + o.tilt_sigma * n[1],
            wrap(yaw + o.heading_bias + o.heading_sigma * n[2]),
        ])
    }

    fn dvl(&mut self, truth: &Outputs) -> Data {
        let ([u, v, w, p, q, r], [x, y, z]) = (truth.nu, DVL_POSITION);
        let velocity = [u + q * z - r * y, v + r * x - p * z, w + p * y - q * x];
        let noise: [f64; 3] = draw(&mut self.dvl.1, self.options.dvl_sigma);
        let scale = 1.0 + self.options.dvl_scale;
        Data::Dvl(core::array::from_fn(|i| scale * velocity[i] + noise[i]))
    }

    fn depth(&mut self, truth: &Outputs) -> Data {
        let (down, [x, y, z]) = (rotation(truth.quaternion)[2], DEPTH_POSITION);
        let lever = down[0] * x + down[1] * y + down[2] * z;
        let [noise] = draw(&mut self.depth.1, self.options.depth_sigma);
        Data::Depth(truth.p_ned[2] + lever + noise)
    }
}
