//! Every placement gives the bits of an ordinary run, also across a snapshot.

use super::systems::{Sample, Trial, apart, chain, driven, here, placements, solved};
use cosim_core::{Algorithm, Code, Run, Snapshot, Time};

/// Compares all placements; returns how many there are, and how many are refused.
fn compare(sample: &Sample) -> (usize, usize) {
    let (bits, summary) = here(&sample.system);
    let all = placements(sample.system.components().len());
    let mut refused = 0;
    for places in &all {
        match apart(&sample.system, places, Trial::default()) {
            Ok(outcome) => {
                assert!(outcome.bits == bits, "{places:?}");
                assert_eq!(outcome.summary.steps, summary.steps, "{places:?}");
                assert_eq!(outcome.summary.notes, summary.notes, "{places:?}");
            }
            Err(error) => {
                assert_eq!(error.code(), Code::Placement, "{error}");
                refused += 1;
            }
        }
    }
    (all.len(), refused)
}

#[test]
fn every_placement_of_a_chain_with_several_rates() {
    for algorithm in [Algorithm::GaussSeidel, Algorithm::Jacobi] {
        assert_eq!(compare(&chain(algorithm)), (52, 0));
    }
}

#[test]
fn every_placement_of_a_solved_loop_that_keeps_it_together() {
    // b and c are apart in 10 of the 15 ways to place four components.
    assert_eq!(compare(&solved()), (15, 10));
}

#[test]
fn recorded_inputs_may_be_elsewhere() {
    assert_eq!(compare(&driven()), (2, 0));
}

#[test]
fn a_run_goes_on_here_or_there() {
    let sample = chain(Algorithm::GaussSeidel);
    let system = &sample.system;
    let (bits, at) = (here(system).0, Time::from_seconds(0.7));
    // Columns end with the same values when a run is resumed.
    let tail = |all: &[Vec<u64>], count: usize| -> Vec<Vec<u64>> {
        all.iter().map(|column| column[column.len() - count..].to_vec()).collect()
    };
    let rows = bits[0].len() * 13 / 20;
    for places in [[0, 1, 2, 3, 4], [0, 0, 1, 1, 0]] {
        let trial = Trial { keep: Some(at), ..Trial::default() };
        let there = apart(system, &places, trial).unwrap().kept.unwrap();
        let mut local: Option<Snapshot> = None;
        let mut keep = |snapshot| {
            local = Some(snapshot);
            Ok(())
        };
        Run::new(system).snapshots(None, &[at], &mut keep).go().unwrap();
        let mut recording = cosim_core::Recording::new();
        Run::new(system).observe(&mut recording).resume(&there).go().unwrap();
        let found: Vec<u64> =
            recording.columns().next().unwrap().1.iter().map(|v| v.to_bits()).collect();
        assert_eq!(found, tail(&bits, rows)[0], "from there to here");
        let trial = Trial { resume: local.as_ref(), ..Trial::default() };
        let again = apart(system, &places, trial).unwrap();
        assert_eq!(again.bits, tail(&bits, rows), "from here to there");
    }
}
