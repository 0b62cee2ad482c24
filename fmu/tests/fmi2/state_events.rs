//! State events compared with closed forms, in co-simulation and in model exchange with a solver
//! that does its own root finding.

use fmu_kit::abi::types::*;
use fmu_kit::kernel::Status;

use crate::components::fmi2;
use crate::driver::{CS, Fmu, ME};
use crate::hybrid::{GRAVITY, LIMIT, RESTITUTION};

/// Height and bounces of a ball dropped from 1 m.
fn ball(t: f64) -> (f64, f64) {
    let (mut start, mut speed, mut bounces) = ((2.0 / GRAVITY).sqrt(), (2.0 * GRAVITY).sqrt(), 0.0);
    if t < start {
        return (1.0 - 0.5 * GRAVITY * t * t, 0.0);
    }
    loop {
        (speed, bounces) = (RESTITUTION * speed, bounces + 1.0);
        let end = start + 2.0 * speed / GRAVITY;
        if speed < 0.05 {
            return (0.0, bounces);
        }
        if t < end {
            let s = t - start;
            return (speed * s - 0.5 * GRAVITY * s * s, bounces);
        }
        start = end;
    }
}

/// Level of the limited integral of the cosine, over the first two turns.
fn level(t: f64) -> f64 {
    use std::f64::consts::{FRAC_PI_2, PI};
    let t = if t > 2.0 * PI + FRAC_PI_2 { t - 2.0 * PI } else { t };
    match t {
        _ if t < LIMIT.asin() => t.sin(),
        _ if t < FRAC_PI_2 => LIMIT,
        _ if t < PI => LIMIT + t.sin() - 1.0,
        _ if t < 3.0 * FRAC_PI_2 => -LIMIT,
        _ if t < 2.0 * PI => -LIMIT + t.sin() + 1.0,
        _ => LIMIT,
    }
}

fn ok(status: Status) {
    assert_eq!(status, Status::Ok);
}

/// A minimal importer's solver: classical Runge-Kutta and bisection of indicators.
struct Solver {
    fmu: Fmu,
    t: f64,
    x: Vec<f64>,
    positive: Vec<bool>,
}

impl Solver {
    fn new(name: &'static str, states: usize, indicators: usize) -> Self {
        let mut solver = Self {
            fmu: Fmu::started(name, ME),
            t: 0.0,
            x: vec![0.0; states],
            positive: vec![false; indicators],
        };
        solver.events();
        solver
    }

    fn put(&self, t: f64, x: &[f64]) {
        unsafe {
            ok(fmi2::fmi2SetTime(self.fmu.c, t));
            ok(fmi2::fmi2SetContinuousStates(self.fmu.c, x.as_ptr(), x.len()));
        }
    }

    fn slope(&self, t: f64, x: &[f64]) -> Vec<f64> {
        self.put(t, x);
        let mut k = vec![0.0; x.len()];
        ok(unsafe { fmi2::fmi2GetDerivatives(self.fmu.c, k.as_mut_ptr(), k.len()) });
        k
    }

    fn signs(&self, t: f64, x: &[f64]) -> Vec<bool> {
        self.put(t, x);
        let mut z = vec![0.0; self.positive.len()];
        ok(unsafe { fmi2::fmi2GetEventIndicators(self.fmu.c, z.as_mut_ptr(), z.len()) });
        z.iter().map(|z| *z > 0.0).collect()
    }

    fn step(&self, h: f64) -> Vec<f64> {
        let (t, x) = (self.t, &self.x);
        let ahead = |k: &[f64], h: f64| x.iter().zip(k).map(|(x, k)| x + h * k).collect::<Vec<_>>();
        let k1 = self.slope(t, x);
        let k2 = self.slope(t + 0.5 * h, &ahead(&k1, 0.5 * h));
        let k3 = self.slope(t + 0.5 * h, &ahead(&k2, 0.5 * h));
        let k4 = self.slope(t + h, &ahead(&k3, h));
        (0..x.len()).map(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i])).collect()
    }

    fn advance(&mut self, h: f64) {
        let end = self.t + h;
        while end - self.t > 1e-13 {
            let rest = end - self.t;
            let there = self.step(rest);
            if self.signs(end, &there) == self.positive {
                (self.t, self.x) = (end, there);
                self.put(end, &self.x);
                return;
            }
            let (mut before, mut behind) = (0.0, rest);
            while behind - before > 1e-13 {
                let middle = 0.5 * (before + behind);
                if self.signs(self.t + middle, &self.step(middle)) == self.positive {
                    before = middle;
                } else {
                    behind = middle;
                }
            }
            (self.x, self.t) = (self.step(behind), self.t + behind);
            self.put(self.t, &self.x);
            ok(unsafe { fmi2::fmi2EnterEventMode(self.fmu.c) });
            self.events();
        }
    }

    /// Event mode until nothing changes any more, then on with the solver.
    fn events(&mut self) {
        let mut rounds = 0;
        loop {
            let mut info = fmi2EventInfo::default();
            ok(unsafe { fmi2::fmi2NewDiscreteStates(self.fmu.c, &raw mut info) });
            if info.newDiscreteStatesNeeded == FMI2_FALSE {
                break;
            }
            rounds += 1;
            assert!(rounds < 10);
        }
        let (c, n) = (self.fmu.c, self.x.len());
        unsafe {
            ok(fmi2::fmi2EnterContinuousTimeMode(c));
            ok(fmi2::fmi2GetContinuousStates(c, self.x.as_mut_ptr(), n));
        }
        self.positive = self.signs(self.t, &self.x.clone());
    }
}

