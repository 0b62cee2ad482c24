//! Which component runs on which worker.

use super::fmu::Nature;
use super::systems::{Sample, sample, solved};
use crate::placement::place;
use cosim_core::{Algorithm, Code};

/// Two pairs, each coupled twice, joined by one connection.
fn pairs() -> Sample {
    let of = |name| (name, Nature::State, 0.1);
    sample(
        &[of("a"), of("c"), of("b"), of("d")],
        &["a.y b.u", "b.y a.u", "c.y d.u", "d.y c.u", "a.y c.v"],
        Algorithm::GaussSeidel,
    )
}

fn workers(count: usize) -> Vec<String> {
    (0..count).map(|number| format!("w{number}")).collect()
}

fn request(component: &str, worker: &str) -> (String, String) {
    (component.to_owned(), worker.to_owned())
}

#[test]
fn those_coupled_most_stay_together() {
    let system = pairs().system;
    // In the order a, c, b, d.
    let places = place(&system, &[], &workers(2)).unwrap();
    assert_eq!((places[0], places[1]), (places[2], places[3]));
    assert_ne!(places[0], places[1]);
    assert_eq!(place(&system, &[], &workers(1)).unwrap(), [0; 4]);
    let mut each = place(&system, &[], &workers(4)).unwrap();
    each.sort_unstable();
    assert_eq!(each, [0, 1, 2, 3]);
}

#[test]
fn a_request_takes_along_what_is_coupled_to_it() {
    let system = pairs().system;
    assert_eq!(place(&system, &[request("d", "w0")], &workers(2)).unwrap(), [1, 0, 1, 0]);
    assert_eq!(place(&system, &[request("d", "w1")], &workers(2)).unwrap(), [0, 1, 0, 1]);
    // Two requests separate a pair.
    let places = place(&system, &[request("a", "w0"), request("b", "w1")], &workers(2)).unwrap();
    assert_eq!((places[0], places[2]), (0, 1));
}

#[test]
fn a_solved_loop_is_in_one_place() {
    let system = solved().system;
    for count in 1..4 {
        let places = place(&system, &[], &workers(count)).unwrap();
        assert_eq!(places[1], places[2], "{places:?}");
    }
}

#[test]
fn an_impossible_request_is_refused_with_the_nearest_name() {
    let system = pairs().system;
    for (requests, part) in [
        (vec![request("aa", "w0")], "no component 'aa'"),
        (vec![request("a", "w7")], "no worker 'w7'"),
        (vec![request("a", "w0"), request("a", "w1")], "on two workers"),
    ] {
        let error = place(&system, &requests, &workers(2)).unwrap_err();
        assert_eq!(error.code(), Code::Placement);
        assert!(error.what().contains(part), "{error}");
    }
}
