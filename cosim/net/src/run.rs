//! Runs a system on workers.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use zenoh::{Session, Wait};

use super::access::session::Access;
use super::coordinator::Coordinator;
use super::distribute::Distribution;
use super::keys;
use super::local_workers::LocalWorkers;
use super::net::Net;
use super::options::Options;
use super::placement::place;
use super::pool::WorkerInfo;
use super::status::{Board, Watched};
use super::telemetry::{self, Fed};
use cosim_base::error::Result;
use cosim_core::master::{Run, Summary};
use cosim_core::system::{Column, System};
use cosim_import::Kind;
use cosim_import::temporary::Unpacked;

/// Where a distributed run is computed.
#[derive(Debug, Clone)]
pub struct Cluster {
    /// Where workers connect to us; `None`: a socket that only this user can reach.
    pub access: Option<Access>,
    /// How many workers to start on this machine for this run; they end with it.
    pub local: usize,
    /// The program to start for a local worker.
    pub program: Vec<String>,
    /// How many workers are required.
    pub needed: usize,
    /// How long to wait for them.
    pub patience: Duration,
    /// Placement requests `component=worker`.
    pub places: Vec<(String, String)>,
    /// What happens when something fails.
    pub options: Options,
}

impl Cluster {
    /// Runs `run` of `system` on the workers.
    pub fn go(&self, system: &System, run: Run<'_>) -> Result<Summary> {
        // Only ours; what a killed run leaves behind is removed by the next one.
        let folder = Unpacked::new()?;
        let access = self.access.clone().unwrap_or_else(|| Access {
            endpoints: vec![format!("unixsock-stream/{}/socket", folder.path().display())],
            ..Access::default()
        });
        let session = access.listen()?;
        let endpoint = access.endpoints.first().map_or("", String::as_str);
        let requests = self.requests(system);
        let mut named: Vec<String> = requests.iter().map(|(_, worker)| worker.clone()).collect();
        named.dedup();
        let local = local_names(self.local, system);
        let local = LocalWorkers::start(&self.program, &local, endpoint, folder.path())?;
        // The plan needs the names of the workers, and the fabric needs the FMUs of the plan.
        let id = session.zid().to_string();
        // Workers stop their work for this run when this token disappears.
        let _running = session.liveliness().declare_token(keys::running(&id)).wait();
        let _running = _running.map_err(super::net::refused)?;
        let waiting = Net::new(session.clone(), &id, Vec::new())?;
        let workers = waiting.gather(self.needed.max(self.local), &named, self.patience)?;
        let places = place(system, &requests, &workers)?;
        drop(waiting);

        // A worker without components is a spare.
        let mut used: Vec<usize> = places.clone();
        used.sort_unstable();
        used.dedup();
        let group = |worker: &usize| used.iter().position(|u| u == worker).unwrap_or_default();
        let places: Vec<usize> = places.iter().map(group).collect();
        let assigned = used.iter().map(|&worker| workers[worker].clone()).collect();
        let distribution = Distribution::new(system, &places)?;
        let mut net = Net::new(session.clone(), &id, distribution.files.clone())?;
        net.gather(workers.len(), &[], self.patience)?;
        let differences = differences(&net.infos());
        net.settle(assigned, self.patience);
        let Distribution { plan, layout, setups, .. } = distribution;
        let options = self.options.clone();
        let name = |&component: &usize| system.components()[component].name.clone();
        let groups = layout.groups.iter();
        let groups = groups.map(|group| group.own.iter().map(name).collect()).collect();
        let board = Board::new(&id, system.name(), system.stop_time().seconds(), groups);
        let board = Arc::new(board);
        let text = |column: &Column| column.kind == Kind::String;
        let columns = system.columns().iter();
        let names = columns.map(|column| (column.name.clone(), text(column))).unzip();
        let (feed, sender) =
            telemetry::open(&session, &id, board.clone(), names, self.options.telemetry)?;
        let fabric = Box::new(Watched::new(net, board));
        let mut driven = Coordinator::new(system, plan, layout, &setups, fabric, options)?;
        driven.warn(differences);
        let sent = apart(move || sender.serve());
        let outcome = run.drive_all(&mut Fed { driven: &mut driven, feed });
        // The feed is gone: the sender publishes the end.
        let _ = sent.recv_timeout(CLOSE_TIMEOUT);
        driven.end();
        drop(driven);
        drop(local);
        close(session);
        outcome
    }
}