#[test]
fn a_ball_bounces_as_its_closed_form_and_comes_to_rest() {
    for method in [1, 2] {
        let mut cs = Fmu::new("Ball", CS);
        cs.set_integer("integrator.method", method);
        assert_eq!((cs.setup(0.0), cs.initialize()), (Status::Ok, Status::Ok));
        let mut me = Solver::new("Ball", 2, 1);
        for k in 0..400 {
            let t = f64::from(k) * 0.013;
            assert_eq!(cs.step(t, 0.013), Status::Ok, "{:?}", cs.log());
            me.advance(0.013);
            let (height, bounces) = ball(t + 0.013);
            assert!((cs.get("height") - height).abs() < 1e-10, "{t}");
            assert!((me.fmu.get("height") - height).abs() < 1e-10, "{t}");
            assert_eq!([cs.get("bounces"), me.fmu.get("bounces")], [bounces; 2], "{t}");
        }
        assert!(cs.get("bounces") > 15.0);
        assert_eq!(cs.get("height"), 0.0);
    }
}

#[test]
fn one_long_step_meets_the_same_events_as_many_short_ones() {
    let mut long = Fmu::started("Ball", CS);
    assert_eq!(long.step(0.0, 2.0), Status::Ok);
    let (height, bounces) = ball(2.0);
    assert!((long.get("height") - height).abs() < 1e-10);
    assert_eq!(long.get("bounces"), bounces);
}

#[test]
fn a_limited_integrator_saturates_and_leaves_without_winding_up() {
    for method in [1, 2] {
        let mut cs = Fmu::with("Limiter", CS, FMI2_TRUE, None).unwrap();
        cs.set_integer("integrator.method", method);
        assert_eq!((cs.setup(0.0), cs.initialize()), (Status::Ok, Status::Ok));
        cs.log();
        let mut me = Solver::new("Limiter", 1, 2);
        for k in 0..120 {
            let t = f64::from(k) * 0.07;
            assert_eq!(cs.step(t, 0.07), Status::Ok);
            me.advance(0.07);
            let closed = level(t + 0.07);
            assert!((cs.get("level") - closed).abs() < 1e-7, "{t}: {}", cs.get("level") - closed);
            assert!((me.fmu.get("level") - closed).abs() < 1e-7, "{t}");
        }
        // Eight changes of mode in 8.4 s, and as often the indicator of the new mode moves off
        // zero: no chattering.
        assert!(cs.log().len() <= 16);
    }
}

#[test]
fn a_component_that_chatters_is_stopped_and_the_indicator_named() {
    let mut fmu = Fmu::started("Chatterer", CS);
    assert_eq!(fmu.step(0.0, 0.05), Status::Ok);
    assert_eq!(fmu.step(0.05, 0.1), Status::Error);
    let line = fmu.line();
    assert!(line.contains("chatters") && line.contains("\"side\""), "{line}");
}

#[test]
fn the_description_counts_the_indicators() {
    let text = crate::components::REGISTRY.named("Limiter").unwrap().describe().unwrap();
    assert!(text.contains("numberOfEventIndicators=\"2\""));
}

/// The integral of a ramp that is clipped at 1 is exact only if the kink is found: it is within the
/// one integration step.
#[test]
fn kinks_of_inputs_are_found_while_inputs_move() {
    for method in [1, 2] {
        let mut fmu = Fmu::with("Clipper", CS, FMI2_TRUE, None).unwrap();
        fmu.set_integer("integrator.method", method);
        assert_eq!((fmu.setup(0.0), fmu.initialize()), (Status::Ok, Status::Ok));
        fmu.log();
        let mut level = 0.0;
        for (t, slope) in [(0.0, 30.0), (0.1, 0.0), (0.2, -47.0), (0.3, 0.0), (0.4, 20.0)] {
            let start = fmu.get("rate");
            let (vr, order, slope) = (fmu.reference("rate"), 1, slope);
            let (vr, order, slope_at) = (&raw const vr, &raw const order, &raw const slope);
            ok(unsafe { fmi2::fmi2SetRealInputDerivatives(fmu.c, vr, 1, order, slope_at) });
            assert_eq!(fmu.step(t, 0.1), Status::Ok);
            level += clipped_ramp(start, start + 0.1 * slope, 0.1);
            let error = fmu.get("level") - level;
            assert!(error.abs() < 1e-11, "{t}: {error}");
        }
        // Up through 1, down through both, up through -1.
        let events: Vec<_> = fmu.log().into_iter().map(|line| line.text).collect();
        assert_eq!(events.len(), 3, "{events:?}");
        assert!(events[1].contains("2 events"), "{events:?}");
    }
}

/// Integral of a ramp from a to b over h, clipped at 1 and -1.
fn clipped_ramp(a: f64, b: f64, h: f64) -> f64 {
    if a == b {
        return h * a.clamp(-1.0, 1.0);
    }
    // Antiderivative of the clipped value.
    let sum = |v: f64| if v.abs() < 1.0 { 0.5 * v * v } else { v.abs() - 0.5 };
    h * (sum(b) - sum(a)) / (b - a)
}

#[test]
fn kinks_of_inputs_are_no_events_while_inputs_are_held() {
    let mut fmu = Fmu::with("Clipper", CS, FMI2_TRUE, None).unwrap();
    assert_eq!((fmu.setup(0.0), fmu.initialize()), (Status::Ok, Status::Ok));
    fmu.log();
    for (k, rate) in [0.5, 7.0, 0.5, -3.0].into_iter().enumerate() {
        fmu.set("rate", rate);
        assert_eq!(fmu.step(0.2 * k as f64, 0.2), Status::Ok);
    }
    assert!((fmu.get("level") - 0.2 * (0.5 + 1.0 + 0.5 - 1.0)).abs() < 1e-15);
    assert_eq!(fmu.log(), []);
}
