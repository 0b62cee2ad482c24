//! The stepping order, and which connections carry values without delay.
//!
//! The graph has the components as nodes. In the Gauss-Seidel algorithm, a connection to an input
//! with direct feed-through should be *fresh*: its source must step first. The order is a
//! topological one along these edges; among components that may come next, the one listed first in
//! the file does. In a loop of such edges (an algebraic loop), the members step in the order of the
//! file, the edges back from later to earlier members are *held*, and the loop is reported.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use super::{Algorithm, Component, Connection, Model};

/// The result.
#[derive(Debug, Clone, Default)]
pub struct Order {
    /// Positions of the components, first to last.
    pub sequence: Vec<usize>,
    /// For each connection: whether its input gets values at the end of the step.
    pub fresh: Vec<bool>,
    /// Algebraic loops that were broken.
    pub loops: Vec<Loop>,
}

/// An algebraic loop and where it was cut.
#[derive(Debug, Clone)]
pub struct Loop {
    /// Positions of the components in it, in stepping order.
    pub members: Vec<usize>,
    /// Positions of the connections that are held.
    pub held: Vec<usize>,
    /// It is solved by iteration at each step; the connections are not held in that case.
    pub solved: bool,
}

impl Order {
    /// Orders the components of a system.
    pub fn new(algorithm: Algorithm, components: &[Component], connections: &[Connection]) -> Self {
        let wants: Vec<bool> = connections
            .iter()
            .map(|c| components[c.to.component].model.feeds_through(c.to.variable))
            .collect();
        let edges: Vec<(usize, usize)> =
            connections.iter().map(|c| (c.from.component, c.to.component)).collect();
        let mut order = of_graph(components.len(), &edges, &wants);
        if algorithm == Algorithm::Jacobi {
            // A function takes no time in any algorithm: it follows its inputs.
            let function = |c: usize| matches!(components[c].model, Model::Function(_));
            order.sequence.sort_by_key(|&c| function(c));
            order.fresh = edges.iter().map(|&(_, to)| function(to)).collect();
            order.loops.clear();
        }
        order
    }
}

/// Orders `nodes` nodes; `wants[i]` says whether `edges[i]` should be fresh.
fn of_graph(nodes: usize, edges: &[(usize, usize)], wants: &[bool]) -> Order {
    let mut next = vec![Vec::new(); nodes];
    for (&(from, to), _) in edges.iter().zip(wants).filter(|(_, wants)| **wants) {
        next[from].push(to);
    }
    let group = groups(&next);
    let mut members = vec![Vec::new(); nodes];
    let mut missing = vec![0_usize; nodes];
    for node in 0..nodes {
        members[group[node]].push(node);
        for &to in next[node].iter().filter(|&&to| group[to] != group[node]) {
            missing[group[to]] += 1;
        }
    }
    // A group (a loop, or one node) is ready when everything that leads to it is placed.
    let is_ready = |&node: &usize| group[node] == node && missing[node] == 0;
    let mut ready: BinaryHeap<_> = (0..nodes).filter(is_ready).map(Reverse).collect();
    let mut place = vec![usize::MAX; nodes];
    let mut sequence: Vec<usize> = Vec::with_capacity(nodes);
    while let Some(Reverse(first)) = ready.pop() {
        for &member in &members[first] {
            place[member] = sequence.len();
            sequence.push(member);
        }
        let targets = members[first].iter().flat_map(|&member| &next[member]);
        for to in targets.map(|&to| group[to]).filter(|&to| to != first) {
            missing[to] -= 1;
            if missing[to] == 0 {
                ready.push(Reverse(to));
            }
        }
    }
    let fresh: Vec<bool> = edges
        .iter()
        .zip(wants)
        .map(|(&(from, to), &wants)| wants && place[from] < place[to])
        .collect();
    let mut loops: Vec<Loop> = Vec::new();
    let mut of_group = HashMap::new();
    for (edge, &(_, to)) in edges.iter().enumerate() {
        if !wants[edge] || fresh[edge] {
            continue;
        }
        let found = *of_group.entry(group[to]).or_insert(loops.len());
        if found == loops.len() {
            let members = std::mem::take(&mut members[group[to]]);
            loops.push(Loop { members, held: Vec::new(), solved: false });
        }
        loops[found].held.push(edge);
    }
    Order { sequence, fresh, loops }
}

