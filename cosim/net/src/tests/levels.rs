//! Which group waits for which.

use super::systems::{Sample, chain, solved};
use crate::layout::Layout;
use cosim_core::Algorithm;
use cosim_core::master::Plan;

/// The level of each component.
fn levels(sample: &Sample, places: &[usize]) -> Vec<usize> {
    let layout = Layout::new(&Plan::new(&sample.system), places).unwrap();
    let mut levels = vec![usize::MAX; places.len()];
    for group in &layout.groups {
        for (level, part) in group.parts.iter().enumerate() {
            part.members.iter().for_each(|&member| levels[member] = level);
        }
    }
    levels
}

#[test]
fn a_level_for_each_way_of_a_fresh_value_between_groups() {
    let sample = chain(Algorithm::GaussSeidel);
    // a -> b -> c -> d by feed-through; e has none.
    assert_eq!(levels(&sample, &[0, 1, 2, 3, 4]), [0, 1, 2, 3, 0]);
    assert_eq!(levels(&sample, &[0, 0, 1, 1, 0]), [0, 0, 1, 1, 0]);
    assert_eq!(levels(&sample, &[0, 1, 0, 1, 1]), [0, 1, 2, 3, 0]);
    assert_eq!(levels(&sample, &[0, 0, 0, 0, 0]), [0; 5]);
}

#[test]
fn jacobi_has_one_level() {
    assert_eq!(levels(&chain(Algorithm::Jacobi), &[0, 1, 2, 3, 4]), [0; 5]);
}

#[test]
fn the_members_of_a_loop_have_one_level_and_one_place() {
    let sample = solved();
    assert_eq!(levels(&sample, &[0, 1, 1, 2]), [0, 0, 0, 1]);
    assert_eq!(Layout::new(&Plan::new(&sample.system), &[0, 1, 2, 0]), Err(0));
}

#[test]
fn only_values_of_others_are_sent() {
    let sample = chain(Algorithm::GaussSeidel);
    let layout = Layout::new(&Plan::new(&sample.system), &[0, 0, 1, 1, 0]).unwrap();
    // c reads b.y fresh; a reads d.y and e reads c.y held; d's a.y is held.
    let [first, second] = &layout.groups[..] else { panic!("two groups") };
    assert_eq!((first.held.len(), second.held.len()), (2, 1));
    assert_eq!(first.parts.iter().map(|part| part.reads.len()).sum::<usize>(), 0);
    assert_eq!(second.parts[1].reads.len(), 1);
}
