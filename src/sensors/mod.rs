//! Sensors: what the instruments show of a true state.
//!
//! Each has a rate, a place in the body frame and a seed. `sample` takes the truth at a sample
//! instant and the sensor's memory (noise generators, slow biases). Every channel draws from a
//! stream of its own, and a sensor is sampled at every instant even while it is switched off (the
//! result is dropped), so that neither an outage nor another channel shifts later noise.

mod dvl;
mod gps;
mod imu;
mod noise;
mod pressure;

pub use dvl::{Dvl, DvlMemory, DvlParameters, DvlSample, DvlTruth};
pub use gps::{Gps, GpsMemory, GpsParameters, GpsSample, GpsTruth};
pub use imu::{Imu, ImuMemory, ImuParameters, ImuSample, ImuTruth};
pub use noise::{BiasNoise, Gaussian};
pub use pressure::{
    PressureMemory, PressureParameters, PressureSample, PressureSensor, PressureTruth,
};
