//! Faults in recorded events. Times are stamps: from (included), to (excluded).

use super::{Data, Event, Kind};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};
use rexrov::attitude::wrap;
use rexrov::sensors::Gaussian;

impl Data {
    /// The numbers of a sample.
    pub fn values(&self) -> Vec<f64> {
        match *self {
            Self::Imu { specific_force, rate } => [specific_force, rate].concat(),
            Self::Thrust(thrust) => thrust.to_vec(),
            Self::Ahrs(v) | Self::Dvl(v) => v.to_vec(),
            Self::Fix(v) => v.to_vec(),
            Self::Depth(depth) => vec![depth],
        }
    }

    fn values_mut(&mut self) -> Vec<&mut f64> {
        match self {
            Self::Imu { specific_force, rate } => specific_force.iter_mut().chain(rate).collect(),
            Self::Thrust(thrust) => thrust.iter_mut().collect(),
            Self::Ahrs(v) | Self::Dvl(v) => v.iter_mut().collect(),
            Self::Fix(v) => v.iter_mut().collect(),
            Self::Depth(depth) => vec![depth],
        }
    }
}

fn of(events: &mut [Event], kind: Kind, from: f64, to: f64) -> impl Iterator<Item = &mut Event> {
    events.iter_mut().filter(move |e| e.data.kind() == kind && e.stamp >= from && e.stamp < to)
}

fn fill(events: &mut [Event], kind: Kind, from: f64, to: f64, value: f64) {
    for event in of(events, kind, from, to) {
        event.data.values_mut().into_iter().for_each(|v| *v = value);
    }
}

/// By arrival, then stamp.
fn sort(events: &mut [Event]) {
    events.sort_by(|a, b| a.arrival.total_cmp(&b.arrival).then(a.stamp.total_cmp(&b.stamp)));
}

/// In [0, 1).
fn uniform(rng: &mut ChaCha8Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

/// The samples are missing.
pub fn drop(events: &mut Vec<Event>, kind: Kind, from: f64, to: f64) {
    events.retain(|e| e.data.kind() != kind || e.stamp < from || e.stamp >= to);
}

/// All samples arrive late by `seconds`.
pub fn delay(events: &mut [Event], kind: Kind, seconds: f64) {
    of(events, kind, f64::MIN, f64::MAX).for_each(|e| e.arrival += seconds);
    sort(events);
}

/// Samples arrive late by 0 to `max` seconds each, so some overtake others.
pub fn jitter(events: &mut [Event], kind: Kind, max: f64, seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    of(events, kind, f64::MIN, f64::MAX).for_each(|e| e.arrival += max * uniform(&mut rng));
    sort(events);
}

/// A `share` of the samples is off by a vector of length `low` to `high` in any direction.
pub fn outliers(events: &mut [Event], kind: Kind, share: f64, low: f64, high: f64, seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = Gaussian::new(seed, 2000_u64);
    for event in of(events, kind, f64::MIN, f64::MAX) {
        let (hit, length) = (uniform(&mut rng) < share, low + (high - low) * uniform(&mut rng));
        let mut values = event.data.values_mut();
        let direction: Vec<f64> = values.iter().map(|_| normal.draw()).collect();
        let norm = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
        if hit {
            values.iter_mut().zip(direction).for_each(|(v, d)| **v += length * d / norm);
        }
        if let Data::Ahrs([roll, _, yaw]) = &mut event.data {
            (*roll, *yaw) = (wrap(*roll), wrap(*yaw));
        }
    }
}

/// The last sample before `from` is repeated.
pub fn stuck(events: &mut [Event], kind: Kind, from: f64, to: f64) {
    let before = events.iter().filter(|e| e.data.kind() == kind && e.stamp < from);
    let last = before.max_by(|a, b| a.stamp.total_cmp(&b.stamp)).map(|e| e.data);
    let last = last.expect("no sample before the fault");
    of(events, kind, from, to).for_each(|e| e.data = last);
}

/// All numbers are zero.
pub fn zero(events: &mut [Event], kind: Kind, from: f64, to: f64) {
    fill(events, kind, from, to, 0.0);
}

/// No value is a number.
pub fn nan(events: &mut [Event], kind: Kind, from: f64, to: f64) {
    fill(events, kind, from, to, f64::NAN);
}

/// The sensor's clock jumps: stamps from `from` on change by `seconds`, arrivals stay.
pub fn shift_clock(events: &mut [Event], kind: Kind, from: f64, seconds: f64) {
    of(events, kind, from, f64::MAX).for_each(|e| e.stamp += seconds);
    sort(events);
}

/// The compass is off by `rad` from `from` on.
pub fn heading_step(events: &mut [Event], from: f64, rad: f64) {
    for event in of(events, Kind::Ahrs, from, f64::MAX) {
        if let Data::Ahrs([_, _, yaw]) = &mut event.data {
            *yaw = wrap(*yaw + rad);
        }
    }
}
