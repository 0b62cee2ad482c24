//! Which component runs on which worker.

use cosim_base::error::{Code, Error, Result};
use cosim_base::names::did_you_mean;
use cosim_core::system::System;

/// Takes requests `component=worker` and assigns the rest: strongly coupled components stay
/// together, and no worker gets more than its share. Returns the worker of each component by
/// position in `workers`.
pub(crate) fn place(
    system: &System,
    requests: &[(String, String)],
    workers: &[String],
) -> Result<Vec<usize>> {
    let mut places = requested(system, requests, workers)?;
    let mut clusters = clusters(system, &places);
    // The share of each worker, rounded up; requested placements count.
    let part = system.components().len().div_ceil(workers.len().max(1));
    while let Some((kept, merged)) = best_merge(system, &clusters, part, workers.len()) {
        let Cluster { members, worker } = clusters.remove(merged);
        clusters[kept].members.extend(members);
        clusters[kept].worker = clusters[kept].worker.or(worker);
    }
    // The largest first, each to the worker with the least load.
    clusters.sort_by_key(|cluster| (cluster.worker.is_none(), usize::MAX - cluster.members.len()));
    let mut load = vec![0; workers.len()];
    for cluster in clusters {
        let least = (0..workers.len()).min_by_key(|&worker| (load[worker], worker));
        if let Some(worker) = cluster.worker.or(least) {
            load[worker] += cluster.members.len();
            cluster.members.iter().for_each(|&member| places[member] = Some(worker));
        }
    }
    Ok(places.into_iter().map(Option::unwrap_or_default).collect())
}

struct Cluster {
    members: Vec<usize>,
    worker: Option<usize>,
}

fn requested(
    system: &System,
    requests: &[(String, String)],
    workers: &[String],
) -> Result<Vec<Option<usize>>> {
    let mut places = vec![None; system.components().len()];
    for (component, worker) in requests {
        let names = || system.components().iter().map(|c| c.name.as_str());
        let found = names().position(|name| name == component).ok_or_else(|| {
            Error::new(Code::Placement, format!("there is no component '{component}' to place"))
                .maybe_help(did_you_mean(component, names()))
        })?;
        let worker = workers.iter().position(|name| name == worker).ok_or_else(|| {
            let known = workers.iter().map(String::as_str);
            Error::new(Code::Placement, format!("there is no worker '{worker}' for '{component}'"))
                .maybe_help(did_you_mean(worker, known))
        })?;
        if places[found].is_some_and(|before| before != worker) {
            let what = format!("'{component}' is placed on two workers");
            return Err(Error::new(Code::Placement, what));
        }
        places[found] = Some(worker);
    }
    Ok(places)
}

/// Every component by itself, except that the members of a solved loop stay together.
fn clusters(system: &System, places: &[Option<usize>]) -> Vec<Cluster> {
    let mut clusters: Vec<Cluster> = Vec::new();
    for component in 0..places.len() {
        if clusters.iter().any(|cluster| cluster.members.contains(&component)) {
            continue;
        }
        let in_loop = system.solved_loops().find(|found| found.members.contains(&component));
        let members = in_loop.map_or(vec![component], |found| found.members.clone());
        let worker = members.iter().find_map(|&member| places[member]);
        clusters.push(Cluster { members, worker });
    }
    clusters
}

/// The two clusters with the most connections between them that may be merged.
fn best_merge(
    system: &System,
    clusters: &[Cluster],
    part: usize,
    workers: usize,
) -> Option<(usize, usize)> {
    if clusters.len() <= workers {
        return None;
    }
    let coupling = |a: &Cluster, b: &Cluster| {
        let joins = |from: usize, to: usize| {
            a.members.contains(&from) && b.members.contains(&to)
                || b.members.contains(&from) && a.members.contains(&to)
        };
        let connections = system.connections().iter();
        connections.filter(|c| joins(c.from.component, c.to.component)).count()
    };
    let mut best: Option<(usize, usize, usize)> = None;
    for a in 0..clusters.len() {
        for b in a + 1..clusters.len() {
            let (one, other) = (&clusters[a], &clusters[b]);
            let apart =
                one.worker.is_some() && other.worker.is_some() && one.worker != other.worker;
            if apart || one.members.len() + other.members.len() > part {
                continue;
            }
            let coupled = coupling(one, other);
            if coupled > best.map_or(0, |(most, _, _)| most) {
                best = Some((coupled, a, b));
            }
        }
    }
    best.map(|(_, a, b)| (a, b))
}
