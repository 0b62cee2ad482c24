//! No bytes make a host panic, and none that are damaged make it do something twice.

use super::systems::{Dice, Trial, apart, chain};
use crate::Algorithm;
use crate::distributed::host::{Handled, Host};
use crate::distributed::local::Files;
use crate::distributed::wire::{HEADER, Header, Kind};

fn mutated(message: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = message.to_vec();
    for _ in 0..=dice.below(3) {
        let at = dice.below(bytes.len().max(1) as u64) as usize;
        match dice.below(5) {
            0 => bytes.truncate(at),
            1 => bytes.insert(at.min(bytes.len()), dice.below(256) as u8),
            // The header decides most.
            2 if bytes.len() > HEADER => {
                bytes[dice.below(HEADER as u64) as usize] ^= 1 << dice.below(8)
            }
            _ if at < bytes.len() => bytes[at] ^= 1 << dice.below(8),
            _ => bytes.push(dice.below(256) as u8),
        }
    }
    bytes
}

#[test]
fn damaged_messages_are_refused_or_ignored() {
    let sample = chain(Algorithm::GaussSeidel);
    let outcome = apart(&sample.system, &[0, 0, 1, 0, 1], Trial::default()).unwrap();
    let mut dice = Dice(11);
    for round in 0..20 {
        let mut host = Host::new(1, Box::new(Files(outcome.files.clone())));
        for message in outcome.told.iter().take(10 + 2 * round) {
            for _ in 0..20 {
                // A value may be another after this, a count of commands may be too large: what
                // counts is that the host answers.
                host.handle(&mutated(message, &mut dice));
            }
            host.handle(message);
        }
        for length in 0..200 {
            let noise: Vec<u8> = (0..length).map(|_| dice.below(256) as u8).collect();
            assert!(matches!(host.handle(&noise), Handled::Ignored(_)), "{noise:?}");
        }
    }
}

#[test]
fn a_damaged_set_up_makes_nothing() {
    let sample = chain(Algorithm::GaussSeidel);
    let outcome = apart(&sample.system, &[0; 5], Trial::default()).unwrap();
    let setup = &outcome.told[0];
    let mut dice = Dice(5);
    for _ in 0..100 {
        let mut host = Host::new(1, Box::new(Files(outcome.files.clone())));
        let mut bytes = setup.clone();
        let at = HEADER + dice.below((bytes.len() - HEADER) as u64) as usize;
        bytes[at] ^= 1 << dice.below(8);
        let Handled::Answer(answer) = host.handle(&bytes) else { panic!("no answer") };
        assert_eq!(Header::read(&answer).unwrap().0.kind, Kind::Failed);
        assert!(String::from_utf8_lossy(&answer).contains("checksum"));
    }
}

#[test]
fn commands_out_of_turn_are_refused_with_both_numbers() {
    let sample = chain(Algorithm::GaussSeidel);
    let outcome = apart(&sample.system, &[0; 5], Trial::default()).unwrap();
    let mut host = Host::new(1, Box::new(Files(outcome.files.clone())));
    host.handle(&outcome.told[0]);
    let Handled::Answer(answer) = host.handle(&outcome.told[3]) else { panic!("no answer") };
    assert!(String::from_utf8_lossy(&answer).contains("command 3 came where 1 was due"));
    // The one that was due is still welcome, and welcome twice.
    let first = host.handle(&outcome.told[1]);
    assert_eq!(host.handle(&outcome.told[1]), first);
    let mut foreign = outcome.told[2].clone();
    foreign[4] = 9;
    assert!(matches!(host.handle(&foreign), Handled::Ignored(why) if why.contains("life 9")));
}
