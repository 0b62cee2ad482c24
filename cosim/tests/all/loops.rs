//! Algebraic loops solved by iteration.

use cosim::{Algorithm, Overrides};

use crate::models::Model::{Affine, Clock, Cubic, Gain};
use crate::ssd::{Ssd, assert_near, run};

fn iterative() -> Overrides {
    Overrides::new().algorithm(Algorithm::Iterative)
}

fn pair(a: f64, b: f64) -> Ssd {
    Ssd::new()
        .add_with("a", Affine, &[("k", a)], None)
        .add_with("b", Affine, &[("k", b)], None)
        .connect("b.y", "a.u")
        .connect("a.y", "b.u")
        .stop(0.3)
}

#[test]
fn a_linear_loop_has_its_exact_values_at_every_step() {
    // a = ka b + t, b = kb a + t. The second pair diverges in fixed-point passes.
    for (ka, kb) in [(0.1, 0.2), (2.0, 3.0), (-4.0, 1.0)] {
        let system = pair(ka, kb).load(&iterative()).unwrap();
        assert!(system.warnings().is_empty() && system.notes()[0].contains("solved at each step"));
        let mut recording = cosim::Recording::new();
        let summary = system.run(&mut [&mut recording]).unwrap();
        assert!(summary.warnings.is_empty(), "{:?}", summary.warnings);
        assert!(summary.notes[0].contains("loop through a, b: "), "{:?}", summary.notes);
        let wanted = |t: f64| (ka + 1.0) * t / (1.0 - ka * kb);
        assert_near(recording.column("a.y").unwrap(), &[0.0, 0.1, 0.2, 0.3].map(wanted));
    }
}

#[test]
fn it_is_solved_at_the_start_and_with_members_of_other_steps() {
    // At t = 1 the initialization has a solution that is not zero.
    let system = pair(2.0, 3.0).load(&iterative().start_time(1.0).stop_time(1.4).step("b", 0.2));
    let results = run(&system.unwrap());
    let (a, b) = (results.column("a.y").unwrap(), results.column("b.y").unwrap());
    assert_near(&[a[0], b[0]], &[-0.6, -0.8]);
    // b holds at 1.1 and keeps -0.8; both are solved together at 1.2.
    assert_near(&[a[1], b[1]], &[2.0 * -0.8 + 1.1, -0.8]);
    assert_near(&[a[2], b[2]], &[-0.6 * 1.2, -0.8 * 1.2]);
}

#[test]
fn a_nonlinear_loop_and_what_it_feeds() {
    let ssd = Ssd::new()
        .add_with("after", Gain, &[("k", 2.0)], None)
        .add_with("x", Cubic, &[("k", 5.0)], None)
        .add("clock", Clock)
        .connect("x.y", "x.u")
        .connect("x.y", "after.u")
        .stop(1.0);
    let results = run(&ssd.load(&iterative().start_time(0.5)).unwrap());
    let (x, after) = (results.column("x.y").unwrap(), results.column("after.y").unwrap());
    for ((t, x), after) in results.time().iter().zip(x).zip(after) {
        assert!((x + 5.0 * x.powi(3) - t).abs() < 1e-8, "t = {t}: {x}");
        assert_eq!(*after, 2.0 * x);
    }
}

#[test]
fn a_loop_without_a_solution_ends_the_run_with_its_residual() {
    let ssd = Ssd::new().add_with("a", Affine, &[("k", 1.0)], None).connect("a.y", "a.u").stop(0.2);
    let error = ssd.load(&iterative()).unwrap().run(&mut []).unwrap_err();
    assert_eq!(error.code(), cosim::Code::Loop);
    // At t = 0, where the initialization solves it, any value is a solution.
    assert!(error.what().contains("the loop through a has no solution at t = 0.1 s"), "{error}");
    assert!(error.reason().unwrap().contains("the residual is "), "{error}");
}

#[test]
fn members_must_be_able_to_go_back() {
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("x.fmu");
    let description = Affine.description().replace("canGetAndSetFMUstate=\"true\"", "");
    let library = std::fs::read(crate::models::compile(Affine)).unwrap();
    let entries = [
        ("modelDescription.xml", description.into_bytes()),
        ("binaries/linux64/AFFINE.so", library),
    ];
    crate::models::pack(&path, &entries);
    let error = pair(0.1, 0.2).load(&iterative().replace("b", &path)).err().unwrap().to_string();
    assert!(error.contains("loop with 'b'") && error.contains("canGetAndSetFMUstate"), "{error}");
}
