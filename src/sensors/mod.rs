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
mod instrument;
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
pub use instrument::Instrument;
pub use noise::Gaussian;
pub use pressure::{
    PressureMemory, PressureParameters, PressureSample, PressureSensor, PressureTruth,
};
pub use tachometer::{
    Tachometer, TachometerMemory, TachometerParameters, TachometerSample, TachometerTruth,
};

/// Every channel of every instrument draws from its own stream: equal seeds give independent noise.
/// The compiler rejects duplicate numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "each is named by instrument and channel")]
pub enum Stream {
    ImuAccelerometer = 0,
    ImuGyro = 1,
    ImuAttitude = 2,
    DvlBeams = 16,
    DvlCorrelated = 17,
    DvlOutliers = 18,
    DvlDropouts = 19,
    GpsPosition = 32,
    GpsOutliers = 33,
    GpsDropouts = 34,
    Pressure = 48,
    PressureBias = 49,
    PressureOutliers = 50,
    AhrsAttitude = 64,
    AhrsCorrelated = 65,
    AhrsBias = 66,
    Tachometer = 80,
    DisturbanceWrench = 96,
    DisturbanceCurrent = 97,
    DisturbanceThrust = 98,
}

impl From<Stream> for u64 {
    fn from(stream: Stream) -> Self {
        stream as Self
    }
}
