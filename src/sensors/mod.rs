//! Sensors: what the instruments measure of a true state.
//!
//! Each has a rate, a position in the body frame and a seed. `sample` takes the truth at a sample
//! instant and the sensor's memory (noise generators, slow biases). Every channel draws from its
//! own stream, and a sensor is sampled at every instant even while it is switched off (the result
//! is discarded), so that neither an outage nor another channel shifts later noise.

mod ahrs;
mod dvl;
mod dvl_model;
mod errors;
mod gps;
mod grade;
mod imu;
mod noise;
mod pressure;
mod tachometer;

pub use ahrs::{Ahrs, AhrsMemory, AhrsParameters, AhrsTruth};
pub use dvl::{Dvl, DvlMemory, DvlPing, DvlSample, DvlTruth};
pub use dvl_model::{DvlModel, DvlParameters};
pub(crate) use errors::Correlated;
pub use errors::{BiasNoise, GaussMarkov, Outliers};
pub use gps::{Gps, GpsFix, GpsMemory, GpsParameters, GpsSample, GpsTruth};
pub use grade::{ImuGrade, ImuNoise};
pub use imu::{AxisErrors, Imu, ImuMemory, ImuParameters, ImuSample, ImuTruth};
pub use noise::{Gaussian, Stream};
pub use pressure::{
    PressureMemory, PressureParameters, PressureSample, PressureSensor, PressureTruth,
};
pub use tachometer::{Tachometer, TachometerMemory, TachometerParameters, TachometerSample};
