//! The effect of each kind of fault by itself.

use super::*;
use crate::fault::{Begin, Fault};

fn seconds(seconds: f64) -> Time {
    Time::from_seconds(seconds)
}

fn fault(kind: Kind) -> Fault {
    Fault {
        variables: Vec::new(),
        kind,
        begin: Begin::At(seconds(2.0)),
        end: End::At(seconds(5.0)),
        ramp_in: Time::ZERO,
        ramp_out: Time::ZERO,
        every: Time::ZERO,
        installed: None,
    }
}

/// The result for an output 0, 10, 20 … at 0 s, 1 s, 2 s …
fn course(mut acting: Acting, steps: i32) -> Vec<f64> {
    let mut seen = vec![acting.apply(0.0)];
    for step in 1..=steps {
        acting.advance(seconds(f64::from(step - 1)), seconds(f64::from(step)));
        let value = f64::from(step) * 10.0;
        // Called twice, and first with a value that is not final.
        acting.apply(value - 3.0);
        let first = acting.apply(value);
        assert_eq!(acting.apply(value).to_bits(), first.to_bits());
        seen.push(first);
    }
    seen
}

fn output(kind: Kind) -> Vec<f64> {
    course(fault(kind).acting(1, 0, 0, Time::ZERO).installed(Way::Output, Time::ZERO), 6)
}

#[test]
fn each_kind_without_chance_does_what_it_says() {
    let with = |faulty: [f64; 3]| vec![0.0, 10.0, 20.0, faulty[0], faulty[1], faulty[2], 60.0];
    assert_eq!(output(Kind::Override(7.0)), with([7.0; 3]));
    assert_eq!(output(Kind::Bias(0.5)), with([30.5, 40.5, 50.5]));
    assert_eq!(output(Kind::Scale(2.0)), with([60.0, 80.0, 100.0]));
    assert_eq!(output(Kind::Drift(0.5)), with([30.5, 41.0, 51.5]));
    assert_eq!(output(Kind::Ramp { size: 4.0, over: 2.0 }), with([32.0, 44.0, 54.0]));
    assert_eq!(output(Kind::Stuck), with([20.0; 3]));
    assert_eq!(output(Kind::Quantization(40.0)), with([40.0, 40.0, 40.0]));
    assert_eq!(output(Kind::Saturation(0.0, 45.0)), with([30.0, 40.0, 45.0]));
    let lost = |meanwhile| output(Kind::DropOut { turns: None, meanwhile });
    assert_eq!(lost(Meanwhile::Last), with([20.0; 3]));
    assert_eq!(lost(Meanwhile::Zero), with([0.0; 3]));
    assert!(lost(Meanwhile::NotANumber)[3..6].iter().all(|v| v.is_nan()));
    assert!(output(Kind::NotANumber)[3..6].iter().all(|v| v.is_nan()));
    assert_eq!(output(Kind::Latency { delay: 2.0, jitter: 0.0 }), with([10.0, 20.0, 30.0]));
    let half = 10.0 * (1.0 - (-1.0_f64).exp());
    assert_eq!(output(Kind::Lag(1.0))[3], 20.0);
    assert!((output(Kind::Lag(1.0))[4] - (20.0 + half)).abs() < 1e-12);
    assert_eq!(output(Kind::Release), with([30.0, 40.0, 50.0]));
}

