//! Instruments that may do anything.

use proptest::prelude::*;
use rexrov::estimation::{Measurements, Reading};

/// The action of an instrument in a cycle.
#[derive(Clone, Copy, Debug)]
pub(super) enum Act {
    Silent,
    Repeat,
    Fresh,
    /// Stamped this many seconds ago, or ahead.
    Aged(f64),
    Unstamped,
    Stamp(f64),
    /// A stuck value with a new stamp.
    Stuck,
    Filled(f64),
    /// One component replaced.
    Spoilt(usize, f64),
    /// All components multiplied: still plausible, but contradictory.
    Exaggerated(f64),
}

fn act() -> impl Strategy<Value = Act> {
    let odd = prop_oneof![
        Just(f64::NAN),
        Just(f64::INFINITY),
        Just(f64::NEG_INFINITY),
        Just(0.0),
        Just(-0.0),
        Just(1e300),
        Just(-1e300),
        Just(1e-300),
        -1e3..1e3,
        -40.0..40.0,
    ];
    prop_oneof![
        4 => Just(Act::Fresh),
        2 => Just(Act::Silent),
        1 => Just(Act::Repeat),
        1 => (-10.0..10.0).prop_map(Act::Aged),
        1 => (0.0..2.5).prop_map(Act::Aged),
        1 => Just(Act::Unstamped),
        1 => odd.clone().prop_map(Act::Stamp),
        1 => Just(Act::Stuck),
        1 => odd.clone().prop_map(Act::Filled),
        1 => (0..8_usize, odd).prop_map(|(i, x)| Act::Spoilt(i, x)),
        1 => (-50.0..50.0).prop_map(Act::Exaggerated),
    ]
}

#[derive(Clone, Debug)]
pub(super) struct Cycle {
    /// Change of the clock (s).
    pub(super) step: f64,
    pub(super) acts: [Act; 6],
    pub(super) noise: [f64; 8],
}

pub(super) fn cycle() -> impl Strategy<Value = Cycle> {
    let step = prop_oneof![
        60 => Just(0.02),
        20 => Just(0.1),
        1 => Just(0.001),
        1 => Just(0.0),
        1 => 0.0..1e-8,
        1 => 0.0..3.0,
        1 => -5.0..0.0,
        1 => Just(-1e6),
        1 => Just(1800.0),
        1 => Just(7200.0),
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
    ];
    (step, prop::array::uniform6(act()), prop::array::uniform8(-1.0..1.0))
        .prop_map(|(step, acts, noise)| Cycle { step, acts, noise })
}

fn apply<const K: usize>(reading: &mut Reading<K>, act: Act, now: f64, fresh: [f64; K]) {
    *reading = match act {
        Act::Silent => Reading { valid: false, ..*reading },
        Act::Repeat => *reading,
        Act::Fresh => Reading::at(now, fresh),
        Act::Aged(age) => Reading::at(now - age, fresh),
        Act::Unstamped => Reading::at(-1.0, fresh),
        Act::Stamp(stamp) => Reading::at(stamp, fresh),
        Act::Stuck => Reading::at(now, reading.value),
        Act::Filled(x) => Reading::at(now, [x; K]),
        Act::Spoilt(i, x) => {
            let mut value = fresh;
            value[i % K] = x;
            Reading::at(now, value)
        }
        Act::Exaggerated(factor) => Reading::at(now, fresh.map(|x| factor * x)),
    };
}

/// Readings of a vehicle that moves slowly, with noise.
pub(super) fn advance(m: &mut Measurements, now: f64, c: &Cycle) {
    let n = c.noise;
    let [imu, thrust, ahrs, depth, dvl, fix] = c.acts;
    apply(&mut m.imu, imu, now, [n[0], n[1], n[2] - 9.81, 0.1 * n[3], 0.1 * n[4], 0.1 * n[5]]);
    apply(&mut m.thrust, thrust, now, n.map(|x| 50.0 * x));
    apply(&mut m.ahrs, ahrs, now, [0.1 * n[6], 0.1 * n[7], 3.0 * n[0]]);
    apply(&mut m.depth, depth, now, [20.0 + n[1]]);
    apply(&mut m.dvl, dvl, now, [0.3 + 0.1 * n[2], 0.1 * n[3], 0.1 * n[4]]);
    apply(&mut m.fix, fix, now, [n[5], n[6], n[7].max(0.0)]);
}
