//! State estimation.
//!
//! A [`Filter`] consists of a [`process`] (how the state evolves), the [`sensor`]s (how
//! measurements depend on the state), and time ordering: it predicts to each measurement's own
//! instant, and inserts late ones at theirs (`history`). Its [`Belief`] is a mean and a covariance;
//! a measurement changes it through [`kalman`], with bounded influence. Sensors are written once,
//! for the [`kinematics`] that every process provides with its derivatives. The paper's two filters
//! are in [`paper`]. [`bound`] has the lower bound for any filter.

mod aided;
pub mod belief;
pub mod bound;
mod clocks;
pub mod estimate;
mod family;
pub mod filter;
mod history;
mod intake;
pub mod interval;
pub mod kalman;
pub mod kinematics;
mod lanes;
mod measurement;
pub mod monitor;
pub mod paper;
mod parameters;
pub mod process;
mod recovery;
pub mod sensor;
mod smoother;
mod track;
pub mod transition;
mod turning;

pub use aided::{AIDED_STATES, AidedFilter, AidedMemory, BASIC_STATES};
pub use belief::Belief;
pub use estimate::{ChannelReport, Estimate, Health};
pub use family::{
    ConstantAccelerationFilter, DynamicFilter, InertialFilter, UnmonitoredAidedFilter,
    UnmonitoredDynamicFilter,
};
pub use filter::{Filter, Memory, Navigation};
pub use measurement::{KINDS, Kind, Measurements, Reading};
pub use monitor::ThrusterMonitor;
pub use parameters::{
    Disturbances, ModelErrors, Mounting, NavigationParameters, SensorErrors, Start,
};
pub use process::constant_acceleration::ConstantAcceleration;
pub use process::inertial::InertialProcess;
pub use process::model_aid::ModelAid;
pub use process::planar_dynamic::PlanarDynamic;
pub use smoother::{Recording, Smoothed, Smoothing};
pub use track::{CHANNELS, Channel};
pub use turning::Turning;
