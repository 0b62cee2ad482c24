//! Model exchange with our solvers, compared with closed forms.

use cosim::fmi::InterfaceType;
use cosim::system::Method::{self, DormandPrince, RungeKutta4};
use cosim::{Overrides, Recording, System};

use crate::models::Model;
use crate::ssd::{Ssd, assert_near, run};

const METHODS: [Method; 2] = [DormandPrince, RungeKutta4];

fn simulate(model: Model, overrides: Overrides) -> Recording {
    run(&System::single(&model.fmu(), &overrides, None).unwrap())
}

#[track_caller]
fn assert_within(found: f64, wanted: f64, tolerance: f64) {
    assert!((found - wanted).abs() <= tolerance, "{found} instead of {wanted}");
}

/// Height of the ball and bounces until `t`, for a ball that keeps half its speed.
fn ball(t: f64) -> (f64, f64) {
    let g = 9.81;
    let (mut begin, mut bounces) = ((2.0_f64 / g).sqrt(), 1.0);
    if t < begin {
        return (1.0 - 0.5 * g * t * t, 0.0);
    }
    let mut speed = 0.5 * g * begin;
    while t >= begin + 2.0 * speed / g {
        begin += 2.0 * speed / g;
        speed *= 0.5;
        bounces += 1.0;
    }
    (speed * (t - begin) - 0.5 * g * (t - begin).powi(2), bounces)
}

#[test]
fn every_bounce_is_found_once_and_where_it_is() {
    for method in METHODS {
        for step in [0.01, 0.1, 0.2] {
            let overrides = Overrides::new().solver(method).step("", step).stop_time(1.2);
            let results = simulate(Model::Ball, overrides);
            let (height, count) = (results.column("y").unwrap(), results.column("n").unwrap());
            for ((&t, &y), &n) in results.time().iter().zip(height).zip(count) {
                let (wanted, bounces) = ball(t);
                // Parabolas are integrated exactly; the instants are located to 1e-10 s.
                assert_within(y, wanted, 1e-8);
                assert_eq!(n, bounces, "{method:?}, step {step}, t = {t}");
            }
        }
    }
}

#[test]
fn time_events_come_once_also_where_steps_end() {
    // 0.3 = 3 * 0.1 differs in the last bit from 0.1 + 0.1 + 0.1; 0.07 falls in between.
    for (period, events) in [(0.3_f64, 11.0), (0.1, 31.0), (0.07, 43.0), (0.01, 301.0)] {
        let overrides = Overrides::new().start_value("k", period).stop_time(3.0);
        let results = simulate(Model::Ticker, overrides);
        assert_eq!(results.column("n").unwrap().last(), Some(&events), "period {period}");
        let first = results.column("n").unwrap()[1];
        assert_eq!(first, 1.0 + f64::floor((0.1 + 1e-9) / period));
    }
}

#[test]
fn an_oscillator_with_a_fast_mode_follows_its_closed_form() {
    let error = |overrides: Overrides| {
        let overrides = overrides.stop_time(2.0).output_variables(["x", "s"]);
        let results = simulate(Model::Oscillator, overrides);
        let (x, s) = (results.column("x").unwrap(), results.column("s").unwrap());
        let errors = results
            .time()
            .iter()
            .zip(x.iter().zip(s))
            .map(|(t, (x, s))| (x - (20.0 * t).cos()).abs().max((s - t.sin()).abs()));
        errors.fold(0.0, f64::max)
    };
    let (coarse, fine) =
        (error(Overrides::new().tolerance(1e-5)), error(Overrides::new().tolerance(1e-8)));
    assert!(coarse < 1e-2 && fine < 1e-5 && fine < coarse / 100.0, "{coarse} {fine}");
    // Fixed steps: order 4, once they are stable.
    let rk4 =
        |step| error(Overrides::new().solver(RungeKutta4).step("", step).output_interval(0.1));
    let slope = (rk4(0.002) / rk4(0.001)).log2();
    assert!((slope - 4.0).abs() < 0.3, "{slope}");
}

#[test]
fn step_events_are_handled() {
    for method in METHODS {
        let overrides = Overrides::new().solver(method).stop_time(3.5);
        let results = simulate(Model::Sawtooth, overrides);
        let (y, n) = (results.column("y").unwrap(), results.column("n").unwrap());
        for ((t, y), n) in results.time().iter().zip(y).zip(n) {
            assert_within(y + n, *t, 1e-9);
        }
        assert_eq!(n.last(), Some(&3.0));
    }
}

#[test]
fn a_component_of_a_system_may_be_of_model_exchange() {
    // x' = u - x/2 with u held at 0, 0.1, 0.2 ...: x grows by a closed form per step.
    let ssd = Ssd::new().add("clock", Model::Clock).add("x", Model::Lag).connect("clock.y", "x.u");
    let results = ssd.stop(1.0).run();
    let (y, n) = (results.column("x.y").unwrap(), results.column("x.n").unwrap());
    let mut wanted = vec![0.0];
    for step in 0..10 {
        let (u, x) = (0.1 * f64::from(step), wanted[wanted.len() - 1]);
        wanted.push(2.0 * u + (x - 2.0 * u) * (-0.05_f64).exp());
    }
    y.iter().zip(&wanted).for_each(|(y, w)| assert_within(*y, *w, 1e-7));
    // The input moves the indicator u - 0.5 above 0 once: at 0.6, used from there on.
    assert_near(n, &[1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0]);
}

#[test]
fn a_discrete_input_is_set_in_event_mode() {
    let ssd =
        Ssd::new().add("c", Model::Counter).add("t", Model::Ticker).connect("c.n", "t.m").stop(0.3);
    assert_near(ssd.run().column("t.even").unwrap(), &[0.0, 0.0, 1.0, 1.0]);
}

#[test]
fn the_interface_type_must_be_there() {
    let me = Overrides::new().interface("", InterfaceType::ModelExchange);
    let error = System::single(&Model::Gain.fmu(), &me, None).err().unwrap().to_string();
    assert!(error.contains("no model exchange part"), "{error}");
    let ssd = Ssd::new().add("x", Model::Lag);
    let cs = Overrides::new().interface("x", InterfaceType::CoSimulation);
    assert!(ssd.load(&cs).err().unwrap().to_string().contains("no co-simulation part"));
    let typo = Overrides::new().interface("y", InterfaceType::CoSimulation);
    assert!(ssd.load(&typo).err().unwrap().to_string().contains("'x'"));
    assert!(ssd.load(&Overrides::new().tolerance(0.0)).is_err());
}