impl Cluster {
    /// Placement requests: those given here, and for all other components those of the system's
    /// file.
    fn requests(&self, system: &System) -> Vec<(String, String)> {
        let asked = |name: &str| self.places.iter().any(|(component, _)| component == name);
        let filed = system.components().iter().filter(|component| !asked(&component.name));
        let filed = filed.filter_map(|c| Some((c.name.clone(), c.worker.clone()?)));
        self.places.iter().cloned().chain(filed).collect()
    }
}

/// Names for the local workers: first those that the system's file names.
fn local_names(count: usize, system: &System) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for name in system.components().iter().filter_map(|component| component.worker.as_ref()) {
        if !names.contains(name) && names.len() < count {
            names.push(name.clone());
        }
    }
    let others = (1..=count).map(|number| format!("worker-{number}"));
    let others: Vec<String> = others.filter(|name| !names.contains(name)).collect();
    names.extend(others.into_iter().take(count - names.len().min(count)));
    names
}

/// How long the last messages may take.
const CLOSE_TIMEOUT: Duration = Duration::from_millis(500);

/// Closes a session. Everything has been sent: a session that cannot be closed in order, because
/// the peer no longer listens, ends with the process.
pub(super) fn close(session: Session) {
    let closed = apart(move || drop(session.close().wait()));
    let _ = closed.recv_timeout(CLOSE_TIMEOUT);
}

/// Runs `what` in a thread of its own; the returned channel is closed at its end.
fn apart(what: impl FnOnce() + Send + 'static) -> Receiver<()> {
    let (end, inbox) = channel();
    std::thread::spawn(move || {
        what();
        drop(end);
    });
    inbox
}

/// Lists the workers that connect to `access` within `patience`.
pub fn workers(access: &Access, patience: Duration) -> Result<Vec<WorkerInfo>> {
    let session = access.listen()?;
    let net = Net::new(session.clone(), &session.zid().to_string(), Vec::new())?;
    std::thread::sleep(patience);
    let infos = net.infos();
    drop(net);
    close(session);
    Ok(infos)
}

/// Differences between workers that may change the last bit of results, and missing confinement.
fn differences(infos: &[WorkerInfo]) -> Vec<String> {
    let Some((first, others)) = infos.split_first() else {
        return Vec::new();
    };
    let unlike = others.iter().filter(|other| other.computes() != first.computes());
    let warnings = unlike.map(|other| {
        let (name, one) = (&first.name, &other.name);
        let (computes, differs) = (first.computes(), other.computes());
        format!(
            "the workers {name} ({computes}) and {one} ({differs}) differ: FMUs that call \
             functions of the C library may differ in the last bit"
        )
    });
    let loose: Vec<&str> = infos.iter().filter(|i| i.is_loose()).map(|i| i.name.as_str()).collect();
    let loose = (!loose.is_empty()).then(|| {
        format!(
            "the FMUs of {} are not confined: the kernel there has no Landlock",
            loose.join(", ")
        )
    });
    warnings.chain(loose).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_processor_or_library_is_reported_and_another_machine_is_not() {
        let like = WorkerInfo::of_this("left", true);
        let other = WorkerInfo { name: "right".to_owned(), host: "far".to_owned(), ..like.clone() };
        assert_eq!(differences(&[like.clone(), other.clone()]).len(), usize::from(like.is_loose()));
        let library = "glibc 2.17, libm 0123456789ab".to_owned();
        for unlike in [
            WorkerInfo { library, ..other.clone() },
            WorkerInfo { cpu: vec!["sse2".to_owned()], ..other.clone() },
        ] {
            let warnings = differences(&[like.clone(), unlike.clone()]);
            let parts = ["workers left (", "right (", &unlike.library, &unlike.cpu.join(" ")];
            assert!(parts.iter().all(|part| warnings[0].contains(part)), "{warnings:?}");
        }
    }
}
