//! The inputs of a component in its reference run.
//!
//! There is one motion for all, so that their results are consistent: a dive on a helix, level, at
//! constant speed, on a circle of radius u / r that is traversed at r and sinks at w:
//! `p = (u/r sin rt, u/r (1 - cos rt), 20 + wt)`, `psi = rt`, specific force `(0, ru, -g)`. The
//! thrusters push ahead, up and down, and turn.

/// Forward speed, m/s.
const SURGE: f64 = 0.5;
/// Speed downwards, m/s.
const HEAVE: f64 = 0.05;
/// Turn rate, rad/s.
const TURN: f64 = 0.1;
/// Gravity, m/s2.
const GRAVITY: f64 = 9.81;
/// Noise of an instrument, in its unit: values that repeat bit for bit would indicate a stuck
/// instrument.
const RIPPLE: f64 = 1e-3;
/// Thrust over rotor speed squared, N.s2/rad2.
const THRUST_GAIN: f64 = 0.00031;

/// The value of an input at time `t` in seconds; `None` if it keeps its start value.
pub(crate) fn value(input: &str, t: f64) -> Option<f64> {
    // The component and the instrument do not matter, only the quantity.
    let measured = ["imu.", "ahrs.", "dvl.", "fix.", "pressure.", "propulsion."]
        .iter()
        .find_map(|prefix| input.strip_prefix(prefix));
    if let Some(quantity) = measured {
        return match quantity {
            "valid" => Some(1.0),
            "stamp" => Some(t),
            _ => motion(quantity, t).map(|value| value + RIPPLE * libm::sin(7.0 * t)),
        };
    }
    let quantity = input.strip_prefix("vehicle.").unwrap_or(input);
    motion(quantity, t).or_else(|| thruster(quantity, t))
}

/// The motion, and the demands.
fn motion(quantity: &str, t: f64) -> Option<f64> {
    let (sine, cosine) = libm::sincos(TURN * t);
    Some(match quantity {
        "pose.x" | "position.x" => SURGE / TURN * sine,
        "pose.y" | "position.y" => SURGE / TURN * (1.0 - cosine),
        "pose.z" | "depth" => 20.0 + HEAVE * t,
        "pose.yaw" | "attitude.yaw" => TURN * t,
        "velocity.u" | "command.u" => SURGE,
        "velocity.w" => HEAVE,
        "velocity.r" | "rate.r" => TURN,
        "command.w" => 2.0 * HEAVE,
        "command.r" => TURN * cosine,
        "specific_force.y" => TURN * SURGE,
        "specific_force.z" => -GRAVITY,
        _ => return None,
    })
}

/// Forces of the thrusters, and the speeds of their rotors: 0 to 3 push up, 4 and 5 ahead.
fn thruster(quantity: &str, t: f64) -> Option<f64> {
    let (part, quantity) = quantity.split_once("].")?;
    let (part, index) = part.split_once('[')?;
    let slow = libm::sin(TURN * t);
    let force: f64 = match index.parse::<u8>().ok()? {
        0..=3 => -20.0 - 30.0 * slow,
        4 => 100.0 + 10.0 * slow,
        5 => 100.0 - 10.0 * slow,
        _ => 0.0,
    };
    match (part, quantity) {
        ("thruster", "force" | "thrust") => Some(force),
        ("rotor", "speed") => Some((force.abs() / THRUST_GAIN).sqrt().copysign(force)),
        _ => None,
    }
}