#[test]
fn samples_are_taken_late_or_again_on_their_grid() {
    let sampled = |kind: Kind, every: f64, steps| {
        let mut fault = fault(kind);
        (fault.begin, fault.end, fault.every) =
            (Begin::At(seconds(2.0)), End::Never, seconds(every));
        let seen =
            course(fault.acting(1, 0, 0, Time::ZERO).installed(Way::Output, Time::ZERO), steps);
        seen.iter().map(|value| value / 10.0).collect::<Vec<f64>>()
    };
    // Samples at 3 s (the first step), 4 s, 6 s, 8 s; and at 3, 4.5, 6 and 7.5 s.
    let [two, uneven] = [2.0, 1.5].map(|every| sampled(Kind::Sampling, every, 8));
    assert_eq!(two, [0.0, 1.0, 2.0, 3.0, 4.0, 4.0, 6.0, 6.0, 8.0]);
    assert_eq!(uneven, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.0, 7.0, 8.0]);
    let late = |again| sampled(Kind::Reordering { share: 0.3, delay: 2.0, again }, 0.0, 400);
    let (reordered, doubled) = (late(false), late(true));
    let back = |seen: &[f64]| seen.windows(2).filter(|pair| pair[1] < pair[0]).count();
    assert!(back(&reordered) > 50 && back(&doubled) > 50);
    // A value that arrives twice is late by the delay, and no more.
    assert!(doubled.iter().zip(0..).skip(5).all(|(v, step)| {
        let old = f64::from(step) - v;
        old == 0.0 || old == 2.0
    }));
}

#[test]
fn noise_is_drawn_once_a_sample() {
    let mut fault = fault(Kind::WhiteNoise(1.0));
    (fault.begin, fault.end, fault.every) = (Begin::Start, End::Never, seconds(5.0));
    let seen = course(fault.acting(1, 0, 0, Time::ZERO).installed(Way::Output, Time::ZERO), 40);
    let errors: Vec<f64> =
        seen.iter().zip(0..).map(|(v, step)| v - 10.0 * f64::from(step)).collect();
    let changes = errors.windows(2).filter(|pair| (pair[1] - pair[0]).abs() > 1e-9).count();
    assert_eq!(changes, 9, "{errors:?}");
}

#[test]
fn an_input_is_acted_on_from_the_step_that_begins_then() {
    let mut acting =
        fault(Kind::Bias(1.0)).acting(1, 0, 0, Time::ZERO).installed(Way::Input, Time::ZERO);
    let mut seen = Vec::new();
    for step in 0..6 {
        seen.push(acting.apply(0.0));
        acting.advance(seconds(f64::from(step)), seconds(f64::from(step + 1)));
    }
    assert_eq!(seen, [0.0, 0.0, 1.0, 1.0, 1.0, 0.0]);
}

#[test]
fn ramps_blend_and_late_values_keep_their_order() {
    let mut ramped = fault(Kind::Bias(4.0));
    (ramped.ramp_in, ramped.ramp_out) = (seconds(2.0), seconds(1.0));
    let seen = course(ramped.acting(1, 0, 0, Time::ZERO).installed(Way::Output, Time::ZERO), 6);
    assert_eq!(seen, [0.0, 10.0, 20.0, 32.0, 44.0, 50.0, 60.0]);
    let mut late = fault(Kind::Latency { delay: 0.0, jitter: 3.0 });
    late.end = End::Never;
    let seen = course(late.acting(1, 0, 0, Time::ZERO).installed(Way::Output, Time::ZERO), 60);
    assert!(seen[3..].windows(2).all(|pair| pair[0] <= pair[1]), "{seen:?}");
    assert!(seen[3..].iter().zip(3..).any(|(v, step)| *v < f64::from(step) * 10.0));
    assert!(seen[3..].iter().zip(3..).all(|(v, step)| *v >= f64::from(step - 3) * 10.0));
}