/// For each node, the first of those that it reaches and that reach it (Tarjan 1972, without
/// recursion).
fn groups(next: &[Vec<usize>]) -> Vec<usize> {
    const NONE: usize = usize::MAX;
    let (mut found, mut lowest) = (vec![NONE; next.len()], vec![NONE; next.len()]);
    let mut group = vec![NONE; next.len()];
    let (mut count, mut ungrouped) = (0, Vec::new());
    for root in 0..next.len() {
        let mut open = Vec::new();
        let mut entered = (found[root] == NONE).then_some(root);
        loop {
            if let Some(node) = entered.take() {
                (found[node], lowest[node]) = (count, count);
                count += 1;
                ungrouped.push(node);
                open.push((node, next[node].iter()));
            }
            let Some((node, rest)) = open.last_mut() else { break };
            let node = *node;
            if let Some(&to) = rest.next() {
                if found[to] == NONE {
                    entered = Some(to);
                } else if group[to] == NONE {
                    lowest[node] = lowest[node].min(found[to]);
                }
                continue;
            }
            open.pop();
            if let Some(&(before, _)) = open.last() {
                lowest[before] = lowest[before].min(lowest[node]);
            }
            if lowest[node] == found[node] {
                let begin = ungrouped.iter().rposition(|&other| other == node).unwrap_or(0);
                let members = ungrouped.split_off(begin);
                let first = members.iter().copied().min().unwrap_or(node);
                members.into_iter().for_each(|member| group[member] = first);
            }
        }
    }
    group
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_listed_backwards_is_turned_around() {
        let order = of_graph(3, &[(2, 1), (1, 0)], &[true, true]);
        assert_eq!(order.sequence, [2, 1, 0]);
        assert_eq!(order.fresh, [true, true]);
        assert!(order.loops.is_empty());
    }

    #[test]
    fn without_feed_through_the_file_decides() {
        let order = of_graph(3, &[(2, 1), (1, 0)], &[false, false]);
        assert_eq!(order.sequence, [0, 1, 2]);
        assert_eq!(order.fresh, [false, false]);
    }

    #[test]
    fn a_loop_goes_by_the_file_and_is_reported() {
        // 0 -> 2 -> 1 -> 0 is a loop, 3 feeds it, 4 is fed.
        let edges = [(0, 2), (2, 1), (1, 0), (3, 0), (1, 4)];
        let order = of_graph(5, &edges, &[true; 5]);
        assert_eq!(order.sequence, [3, 0, 1, 2, 4]);
        assert_eq!(order.fresh, [true, false, false, true, true]);
        assert_eq!(order.loops.len(), 1);
        assert_eq!(order.loops[0].members, [0, 1, 2]);
        assert_eq!(order.loops[0].held, [1, 2]);
    }

    #[test]
    fn a_component_that_feeds_itself_is_a_loop() {
        let order = of_graph(1, &[(0, 0)], &[true]);
        assert_eq!(order.fresh, [false]);
        assert_eq!(order.loops[0].members, [0]);
    }

    #[test]
    fn loops_that_share_a_member_are_one_and_the_first_of_a_file_goes_first() {
        // 1 <-> 3 and 3 <-> 4 are one loop, 0 <-> 2 another, which 4 feeds.
        let edges = [(1, 3), (3, 1), (3, 4), (4, 3), (0, 2), (2, 0), (4, 2)];
        let order = of_graph(6, &edges, &[true; 7]);
        assert_eq!(order.sequence, [1, 3, 4, 0, 2, 5]);
        assert_eq!(order.loops.len(), 2);
        assert_eq!(order.loops[0].members, [1, 3, 4]);
        assert_eq!(order.loops[0].held, [1, 3]);
        assert_eq!(order.loops[1].members, [0, 2]);
        assert_eq!(order.loops[1].held, [5]);
    }

    #[test]
    fn a_chain_of_many_components_needs_neither_a_matrix_nor_a_deep_stack() {
        let count = 300_000;
        let edges: Vec<_> = (1..count).map(|n| (n, n - 1)).chain([(0, count - 1)]).collect();
        let order = of_graph(count, &edges, &vec![true; count]);
        assert_eq!(order.loops[0].members.len(), count);
        let order = of_graph(count, &edges[1..], &vec![true; count - 1]);
        assert_eq!(order.sequence[1..4], [count - 1, count - 2, count - 3]);
    }
}
