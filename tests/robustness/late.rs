//! Late measurements are as good as timely ones: the same belief to the last bit.

use super::facts::*;
use crate::mission::{Kind, Mission, Options, fly, jitter};
use crate::scoring::set;
use proptest::prelude::*;
use rexrov::estimation::{Estimate, Measurements, Memory, Navigation};
use rexrov::guidance::Course;

/// One update per event, as they arrive.
fn deliver<F: Navigation<Memory = Memory<N, M>>, const N: usize, M: Copy>(
    filter: &F,
    mission: &Mission,
) -> (Memory<N, M>, Estimate) {
    let (mut memory, mut m) = (filter.memory(), Measurements::default());
    filter.update(&mut memory, 0.0, &m);
    for event in &mission.events {
        set(&mut m, event);
        filter.update(&mut memory, event.arrival, &m);
    }
    // Later than any latency, and than any wait for a driving signal.
    let end = mission.truth.last().unwrap().time + 5.0;
    let estimate = filter.update(&mut memory, end, &Measurements::default());
    (memory, estimate)
}

/// The same events in order and out of order.
struct Shuffled {
    in_order: Mission,
    shuffled: Mission,
}

impl Shuffled {
    /// `known`: the available inputs; `late`: those that arrive up to 2.4 s late.
    fn new(seed: u64, known: &[Kind], late: &[Kind]) -> Self {
        let options = Options { duration_s: 20.0, ..Options::nominal(Course::BE3, seed) };
        let mut in_order = fly(&options);
        in_order.events.retain(|event| known.contains(&event.data.kind()));
        let mut shuffled = in_order.clone();
        for (k, &kind) in late.iter().enumerate() {
            jitter(&mut shuffled.events, kind, 2.4, seed + k as u64);
        }
        Self { in_order, shuffled }
    }
}

impl Fact for Shuffled {
    fn check<F: Navigation<Memory = Memory<N, M>>, const N: usize, M: Copy>(
        &self,
        filter: &F,
    ) -> Check {
        let (a, first) = deliver(filter, &self.in_order);
        let (b, second) = deliver(filter, &self.shuffled);
        let used = |e: &Estimate| e.channels.map(|c| (c.used, c.rejected));
        prop_assert_eq!(used(&first), used(&second));
        prop_assert!(second.channels.iter().any(|c| c.late > 0));
        let (a, b) = (a.belief().unwrap(), b.belief().unwrap());
        let off = (a.covariance - b.covariance).amax().max((a.mean - b.mean).amax());
        prop_assert!(a == b, "{} differs by up to {}", core::any::type_name::<F>(), off);
        Ok(())
    }
}

const AIDING: [Kind; 4] = [Kind::Ahrs, Kind::Depth, Kind::Dvl, Kind::Fix];
const DRIVING: [Kind; 2] = [Kind::Imu, Kind::Thrust];
const ALL: [Kind; 6] = [Kind::Ahrs, Kind::Depth, Kind::Dvl, Kind::Fix, Kind::Imu, Kind::Thrust];

fn shuffle(known: &[Kind], late: &[Kind]) {
    for seed in 1..3 {
        for_all(&Shuffled::new(seed, known, late), false).unwrap();
    }
}

#[test]
fn late_measurements() {
    shuffle(&ALL, &AIDING);
}

#[test]
fn late_drives() {
    shuffle(&ALL, &DRIVING);
    shuffle(&ALL, &ALL);
}

#[test]
fn without_an_inertial_unit() {
    let known = [Kind::Ahrs, Kind::Depth, Kind::Dvl];
    for late in [&[Kind::Dvl][..], &[Kind::Ahrs], &known] {
        shuffle(&known, late);
    }
}

#[test]
fn without_an_inertial_unit_but_with_thrusts() {
    let known = [Kind::Ahrs, Kind::Depth, Kind::Dvl, Kind::Thrust];
    shuffle(&known, &known);
}
