//! The vehicle under its disturbances, with thrusters of unequal gain.

use super::flight::{Stream, TICK, draw, seconds, stream};
use super::{Options, START_DEPTH};
use rexrov::sensors::Gaussian;
use rexrov::vehicle::{Inputs, Outputs, Parameters, Propulsion, State, Vehicle};

const DISTURBANCE_TIME: f64 = 5.0;
const KIDNAP_DISTANCE: f64 = 10.0;

/// The vehicle and its disturbances.
pub(super) struct Plant<'a> {
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
    pub(super) fn new(options: &'a Options) -> Self {
        let nominal = Parameters::default();
        let mut parameters = nominal;
        parameters.mass *= options.mass_scale;
        let i = &mut parameters.inertia;
        for element in [&mut i.xx, &mut i.yy, &mut i.zz, &mut i.xy, &mut i.xz, &mut i.yz] {
            *element *= options.mass_scale;
        }
        let ballast = parameters.weight() - nominal.weight();
        parameters.buoyancy = Some(nominal.buoyancy_force() + ballast);
        parameters.centre_of_buoyancy[2] = -options.metacentre;
        parameters.propulsion.rotor_time_constant = options.rotor_lag;
        let scaled = |d: [f64; 6]| d.map(|x| options.damping_scale * x);
        parameters.linear_damping = scaled(nominal.linear_damping);
        parameters.quadratic_damping = scaled(nominal.quadratic_damping);
        let [north, east] = options.current;
        let mut disturbance_noise = stream(options, Stream::Disturbance);
        let normal = draw(&mut disturbance_noise, 1.0);
        let mut state = State::at_rest([0.0, 0.0, START_DEPTH], [0.0; 3]);
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

    /// Somewhere else, at the same depth.
    pub(super) fn jump(&mut self) {
        let [a, b] = draw(&mut stream(self.options, Stream::Kidnap), 1.0);
        let scale = KIDNAP_DISTANCE / libm::hypot(a, b);
        self.state.p_ned[0] += scale * a;
        self.state.p_ned[1] += scale * b;
    }

    /// Draws the disturbance of the next tick.
    pub(super) fn disturb(&mut self) {
        let decay = libm::exp(-seconds(TICK) / DISTURBANCE_TIME);
        let sigma = disturbance_sigma(self.options).map(|s| s * (1.0 - decay * decay).sqrt());
        let normal = draw(&mut self.disturbance_noise, 1.0);
        let drive = scaled_by(&sigma, &normal);
        self.disturbance = core::array::from_fn(|i| decay * self.disturbance[i] + drive[i]);
    }

    pub(super) fn command(&mut self, now: i64, mut force: [f64; 8]) {
        let since = |time: f64| seconds(now) >= time;
        if let Some((i, _)) = self.options.dead_thruster.filter(|(_, time)| since(*time)) {
            force[i] = 0.0;
        }
        self.inputs.thruster_force = force;
    }

    /// Wrench of the thrust in excess of the rotor speeds', and the disturbance.
    fn extra(&self, thrust: &[f64; 8]) -> [f64; 6] {
        let mut wrench = self.disturbance;
        for ((column, gain), thrust) in self.columns.iter().zip(self.gain_error).zip(thrust) {
            for (w, c) in wrench.iter_mut().zip(column) {
                *w += gain * thrust * c;
            }
        }
        wrench
    }

    pub(super) fn outputs(&mut self, now: i64) -> Outputs {
        let lost = self.options.lost_thruster.filter(|(_, time)| seconds(now) >= *time);
        if let Some((i, _)) = lost {
            self.gain_error[i] = -self.options.lost_fraction;
        }
        let inputs = Inputs { wrench: self.extra(&self.measured_thrust()), ..self.inputs };
        self.vehicle.outputs(&self.state, &inputs)
    }

    pub(super) fn measured_thrust(&self) -> [f64; 8] {
        self.state.rotor_speed.map(|speed| self.propulsion.thrust(speed))
    }

    /// One step. Rotor speeds are known in advance, so that Simpson's rule gives the mean surplus.
    pub(super) fn advance(&mut self, h: f64) {
        let p = &self.propulsion;
        let target = self.inputs.thruster_force.map(|force| p.speed(force));
        let thrust_after = |time: f64| {
            let rest = libm::exp(-time / p.rotor_time_constant);
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
