//! Whatever happens to hosts and messages, the results do not change by a bit.

use super::fmu::Nature;
use super::systems::{Dice, Sample, Trial, apart, chain, here, sample};
use crate::local::Fault;
use crate::options::Options;
use cosim_core::{Algorithm, Code};

/// Faults that must not change a run.
const FAULTS: [Fault; 11] = [
    Fault::DiesBefore,
    Fault::DiesAfter,
    Fault::AnswersTwice,
    Fault::HearsTwice,
    Fault::Ghost,
    Fault::Echo,
    Fault::Late,
    Fault::Early,
    Fault::Foreign,
    Fault::Torn,
    Fault::Misread,
];

fn every(save_every: Option<u64>) -> Options {
    Options { save_every, ..Options::default() }
}

fn pair(nature: Nature) -> Sample {
    sample(
        &[("a", nature, 0.1), ("b", Nature::Through, 0.1)],
        &["a.y b.u", "b.y a.v"],
        Algorithm::GaussSeidel,
    )
}

#[test]
fn random_faults_change_nothing() {
    let sample = chain(Algorithm::GaussSeidel);
    let (bits, summary) = here(&sample.system);
    let mut dice = Dice(7);
    let mut incarnations = 0;
    for round in 0..120 {
        let mut fault = || (1 + dice.below(300), FAULTS[dice.below(FAULTS.len() as u64) as usize]);
        let faults: Vec<_> = (0..16).map(|_| fault()).collect();
        let save_every = [None, Some(1), Some(3), Some(50)][round % 4];
        let places = [[0, 1, 2, 3, 4], [0, 1, 0, 1, 2], [0, 0, 1, 1, 1]][round % 3];
        let trial =
            Trial { faults: faults.clone(), options: every(save_every), ..Trial::default() };
        let outcome = apart(&sample.system, &places, trial).unwrap();
        assert!(outcome.bits == bits, "{faults:?} {places:?} {save_every:?}");
        assert_eq!(outcome.summary.steps, summary.steps, "{faults:?} {places:?} {save_every:?}");
        incarnations +=
            outcome.summary.notes.iter().filter(|note| note.contains("went on")).count();
    }
    assert!(incarnations > 100, "only {incarnations} incarnations were lost");
}

#[test]
fn what_cannot_be_saved_is_computed_again_from_the_start_unless_that_is_refused() {
    let sample = pair(Nature::Mute);
    let bits = here(&sample.system).0;
    for at in [1, 2, 9, 40] {
        let faults = vec![(at, Fault::DiesAfter)];
        let trial = Trial { faults: faults.clone(), ..Trial::default() };
        assert!(apart(&sample.system, &[0, 1], trial).unwrap().bits == bits, "{at}");
        let options = Options { require_resume: true, ..every(Some(1)) };
        let trial = Trial { faults, options, ..Trial::default() };
        match apart(&sample.system, &[0, 1], trial) {
            // Every other command is for b, whose state was saved.
            Ok(outcome) => assert!(outcome.bits == bits, "{at}"),
            Err(error) => {
                assert_eq!(error.code(), Code::Lost, "{error}");
                assert!(error.remedy().unwrap().contains("--require-resume"), "{error}");
            }
        }
    }
    let options = Options { require_resume: true, ..Options::default() };
    let trial = Trial { faults: vec![(3, Fault::DiesBefore)], options, ..Trial::default() };
    assert_eq!(apart(&sample.system, &[0, 0], trial).err().unwrap().code(), Code::Lost);
}

#[test]
fn what_is_not_deterministic_is_found() {
    let sample = pair(Nature::Chaos);
    let trial =
        Trial { faults: vec![(20, Fault::DiesAfter)], options: every(None), ..Trial::default() };
    let error = apart(&sample.system, &[0, 0], trial).err().unwrap();
    assert_eq!(error.code(), Code::Differs, "{error}");
    assert!(error.what().contains("a, b") && error.what().contains("t = "), "{error}");
}

#[test]
fn restarts_are_counted() {
    let sample = pair(Nature::State);
    let options = Options { recoveries: 2, ..Options::default() };
    let faults = |count| (0..count).map(|k| (10 + 4 * k, Fault::DiesBefore)).collect();
    let trial = Trial { faults: faults(2), options: options.clone(), ..Trial::default() };
    assert!(apart(&sample.system, &[0, 0], trial).is_ok());
    let trial = Trial { faults: faults(4), options, ..Trial::default() };
    let error = apart(&sample.system, &[0, 0], trial).err().unwrap();
    assert!(error.remedy().unwrap().contains("--recoveries"), "{error}");
}

#[test]
fn each_kind_of_stray_message_at_each_place_is_ignored() {
    let sample = pair(Nature::State);
    let (bits, summary) = here(&sample.system);
    for fault in &FAULTS[2..] {
        for at in 1..60 {
            // One after another, so that stray messages also meet each other.
            let faults = (at..at + 3).map(|at| (at, *fault)).collect();
            let trial = Trial { faults, options: every(Some(3)), ..Trial::default() };
            let outcome = apart(&sample.system, &[0, 1], trial).unwrap();
            assert!(outcome.bits == bits, "{fault:?} at {at}");
            assert_eq!(outcome.summary.steps, summary.steps, "{fault:?} at {at}");
            assert_eq!(outcome.summary.notes, summary.notes, "{fault:?} at {at}");
        }
    }
}

#[test]
fn a_host_that_misunderstands_or_is_misunderstood_starts_over() {
    let sample = pair(Nature::State);
    let bits = here(&sample.system).0;
    let mut lost = 0;
    for fault in [Fault::CutAnswer, Fault::CutCommand] {
        for at in 1..60 {
            let trial = Trial { faults: vec![(at, fault)], ..Trial::default() };
            let outcome = apart(&sample.system, &[0, 1], trial).unwrap();
            assert!(outcome.bits == bits, "{fault:?} at {at}");
            let said = |note: &&String| note.contains("cannot be understood");
            lost += outcome.summary.notes.iter().filter(said).count();
        }
    }
    assert!(lost > 60, "{lost}");
    // A host that never understands ends the run, which says why.
    let faults = (20..200).map(|at| (at, Fault::CutCommand)).collect();
    let error = apart(&sample.system, &[0, 1], Trial { faults, ..Trial::default() }).err().unwrap();
    assert_eq!(error.code(), Code::Lost, "{error}");
    assert!(error.what().contains("cannot be understood"), "{error}");
}
