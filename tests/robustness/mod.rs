//! Whatever inputs a filter gets, in whatever order, its estimate remains valid.

mod acts;
mod facts;
mod late;

use acts::*;
use facts::*;
use proptest::prelude::*;
use rexrov::estimation::*;

/// Cycles of a clock that may step, with instruments that may do anything.
struct Anything(Vec<Cycle>);

impl Fact for Anything {
    fn check<F: Navigation<Memory = Memory<N, M>>, const N: usize, M: Copy>(
        &self,
        filter: &F,
    ) -> Check {
        let (mut memory, mut m, mut now) = (filter.memory(), Measurements::default(), 0.0);
        for cycle in &self.0 {
            advance(&mut m, now, cycle);
            let estimate = filter.update(&mut memory, now + cycle.step, &m);
            sound(&estimate, &memory)?;
            if cycle.step.is_finite() {
                now = f64::max(0.0, now + cycle.step);
            }
        }
        Ok(())
    }
}

/// A subset of the sensors, healthy: absent ones are not fused.
struct Absent([bool; 6]);

impl Fact for Absent {
    fn check<F: Navigation<Memory = Memory<N, M>>, const N: usize, M: Copy>(
        &self,
        filter: &F,
    ) -> Check {
        let (mut memory, mut m) = (filter.memory(), Measurements::default());
        let mut estimate = Estimate::default();
        for k in 0..400_u32 {
            let now = f64::from(k) * 0.02;
            let noise = core::array::from_fn(|i| libm::sin(f64::from(k * (i as u32 + 3))));
            let acts = self.0.map(|there| if there { Act::Fresh } else { Act::Silent });
            advance(&mut m, now, &Cycle { step: 0.0, acts, noise });
            estimate = filter.update(&mut memory, now, &m);
            sound(&estimate, &memory)?;
        }
        let [_, _, ahrs, depth, dvl, fix] = self.0;
        for (channel, there) in [(1, ahrs), (2, depth), (3, dvl), (4, fix)] {
            prop_assert_eq!(estimate.channels[channel].used > 0, there, "channel {}", channel);
        }
        prop_assert!(ahrs || estimate.channels[0].used == 0);
        Ok(())
    }
}

/// Only the driving signals, for a vehicle that stays where it is.
struct Unaided {
    imu: bool,
    thrust: bool,
}

impl Fact for Unaided {
    fn check<F: Navigation<Memory = Memory<N, M>>, const N: usize, M: Copy>(
        &self,
        filter: &F,
    ) -> Check {
        let (mut memory, mut m, mut last) = (filter.memory(), Measurements::default(), [0.0; 3]);
        for k in 0..3000 {
            let now = f64::from(k) * 0.02;
            if self.imu {
                let tremble = 1e-6 * f64::from(k % 2);
                m.imu = Reading::at(now, [tremble, 0.0, -9.81, 0.0, 0.0, 0.0]);
            }
            if self.thrust {
                m.thrust = Reading::at(now, [0.0; 8]);
            }
            let estimate = filter.update(&mut memory, now, &m);
            sound(&estimate, &memory)?;
            let Some(belief) = memory.belief() else { continue };
            // The force balance measures the velocity, and with it some of the displacement.
            let balanced = self.imu && self.thrust;
            let slack = if balanced { 1e-4 } else { 1e-12 };
            for (i, last) in last.iter_mut().enumerate() {
                let variance = belief.covariance[(i, i)];
                prop_assert!(
                    variance >= *last * (1.0 - slack),
                    "{} t {} state {}: {} after {}",
                    core::any::type_name::<F>(),
                    now,
                    i,
                    variance,
                    *last
                );
                *last = variance;
            }
        }
        Ok(())
    }
}

/// An inertial unit and thrusts at this rate, fixes as late as permitted, then a long silence.
struct Burst {
    hz: u32,
    fixes: Option<u32>,
}

impl Fact for Burst {
    fn check<F: Navigation<Memory = Memory<N, M>>, const N: usize, M: Copy>(
        &self,
        filter: &F,
    ) -> Check {
        let (mut memory, mut m) = (filter.memory(), Measurements::default());
        for k in 0..8 * self.hz {
            let now = f64::from(k) / f64::from(self.hz);
            let x = libm::sin(f64::from(k));
            m.imu = Reading::at(now, [0.01 * x, 0.0, -9.81, 0.0, 0.0, 0.001 * x]);
            m.thrust = Reading::at(now, [x; 8]);
            if k % (self.hz / 10) == 0 {
                m.ahrs = Reading::at(now, [0.01 * x, 0.01, 0.01]);
            }
            if k % self.hz == 0 && now > 2.5 {
                m.fix = Reading::at(now - 2.4, [x, 0.1, 0.0]);
            }
            let estimate = filter.update(&mut memory, now, &m);
            sound(&estimate, &memory).map_err(|e| {
                TestCaseError::fail(format!("{} {now} s: {e}", core::any::type_name::<F>()))
            })?;
        }
        let estimate = filter.update(&mut memory, 3_000.0, &m);
        sound(&estimate, &memory)?;
        if let Some(fixes) = self.fixes {
            prop_assert_eq!(estimate.channels[4].used, fixes, "{:?}", estimate.channels[4]);
        }
        Ok(())
    }
}

/// A clock that is set while the filter runs.
struct Jump;

impl Fact for Jump {
    fn check<F: Navigation<Memory = Memory<N, M>>, const N: usize, M: Copy>(
        &self,
        filter: &F,
    ) -> Check {
        let (mut memory, mut m) = (filter.memory(), Measurements::default());
        for now in [0.0, 0.1, 1.7e9, 1.7e9 + 0.1] {
            m.fix = Reading::at(now, [1.0, 2.0 + 1e-10 * now, 0.0]);
            sound(&filter.update(&mut memory, now, &m), &memory)?;
        }
        Ok(())
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(std::env::var("CASES").map_or(24, |n| n.parse().unwrap())))]

    #[test]
    fn anything_goes(cycles in prop::collection::vec(cycle(), 1..100), extra in any::<bool>()) {
        for_all(&Anything(cycles), extra)?;
    }

    #[test]
    fn an_absent_sensor_is_not_fused(there in prop::array::uniform6(any::<bool>())) {
        for_all(&Absent(there), false)?;
    }
}

#[test]
fn an_unaided_filter_knows_less_and_less() {
    for (imu, thrust) in [(false, false), (true, false), (false, true), (true, true)] {
        for_all(&Unaided { imu, thrust }, false).unwrap();
    }
}

#[test]
fn samples_at_a_hundred_hertz_leave_room_for_late_fixes() {
    for_all(&Burst { hz: 100, fixes: Some(5) }, false).unwrap();
}

#[test]
fn samples_at_a_kilohertz_do_no_harm() {
    for_all(&Burst { hz: 1000, fixes: None }, false).unwrap();
}

#[test]
fn a_clock_that_is_set_is_not_lived_through() {
    for_all(&Jump, false).unwrap();
}