#[test]
fn noise_has_its_deviation_and_its_correlation_and_other_variables_other_noise() {
    let long = |kind: Kind, place| {
        let mut fault = fault(kind);
        (fault.begin, fault.end) = (Begin::At(Time::ZERO), End::Never);
        let seen = course(
            fault.acting(5, 1, place, Time::ZERO).installed(Way::Output, Time::ZERO),
            20_000,
        );
        let errors = seen.iter().zip(0..).map(|(v, step)| v - 10.0 * f64::from(step));
        errors.skip(1).collect::<Vec<f64>>()
    };
    let variance = |e: &[f64]| e.iter().map(|v| v * v).sum::<f64>() / e.len() as f64;
    let correlation =
        |e: &[f64]| e.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / (e.len() as f64 * variance(e));
    let white = long(Kind::WhiteNoise(2.0), 0);
    assert!((variance(&white) - 4.0).abs() < 0.3 && correlation(&white).abs() < 0.05);
    assert_ne!(white, long(Kind::WhiteNoise(2.0), 1));
    let coloured = long(Kind::GaussMarkov { sigma: 2.0, tau: 2.0 }, 0);
    assert!((variance(&coloured) - 4.0).abs() < 0.6, "{}", variance(&coloured));
    assert!((correlation(&coloured) - 0.6065).abs() < 0.03, "{}", correlation(&coloured));
    let outliers = long(Kind::Outliers { share: 0.05, size: Spread::Uniform(3.0) }, 0);
    let share = outliers.iter().filter(|e| **e != 0.0).count() as f64 / 2e4;
    assert!((share - 0.05).abs() < 0.01 && outliers.iter().all(|e| e.abs() <= 3.0), "{share}");
}

#[test]
fn a_connection_that_comes_and_goes_is_lost_for_its_share_of_the_time() {
    let mut fault =
        fault(Kind::DropOut { turns: Some((30.0, 10.0)), meanwhile: Meanwhile::NotANumber });
    (fault.begin, fault.end) = (Begin::At(Time::ZERO), End::Never);
    let of = |place| {
        let acting = fault.acting(3, 0, place, Time::ZERO).installed(Way::Output, Time::ZERO);
        course(acting, 40_000).iter().map(|v| v.is_nan()).collect::<Vec<bool>>()
    };
    let lost = of(0);
    let share = lost.iter().filter(|lost| **lost).count() as f64 / 4e4;
    assert!((share - 0.25).abs() < 0.03, "{share}");
    // Variables of one fault are lost together.
    assert_eq!(lost, of(1));
}

#[test]
fn an_instant_that_is_drawn_lies_within_and_a_condition_counts_once() {
    let mut fault = fault(Kind::Override(1.0));
    fault.begin = Begin::Between(seconds(2.0), seconds(4.0));
    let drawn: Vec<Time> =
        (0..50).map(|seed| fault.acting(seed, 0, 0, Time::ZERO).from.unwrap()).collect();
    assert!(drawn.iter().all(|t| *t >= seconds(2.0) && *t <= seconds(4.0)));
    assert_ne!(drawn[0], drawn[1]);
    fault.begin = Begin::When("a > 1".parse().unwrap());
    fault.end = End::After(seconds(3.0));
    let mut acting = fault.acting(1, 4, 0, Time::ZERO);
    acting.trigger(3, seconds(1.0));
    assert_eq!(acting.from, None);
    acting.trigger(4, seconds(2.0));
    acting.trigger(4, seconds(3.0));
    assert_eq!((acting.from, acting.until), (Some(seconds(2.0)), seconds(5.0)));
}

#[test]
fn a_state_that_was_saved_goes_on_in_the_same_way() {
    for kind in [
        Kind::GaussMarkov { sigma: 1.0, tau: 3.0 },
        Kind::Latency { delay: 1.5, jitter: 1.0 },
        Kind::DropOut { turns: Some((2.0, 2.0)), meanwhile: Meanwhile::Last },
        Kind::Reordering { share: 0.5, delay: 3.0, again: false },
        Kind::Lag(2.0),
    ] {
        let mut one = fault(kind).acting(9, 0, 0, Time::ZERO).installed(Way::Output, Time::ZERO);
        one.until = Time::NEVER;
        for step in 1..8 {
            one.advance(seconds(f64::from(step - 1)), seconds(f64::from(step)));
            one.apply(f64::from(step));
        }
        let octets = postcard::to_stdvec(&one).unwrap();
        let mut other: Acting = postcard::from_bytes(&octets).unwrap();
        for step in 8..50 {
            let next = |acting: &mut Acting| {
                acting.advance(seconds(f64::from(step - 1)), seconds(f64::from(step)));
                acting.apply(f64::from(step)).to_bits()
            };
            assert_eq!(next(&mut one), next(&mut other));
        }
    }
}
