//! An independent implementation of the processes and sensors of the navigation filters, for any
//! number type, so that dual numbers give their derivatives. It shares no code with the product.
#![allow(unreachable_pub, reason = "a part of a test binary")]

mod hull;
mod numbers;
mod processes;

pub use hull::Hull;
pub use numbers::*;
pub use processes::*;

/// A vehicle's motion as seen by the sensors.
#[derive(Clone, Copy, Debug)]
pub struct Motion<D> {
    pub position: V3<D>,
    pub rotation: M3<D>,
    pub velocity: V3<D>,
    pub rate: V3<D>,
    pub acceleration: V3<D>,
    /// Bias of the compass; scale, misalignment and delay of the velocity log.
    pub sensors: [D; 4],
}

impl<D: Number> Motion<D> {
    pub fn tilt(&self) -> [D; 2] {
        let r = &self.rotation;
        [r[2][1].atan2(r[2][2]), -r[2][0].asin()]
    }

    pub fn heading(&self) -> [D; 1] {
        [self.rotation[1][0].atan2(self.rotation[0][0]) + self.sensors[0]]
    }

    fn point(&self, lever: [f64; 3]) -> V3<D> {
        plus(self.position, image(&self.rotation, lift(lever)))
    }

    pub fn depth(&self, lever: [f64; 3]) -> [D; 1] {
        [self.point(lever)[2]]
    }

    pub fn fix(&self, lever: [f64; 3]) -> [D; 2] {
        let [x, y, _] = self.point(lever);
        [x, y]
    }

    pub fn dvl(&self, lever: [f64; 3]) -> V3<D> {
        let [_, scale, m, delay] = self.sensors;
        let v = plus(self.velocity, cross(self.rate, lift(lever)));
        let [x, y, z] = minus(v, times(self.acceleration, delay));
        times([m.cos() * x + m.sin() * y, m.cos() * y - m.sin() * x, z], scale + 1.0)
    }
}
