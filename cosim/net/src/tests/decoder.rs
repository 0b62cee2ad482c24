//! No bytes make a host panic, and no damaged bytes make it do something twice.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use sha2::{Digest, Sha256};

use super::systems::{Dice, Outcome, Sample, Trial, apart, chain, driven, solved};
use crate::host::{Handled, Host};
use crate::local::{Fault, Files};
use crate::options::Options;
use crate::setup::{FmuFile, FmuSource, Setup, Source};
use crate::wire::{HEADER, Header, Kind};
use cosim_base::error::{Code, Error, Result};
use cosim_core::Algorithm;
use cosim_import::Fmu;

fn mutated(message: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = message.to_vec();
    for _ in 0..=dice.below(3) {
        let at = dice.below(bytes.len().max(1) as u64) as usize;
        match dice.below(5) {
            0 => bytes.truncate(at),
            1 => bytes.insert(at.min(bytes.len()), dice.below(256) as u8),
            // The header has the greatest effect.
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
        for message in outcome.sent_to_first.iter().take(10 + 2 * round) {
            for _ in 0..20 {
                // A value may differ after this, a count of commands may be too large: what matters
                // is that the host answers.
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
    let setup = &outcome.sent_to_first[0];
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
    host.handle(&outcome.sent_to_first[0]);
    let Handled::Answer(answer) = host.handle(&outcome.sent_to_first[3]) else {
        panic!("no answer")
    };
    assert!(String::from_utf8_lossy(&answer).contains("command 3 came where 1 was due"));
    // The command that was due is still accepted, even twice.
    let first = host.handle(&outcome.sent_to_first[1]);
    assert_eq!(host.handle(&outcome.sent_to_first[1]), first);
    let mut foreign = outcome.sent_to_first[2].clone();
    foreign[4] = 9;
    assert!(
        matches!(host.handle(&foreign), Handled::Ignored(why) if why.contains("incarnation 9"))
    );
}

/// Octets of the checksum between header and body of a set-up.
const SUM: usize = 32;

fn is_setup(message: &[u8]) -> bool {
    Header::read(message).is_ok_and(|(header, _)| header.kind == Kind::Setup)
}

/// A set-up with a changed body and a matching checksum.
fn resigned(setup: &[u8], body: &[u8]) -> Vec<u8> {
    [&setup[..HEADER], &Sha256::digest(body), body].concat()
}

/// Runs in which group 0 gets set-ups with and without a state, and the messages it was sent.
fn runs() -> Vec<Outcome> {
    let run = |sample: Sample, places: &[usize]| {
        let options = Options { save_every: Some(2), ..Options::default() };
        let faults = vec![(40, Fault::DiesAfter), (41, Fault::DiesAfter)];
        apart(&sample.system, places, Trial { faults, options, ..Trial::default() }).unwrap()
    };
    vec![
        run(chain(Algorithm::GaussSeidel), &[0, 0, 1, 0, 0]),
        run(solved(), &[0, 0, 0, 0]),
        run(driven(), &[0, 0]),
    ]
}

#[test]
fn set_ups_that_contradict_themselves_are_refused_by_name() {
    let (mut dice, mut decoded, mut refused, mut made) = (Dice(23), 0, 0, 0);
    for outcome in runs() {
        let open = Open::all(&outcome.files);
        let set_ups =
            outcome.sent_to_first.iter().enumerate().filter(|(_, message)| is_setup(message));
        for (at, setup) in set_ups {
            let (header, _) = Header::read(setup).unwrap();
            let body = &setup[HEADER + SUM..];
            for _ in 0..500 {
                let mut changed = body.to_vec();
                for _ in 0..=dice.below(2) {
                    let place = dice.below(changed.len() as u64) as usize;
                    changed[place] = match dice.below(3) {
                        0 => changed[place] ^ 1 << dice.below(8),
                        1 => changed[place].wrapping_add(1),
                        _ => [0, 1, 0x7F, 0xFF][dice.below(4) as usize],
                    };
                }
                decoded += usize::from(postcard::from_bytes::<Setup>(&changed).is_ok());
                let mut host = Host::new(header.generation, Box::new(open.clone()));
                let Handled::Answer(answer) = host.handle(&resigned(setup, &changed)) else {
                    panic!("no answer");
                };
                match Header::read(&answer).unwrap().0.kind {
                    Kind::Done => made += 1,
                    _ => refused += usize::from(contradicts(&answer)),
                }
                // A set-up that was accepted computes something, or fails with a clear error.
                for message in
                    outcome.sent_to_first[at + 1..].iter().take_while(|m| !is_setup(m)).take(30)
                {
                    host.handle(message);
                }
            }
        }
    }
    assert!(decoded > 1000 && refused > 100 && made > 100, "{decoded} {refused} {made}");
}

/// FMUs that are unpacked once for all hosts.
#[derive(Clone)]
struct Open(BTreeMap<String, Arc<Fmu>>);

impl Open {
    fn all(files: &BTreeMap<String, PathBuf>) -> Self {
        Self(files.iter().map(|(hash, path)| (hash.clone(), Fmu::open(path).unwrap())).collect())
    }
}

impl FmuSource for Open {
    fn open(&mut self, file: &FmuFile) -> Result<Arc<Fmu>> {
        let known = self.0.get(&file.sha256).cloned();
        known.ok_or_else(|| Error::new(Code::File, format!("no {} here", file.name)))
    }
}

fn contradicts(answer: &[u8]) -> bool {
    String::from_utf8_lossy(answer).contains("contradicts itself")
}

#[test]
fn a_file_of_a_set_up_stays_in_its_folder() {
    let outcome = apart(&chain(Algorithm::GaussSeidel).system, &[0; 5], Trial::default()).unwrap();
    let body = &outcome.sent_to_first[0][HEADER + SUM..];
    for (name, hash) in [
        ("../m.fmu", None),
        ("/m.fmu", None),
        ("..", None),
        ("", None),
        ("m.fmu/", None),
        ("m.fmu", Some("../../m")),
        ("m.fmu", Some("")),
    ] {
        let mut setup: Setup = postcard::from_bytes(body).unwrap();
        let Source::Fmu(file) = &mut setup.components[0].source else { panic!("no FMU") };
        file.name = name.to_owned();
        file.sha256 = hash.map_or(file.sha256.clone(), str::to_owned);
        let message = resigned(&outcome.sent_to_first[0], &postcard::to_stdvec(&setup).unwrap());
        let mut host = Host::new(1, Box::new(Files(outcome.files.clone())));
        let Handled::Answer(answer) = host.handle(&message) else { panic!("no answer") };
        assert!(contradicts(&answer), "{name} {hash:?}");
    }
}

#[test]
fn a_change_of_a_variable_that_is_not_there_is_refused() {
    let sample = chain(Algorithm::GaussSeidel);
    let outcome = apart(&sample.system, &[0; 5], Trial::default()).unwrap();
    let mut host = Host::new(1, Box::new(Files(outcome.files.clone())));
    host.handle(&outcome.sent_to_first[0]);
    let mut message = outcome.sent_to_first[1].clone();
    message[2] = Kind::Change as u8;
    // A `Change`: variable, type, free (the third way), released (the second act), start value.
    let change = (8_usize, cosim_import::Basic::Real, 2_u32, 1_u32, 0.0_f64);
    message.extend(postcard::to_stdvec(&(0_usize, change)).unwrap());
    let Handled::Answer(answer) = host.handle(&message) else { panic!("no answer") };
    assert!(String::from_utf8_lossy(&answer).contains("no variable 8 of 8"));
}
