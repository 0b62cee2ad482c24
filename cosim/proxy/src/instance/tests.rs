//! How many requests are sent to the other process, and which.

use std::os::unix::net::UnixStream;
use std::sync::mpsc::{Receiver, channel};

use cosim_import::proxy::frames::{read, write};

use super::*;

/// An instance with the outputs 7 and 8 and the input 1, and the requests it gets. Every Real that
/// is read is ten times its value reference, plus one for each step made.
fn remote() -> (Remote, Receiver<Vec<Ask>>) {
    let (ours, mut theirs) = UnixStream::pair().unwrap();
    let (sender, asked) = channel();
    std::thread::spawn(move || {
        let mut steps = 0.0;
        while let Ok(Request::Calls(asks)) = read(&mut theirs) {
            let give = |ask: &Ask| match ask {
                Ask::Get(Basic::Real, references) => Given::Values(Values::Real(
                    references.iter().map(|r| f64::from(10 * r) + steps).collect(),
                )),
                Ask::Step(..) => {
                    steps += 1.0;
                    Given::Done
                }
                Ask::Save => Given::State(vec![1]),
                _ => Given::Done,
            };
            let given = asks.iter().map(give).collect();
            let outcome = Outcome { given, trouble: None };
            sender.send(asks).unwrap();
            write(&mut theirs, &Reply::Done(outcome, Vec::new(), Vec::new())).unwrap();
        }
    });
    let manifest = r#"{"version": 1, "guid": "g", "fmu": "x.fmu", "sha256": "", "can_save": true,
        "derivative": false, "outputs": [7, 8], "inputs": [[1], [], [], []]}"#;
    let folder = std::env::temp_dir().join(format!("cosim-manifest-{:?}", ours));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("remote.json"), manifest).unwrap();
    let manifest = Manifest::read(&folder).unwrap();
    std::fs::remove_dir_all(folder).unwrap();
    let mut remote = Remote::over(Link::over(ours), manifest, "it");
    remote.enter(&Experiment::default()).unwrap();
    remote.exit().unwrap();
    assert_eq!(asked.try_iter().count(), 2);
    (remote, asked)
}

fn input(value: f64) -> Ask {
    Ask::Set(vec![1], Values::Real(vec![value]))
}

#[test]
fn set_step_and_get_are_one_message() {
    let (mut remote, asked) = remote();
    for step in 0..3 {
        remote.set(&[1], Values::Real(vec![0.5])).unwrap();
        remote.step(0.1 * f64::from(step), 0.1).unwrap();
        let mut values = [0.0; 2];
        remote.at_hand(&[8, 7], &mut values).unwrap();
        let made = f64::from(step + 1);
        assert_eq!(values, [80.0 + made, 70.0 + made]);
        let wanted = vec![
            input(0.5),
            Ask::Step(0.1 * f64::from(step), 0.1),
            Ask::Get(Basic::Real, vec![7, 8]),
        ];
        assert_eq!(asked.try_iter().collect::<Vec<_>>(), [wanted]);
    }
}

#[test]
fn what_is_read_once_after_a_step_comes_with_the_next_ones() {
    let (mut remote, asked) = remote();
    remote.step(0.0, 0.1).unwrap();
    assert_eq!(remote.get(Basic::Real, &[1, 7]).unwrap(), Values::Real(vec![11.0, 71.0]));
    assert_eq!(asked.try_iter().count(), 2);
    remote.step(0.1, 0.1).unwrap();
    assert_eq!(remote.get(Basic::Real, &[1, 7]).unwrap(), Values::Real(vec![12.0, 72.0]));
    assert_eq!(asked.try_iter().count(), 1);
}

#[test]
fn nothing_old_is_given_after_something_was_set() {
    let (mut remote, asked) = remote();
    remote.step(0.0, 0.1).unwrap();
    remote.set(&[1], Values::Real(vec![0.5])).unwrap();
    assert_eq!(remote.at_hand(&[7], &mut [0.0]), None);
    remote.get(Basic::Real, &[7]).unwrap();
    let asked: Vec<_> = asked.try_iter().skip(1).collect();
    assert_eq!(asked, [vec![input(0.5), Ask::Get(Basic::Real, vec![7])]]);
}

#[test]
fn a_parameter_is_set_at_once_and_a_state_takes_held_inputs_along() {
    let (mut remote, asked) = remote();
    remote.set(&[3], Values::Real(vec![2.0])).unwrap();
    assert_eq!(asked.try_iter().count(), 1);
    remote.set(&[1], Values::Real(vec![0.5])).unwrap();
    assert_eq!(asked.try_iter().count(), 0);
    let kept = remote.save().unwrap();
    assert_eq!(asked.try_iter().collect::<Vec<_>>(), [vec![input(0.5), Ask::Save]]);
    remote.restore(&kept).unwrap();
    assert_eq!(asked.try_iter().collect::<Vec<_>>(), [vec![Ask::Restore(vec![1])]]);
}

#[test]
fn a_program_that_is_gone_is_an_error() {
    let (ours, theirs) = UnixStream::pair().unwrap();
    let (remote, _asked) = remote();
    let mut other = Remote::over(Link::over(ours), remote.manifest.clone(), "it");
    drop(theirs);
    let error = other.step(0.0, 0.1).unwrap_err();
    assert_eq!(error.code(), Code::Lost);
}
