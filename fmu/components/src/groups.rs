//! Groups of variables that several components share.

use fmu_kit::{ParameterError, Variables};
use serde::{Deserialize, Serialize};

/// Declares a group of Reals that is an array of as many numbers in the mathematics.
macro_rules! group {
    ($(#[$about:meta])* $name:ident = [$($(#[$field:meta])* $member:ident),+; $count:literal]) => {
        $(#[$about])*
        #[derive(
            Clone, Copy, Debug, Default, PartialEq,
            ::serde::Serialize, ::serde::Deserialize, ::fmu_kit::Variables,
        )]
        pub struct $name {
            $($(#[$field])* pub $member: f64,)+
        }

        impl From<$name> for [f64; $count] {
            fn from(group: $name) -> Self {
                [$(group.$member),+]
            }
        }

        impl From<[f64; $count]> for $name {
            fn from([$($member),+]: [f64; $count]) -> Self {
                Self { $($member),+ }
            }
        }
    };
}

pub(crate) use group;

group! {
    /// A vector in the body frame.
    Vector = [
        /// forward
        x,
        /// starboard
        y,
        /// down
        z; 3]
}

group! {
    /// A position in NED.
    Position = [
        /// north
        #[var(unit = "m")] x,
        /// east
        #[var(unit = "m")] y,
        /// down
        #[var(unit = "m")] z; 3]
}

group! {
    /// A horizontal position in NED.
    Horizontal = [
        /// north
        #[var(unit = "m")] x,
        /// east
        #[var(unit = "m")] y; 2]
}

group! {
    /// An attitude as Euler angles (yaw, then pitch, then roll).
    Attitude = [
        /// roll
        #[var(unit = "rad")] roll,
        /// pitch
        #[var(unit = "rad")] pitch,
        /// yaw from north
        #[var(unit = "rad")] yaw; 3]
}

group! {
    /// A unit quaternion from body to NED.
    Quaternion = [
        /// scalar part
        #[var(min = -1.0, max = 1.0)] w,
        /// x
        #[var(min = -1.0, max = 1.0)] x,
        /// y
        #[var(min = -1.0, max = 1.0)] y,
        /// z
        #[var(min = -1.0, max = 1.0)] z; 4]
}

group! {
    /// Position and attitude.
    Pose = [
        /// north
        #[var(unit = "m")] x,
        /// east
        #[var(unit = "m")] y,
        /// down
        #[var(unit = "m")] z,
        /// roll
        #[var(unit = "rad")] roll,
        /// pitch
        #[var(unit = "rad")] pitch,
        /// yaw from north
        #[var(unit = "rad")] yaw; 6]
}

group! {
    /// Depth and the angles that turn a place in the body up or down.
    DepthAndTilt = [
        /// down
        #[var(unit = "m")] z,
        /// roll
        #[var(unit = "rad")] roll,
        /// pitch
        #[var(unit = "rad")] pitch; 3]
}

group! {
    /// Position and heading, the pose of the four-degree-of-freedom models.
    Pose4 = [
        /// north
        #[var(unit = "m")] x,
        /// east
        #[var(unit = "m")] y,
        /// down
        #[var(unit = "m")] z,
        /// yaw from north
        #[var(unit = "rad")] yaw; 4]
}

group! {
    /// Velocity over ground in the body frame (SNAME).
    Velocity = [
        /// surge
        #[var(unit = "m/s")] u,
        /// sway
        #[var(unit = "m/s")] v,
        /// heave
        #[var(unit = "m/s")] w,
        /// roll rate
        #[var(unit = "rad/s")] p,
        /// pitch rate
        #[var(unit = "rad/s")] q,
        /// yaw rate
        #[var(unit = "rad/s")] r; 6]
}

group! {
    /// Velocity over ground in the body frame, four degrees of freedom.
    Velocity4 = [
        /// surge
        #[var(unit = "m/s")] u,
        /// sway
        #[var(unit = "m/s")] v,
        /// heave
        #[var(unit = "m/s")] w,
        /// yaw rate
        #[var(unit = "rad/s")] r; 4]
}

group! {
    /// Linear velocity in the body frame.
    LinearVelocity = [
        /// surge
        #[var(unit = "m/s")] u,
        /// sway
        #[var(unit = "m/s")] v,
        /// heave
        #[var(unit = "m/s")] w; 3]
}

group! {
    /// Angular velocity in the body frame.
    AngularVelocity = [
        /// roll rate
        #[var(unit = "rad/s")] p,
        /// pitch rate
        #[var(unit = "rad/s")] q,
        /// yaw rate
        #[var(unit = "rad/s")] r; 3]
}

group! {
    /// Time derivative of the angular velocity.
    AngularAcceleration = [
        /// roll
        #[var(unit = "rad/s2")] p,
        /// pitch
        #[var(unit = "rad/s2")] q,
        /// yaw
        #[var(unit = "rad/s2")] r; 3]
}

group! {
    /// Time derivative of the body-frame velocity.
    Acceleration = [
        /// surge
        #[var(unit = "m/s2")] u,
        /// sway
        #[var(unit = "m/s2")] v,
        /// heave
        #[var(unit = "m/s2")] w,
        /// roll
        #[var(unit = "rad/s2")] p,
        /// pitch
        #[var(unit = "rad/s2")] q,
        /// yaw
        #[var(unit = "rad/s2")] r; 6]
}

group! {
    /// Time derivative of the linear velocity in the body frame.
    LinearAcceleration = [
        /// surge
        #[var(unit = "m/s2")] u,
        /// sway
        #[var(unit = "m/s2")] v,
        /// heave
        #[var(unit = "m/s2")] w; 3]
}

group! {
    /// Velocity in NED.
    Ned = [
        /// north
        #[var(unit = "m/s")] north,
        /// east
        #[var(unit = "m/s")] east,
        /// down
        #[var(unit = "m/s")] down; 3]
}

group! {
    /// Forces and moments about the centre of gravity in the body frame (SNAME).
    Wrench = [
        /// surge force
        #[var(rename = "X", unit = "N", nominal = 1000.0)] x,
        /// sway force
        #[var(rename = "Y", unit = "N", nominal = 1000.0)] y,
        /// heave force
        #[var(rename = "Z", unit = "N", nominal = 1000.0)] z,
        /// roll moment
        #[var(rename = "K", unit = "N.m", nominal = 1000.0)] k,
        /// pitch moment
        #[var(rename = "M", unit = "N.m", nominal = 1000.0)] m,
        /// yaw moment
        #[var(rename = "N", unit = "N.m", nominal = 1000.0)] n; 6]
}

/// The force of one thruster.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Force {
    /// force
    #[var(unit = "N", nominal = 1000.0)]
    pub force: f64,
}

/// The thrust of one thruster.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Thrust {
    /// thrust
    #[var(unit = "N", nominal = 1000.0)]
    pub thrust: f64,
}

/// Inertia about the centre of gravity: elements of the matrix, not its negated products.
#[derive(Clone, Copy, Debug, Default, Variables)]
#[allow(missing_docs, reason = "the six elements are named by their indices")]
pub struct Inertia {
    #[var(unit = "kg.m2")]
    pub xx: f64,
    #[var(unit = "kg.m2")]
    pub yy: f64,
    #[var(unit = "kg.m2")]
    pub zz: f64,
    #[var(unit = "kg.m2")]
    pub xy: f64,
    #[var(unit = "kg.m2")]
    pub xz: f64,
    #[var(unit = "kg.m2")]
    pub yz: f64,
}

impl From<::rexrov::vehicle::Inertia> for Inertia {
    fn from(i: ::rexrov::vehicle::Inertia) -> Self {
        Self { xx: i.xx, yy: i.yy, zz: i.zz, xy: i.xy, xz: i.xz, yz: i.yz }
    }
}

impl From<Inertia> for ::rexrov::vehicle::Inertia {
    fn from(i: Inertia) -> Self {
        Self { xx: i.xx, yy: i.yy, zz: i.zz, xy: i.xy, xz: i.xz, yz: i.yz }
    }
}

/// Position and direction of one thruster, Tables 3 and 4 of the paper.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Mounting {
    /// place forward of the centre of gravity
    #[var(unit = "m")]
    pub lx: f64,
    /// place to starboard
    #[var(unit = "m")]
    pub ly: f64,
    /// place downwards
    #[var(unit = "m")]
    pub lz: f64,
    /// elevation of the axis above the horizontal
    #[var(unit = "deg")]
    pub theta_deg: f64,
    /// azimuth of the axis from forward, positive to starboard
    #[var(unit = "deg")]
    pub psi_deg: f64,
}

impl From<::rexrov::vehicle::Thruster> for Mounting {
    fn from(t: ::rexrov::vehicle::Thruster) -> Self {
        Self { lx: t.lx, ly: t.ly, lz: t.lz, theta_deg: t.theta_deg, psi_deg: t.psi_deg }
    }
}

impl From<Mounting> for ::rexrov::vehicle::Thruster {
    fn from(m: Mounting) -> Self {
        Self { lx: m.lx, ly: m.ly, lz: m.lz, theta_deg: m.theta_deg, psi_deg: m.psi_deg }
    }
}

/// An error of the mathematics as an error of a variable.
pub fn parameter_error(error: ::rexrov::ParameterError) -> ParameterError {
    ParameterError::new(error.name, format!("{}: {}", error.value, error.reason))
}
