//! One step of the classical Runge-Kutta method of fourth order, inputs held constant.

use super::{Inputs, State, Vehicle};

impl Vehicle {
    /// Advances the state by `h` seconds.
    ///
    /// At 10 ms a minute of manoeuvring is good to about 1e-7 m. The rotor lag limits the step:
    /// after commands that jump, thrusts are wrong by up to 2e-5 of their peak at 10 ms and by less
    /// than 1e-6 at 4 ms, and the method is stable up to 2.78 rotor time constants.
    pub fn step(&self, state: &mut State, inputs: &Inputs, h: f64) {
        let drive = self.drive(inputs);
        let k1 = self.rate(state, &drive);
        let k2 = self.rate(&advanced(state, 0.5 * h, &k1), &drive);
        let k3 = self.rate(&advanced(state, 0.5 * h, &k2), &drive);
        let k4 = self.rate(&advanced(state, h, &k3), &drive);
        let sixth = h / 6.0;
        state.p_ned = weighed(&state.p_ned, sixth, [&k1, &k2, &k3, &k4].map(|k| &k.p_ned));
        let k_q = [&k1, &k2, &k3, &k4].map(|k| &k.quaternion);
        state.quaternion = weighed(&state.quaternion, sixth, k_q);
        state.nu = weighed(&state.nu, sixth, [&k1, &k2, &k3, &k4].map(|k| &k.nu));
        let k_rotor = [&k1, &k2, &k3, &k4].map(|k| &k.rotor_speed);
        state.rotor_speed = weighed(&state.rotor_speed, sixth, k_rotor);
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

/// Summed from the first slope to the last, as an integrator does that adds them up as they come:
/// the same bits as any classical Runge-Kutta over [`Vehicle::derivative`] in that order.
#[inline(always)]
fn weighed<const N: usize>(x: &[f64; N], sixth: f64, k: [&[f64; N]; 4]) -> [f64; N] {
    core::array::from_fn(|i| x[i] + sixth * (k[0][i] + 2.0 * k[1][i] + 2.0 * k[2][i] + k[3][i]))
}
