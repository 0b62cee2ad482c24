//! The stepping order, and which connections carry values without delay.
//!
//! The graph has the components as nodes. In the Gauss-Seidel algorithm, a connection to an input
//! with direct feed-through should be *fresh*: its source must step first. The order is a
//! topological one along these edges; among components that may come next, the one listed first in
//! the file does. In a loop of such edges (an algebraic loop), the members step in the order of the
//! file, the edges back from later to earlier members are *held*, and the loop is reported.

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
    let reach = reachability(nodes, edges, wants);
    let same_loop = |a: usize, b: usize| a == b || (reach[a][b] && reach[b][a]);
    let mut place = vec![usize::MAX; nodes];
    let mut sequence: Vec<usize> = Vec::with_capacity(nodes);
    while sequence.len() < nodes {
        // A group (a loop, or one node) is ready when everything that reaches it is placed.
        let ready = |&node: &usize| {
            place[node] == usize::MAX
                && (0..nodes).all(|other| {
                    !reach[other][node] || same_loop(other, node) || place[other] != usize::MAX
                })
        };
        // The groups form a graph without loops, so there is a ready one.
        let Some(first) = (0..nodes).find(ready) else {
            break;
        };
        for member in (first..nodes).filter(|&n| same_loop(first, n)) {
            place[member] = sequence.len();
            sequence.push(member);
        }
    }
    let fresh: Vec<bool> = edges
        .iter()
        .zip(wants)
        .map(|(&(from, to), &wants)| wants && place[from] < place[to])
        .collect();
    let mut loops: Vec<Loop> = Vec::new();
    for (edge, &(from, to)) in edges.iter().enumerate() {
        if !wants[edge] || fresh[edge] {
            continue;
        }
        match loops.iter_mut().find(|l| l.members.contains(&to)) {
            Some(found) => found.held.push(edge),
            None => loops.push(Loop {
                members: sequence.iter().copied().filter(|&n| same_loop(from, n)).collect(),
                held: vec![edge],
                solved: false,
            }),
        }
    }
    Order { sequence, fresh, loops }
}

/// `reach[a][b]`: a path of wanted edges leads from a to b (Warshall).
fn reachability(nodes: usize, edges: &[(usize, usize)], wants: &[bool]) -> Vec<Vec<bool>> {
    let mut reach = vec![vec![false; nodes]; nodes];
    for (&(from, to), _) in edges.iter().zip(wants).filter(|(_, wants)| **wants) {
        reach[from][to] = true;
    }
    for via in 0..nodes {
        let row = reach[via].clone();
        for from in reach.iter_mut().filter(|from| from[via]) {
            for (target, &also) in from.iter_mut().zip(&row) {
                *target |= also;
            }
        }
    }
    reach
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
}
