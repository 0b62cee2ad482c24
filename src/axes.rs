//! Names, descriptions and units of the elements of vectors, for the declarations of quantities:
//! `#[var(elements = axes::NED)]`.
//!
//! Where a field has a unit, its elements have it too, so a body vector has none here.

use fmu_quantity::Member;

/// A vector in the body frame.
pub const BODY: [Member; 3] =
    [Member::new("x", "forward"), Member::new("y", "starboard"), Member::new("z", "down")];

/// A position in NED.
pub const NED: [Member; 3] = [
    Member::new("x", "north").unit("m"),
    Member::new("y", "east").unit("m"),
    Member::new("z", "down").unit("m"),
];

/// A horizontal position in NED.
pub const HORIZONTAL: [Member; 2] = [NED[0], NED[1]];

/// An attitude as Euler angles (yaw, then pitch, then roll).
pub const EULER: [Member; 3] = [
    Member::new("roll", "roll").unit("rad"),
    Member::new("pitch", "pitch").unit("rad"),
    Member::new("yaw", "yaw from north").unit("rad"),
];

/// The part of an attitude that is not the heading.
pub const TILT: [Member; 2] = [EULER[0], EULER[1]];

/// Position and attitude.
pub const POSE: [Member; 6] = [NED[0], NED[1], NED[2], EULER[0], EULER[1], EULER[2]];

/// Position and heading, the pose of the four-degree-of-freedom models.
pub const POSE4: [Member; 4] = [NED[0], NED[1], NED[2], EULER[2]];

/// Velocity over ground in the body frame (SNAME).
pub const VELOCITY: [Member; 6] = [
    Member::new("u", "surge").unit("m/s"),
    Member::new("v", "sway").unit("m/s"),
    Member::new("w", "heave").unit("m/s"),
    Member::new("p", "roll rate").unit("rad/s"),
    Member::new("q", "pitch rate").unit("rad/s"),
    Member::new("r", "yaw rate").unit("rad/s"),
];

/// Velocity over ground in the body frame, four degrees of freedom.
pub const VELOCITY4: [Member; 4] = [VELOCITY[0], VELOCITY[1], VELOCITY[2], VELOCITY[5]];

/// Linear velocity in the body frame.
pub const LINEAR_VELOCITY: [Member; 3] = [VELOCITY[0], VELOCITY[1], VELOCITY[2]];

/// Angular velocity in the body frame.
pub const ANGULAR_VELOCITY: [Member; 3] = [VELOCITY[3], VELOCITY[4], VELOCITY[5]];

/// Time derivative of the body-frame velocity.
pub const ACCELERATION: [Member; 6] = [
    Member::new("u", "surge").unit("m/s2"),
    Member::new("v", "sway").unit("m/s2"),
    Member::new("w", "heave").unit("m/s2"),
    Member::new("p", "roll").unit("rad/s2"),
    Member::new("q", "pitch").unit("rad/s2"),
    Member::new("r", "yaw").unit("rad/s2"),
];

/// Time derivative of the linear velocity in the body frame.
pub const LINEAR_ACCELERATION: [Member; 3] = [ACCELERATION[0], ACCELERATION[1], ACCELERATION[2]];

/// Time derivative of the angular velocity.
pub const ANGULAR_ACCELERATION: [Member; 3] = [ACCELERATION[3], ACCELERATION[4], ACCELERATION[5]];

/// Velocity in NED.
pub const NED_VELOCITY: [Member; 3] = [
    Member::new("north", "north").unit("m/s"),
    Member::new("east", "east").unit("m/s"),
    Member::new("down", "down").unit("m/s"),
];

/// A horizontal velocity in NED.
pub const HORIZONTAL_VELOCITY: [Member; 2] = [NED_VELOCITY[0], NED_VELOCITY[1]];

/// Forces and moments about the centre of gravity in the body frame (SNAME).
pub const WRENCH: [Member; 6] = [
    Member::new("X", "surge force").unit("N").nominal(1000.0),
    Member::new("Y", "sway force").unit("N").nominal(1000.0),
    Member::new("Z", "heave force").unit("N").nominal(1000.0),
    Member::new("K", "roll moment").unit("N.m").nominal(1000.0),
    Member::new("M", "pitch moment").unit("N.m").nominal(1000.0),
    Member::new("N", "yaw moment").unit("N.m").nominal(1000.0),
];

/// The thrust of a thruster.
pub const THRUST: Member = Member::new("thrust", "thrust").unit("N").nominal(1000.0);

/// The speed of a rotor.
pub const ROTOR_SPEED: Member = Member::new("speed", "speed").unit("rad/s").nominal(100.0);
