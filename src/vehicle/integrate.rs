//! One step of the classical Runge-Kutta method of fourth order, inputs held constant.

use super::{Inputs, State, Vehicle};

impl Vehicle {
    /// Advances the state by `h` seconds.
    ///
    /// At 10 ms a minute of manoeuvring is good to about 1e-7 m. The rotor lag limits the step:
    /// the method is stable up to 2.78 rotor time constants.
    pub fn step(&self, state: &mut State, inputs: &Inputs, h: f64) {
        let drive = self.drive(inputs);
        let k1 = self.rate(state, &drive);
        let k2 = self.rate(&advanced(state, 0.5 * h, &k1), &drive);
        let k3 = self.rate(&advanced(state, 0.5 * h, &k2), &drive);
        let k4 = self.rate(&advanced(state, h, &k3), &drive);
        let sixth = h / 6.0;
        let weigh = |x: &mut [f64], k: [&[f64]; 4]| {
            for (i, x) in x.iter_mut().enumerate() {
                *x += sixth * (k[0][i] + 2.0 * (k[1][i] + k[2][i]) + k[3][i]);
            }
        };
        weigh(
            &mut state.p_ned,
            [&k1.p_ned, &k2.p_ned, &k3.p_ned, &k4.p_ned],
        );
        weigh(
            &mut state.quaternion,
            [
                &k1.quaternion,
                &k2.quaternion,
                &k3.quaternion,
                &k4.quaternion,
            ],
        );
        weigh(&mut state.nu, [&k1.nu, &k2.nu, &k3.nu, &k4.nu]);
        weigh(
            &mut state.rotor_speed,
            [
                &k1.rotor_speed,
                &k2.rotor_speed,
                &k3.rotor_speed,
                &k4.rotor_speed,
            ],
        );
    }
}

/// `state + h rate`.
#[inline(always)]
fn advanced(state: &State, h: f64, rate: &State) -> State {
    State {
        p_ned: axpy(&state.p_ned, h, &rate.p_ned),
        quaternion: axpy(&state.quaternion, h, &rate.quaternion),
        nu: axpy(&state.nu, h, &rate.nu),
        rotor_speed: axpy(&state.rotor_speed, h, &rate.rotor_speed),
    }
}

#[inline(always)]
fn axpy<const N: usize>(x: &[f64; N], h: f64, k: &[f64; N]) -> [f64; N] {
    core::array::from_fn(|i| x[i] + h * k[i])
}
