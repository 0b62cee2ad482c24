//! Running a system on workers.

use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::channel;
use std::time::Duration;

use zenoh::{Session, Wait};

use super::coordinator::Coordinator;
use super::distribute::Distribution;
use super::net::Net;
use super::options::Options;
use super::placement::place;
use super::pool::WorkerInfo;
use super::session::Access;
use super::status::{Board, Watched};
use super::telemetry::{self, Fed};
use crate::error::{Code, Error, Result};
use crate::master::{Run, Summary};
use crate::system::System;

/// Where a distributed run is computed.
#[derive(Debug, Clone)]
pub struct Cluster {
    /// Where workers dial us; without, a socket that only this user can reach.
    pub access: Option<Access>,
    /// So many workers are started here for this run; they end with it.
    pub own: usize,
    /// The program to start for a worker of our own.
    pub program: Vec<String>,
    /// How many workers there must be.
    pub needed: usize,
    /// How long to wait for them.
    pub patience: Duration,
    /// Wishes `component=worker`.
    pub places: Vec<(String, String)>,
    /// What happens when something fails.
    pub options: Options,
}

impl Cluster {
    /// Runs `run` of `system` there.
    pub fn go(&self, system: &System, run: Run<'_>) -> Result<Summary> {
        let folder = private_folder()?;
        let access = self.access.clone().unwrap_or_else(|| Access {
            endpoints: vec![format!("unixsock-stream/{}/socket", folder.path().display())],
            ..Access::default()
        });
        let session = access.listen()?;
        let _own = OwnWorkers::start(self, &access, folder.path())?;
        let named: Vec<String> = self.places.iter().map(|(_, worker)| worker.clone()).collect();
        // The plan needs the workers' names, and the session the FMUs of the plan.
        let id = session.zid().to_string();
        let waiting = Net::new(session.clone(), &id, Default::default())?;
        let workers = waiting.gather(self.needed.max(self.own), &named, self.patience)?;
        let places = place(system, &self.places, &workers)?;
        drop(waiting);

        // A worker without components is a spare.
        let mut used: Vec<usize> = places.clone();
        used.sort_unstable();
        used.dedup();
        let group = |worker: &usize| used.iter().position(|u| u == worker).unwrap_or_default();
        let places: Vec<usize> = places.iter().map(group).collect();
        let homes = used.iter().map(|&worker| workers[worker].clone()).collect();
        let distribution = Distribution::new(system, &places)?;
        let mut net = Net::new(session.clone(), &id, distribution.files.clone())?;
        net.gather(workers.len(), &[], self.patience)?;
        let differences = differences(&net.infos());
        net.settle(homes);
        let Distribution { plan, layout, setups, .. } = distribution;
        let options = self.options.clone();
        let name = |&component: &usize| system.components()[component].name.clone();
        let groups = layout.groups.iter();
        let groups = groups.map(|group| group.own.iter().map(name).collect()).collect();
        let board = Board::new(&id, system.name(), system.stop_time().seconds(), groups);
        let names = system.columns().iter().map(|column| column.name.clone()).collect();
        let (feed, sender) = telemetry::open(&session, &id, &board, names, self.options.telemetry)?;
        let fabric = Box::new(Watched::new(net, &board));
        let mut driven = Coordinator::new(system, plan, layout, &setups, fabric, options)?;
        driven.warn(differences);
        let outcome = std::thread::scope(|threads| {
            threads.spawn(|| sender.serve());
            // When the feed is dropped the sender tells the end, and ends.
            run.drive_all(&mut Fed { driven: &mut driven, feed })
        });
        driven.end();
        drop(driven);
        close(session);
        outcome
    }
}

/// So long a session may take to close.
const FAREWELL: Duration = Duration::from_millis(500);

/// Closes a session. Everything is said: one that does not close in order, because somebody does
/// not listen any more, ends with the process.
fn close(session: Session) {
    let (closed, inbox) = channel();
    std::thread::spawn(move || {
        let _ = session.close().wait();
        let _ = closed.send(());
    });
    let _ = inbox.recv_timeout(FAREWELL);
}

/// Lists the workers that dial `access` within `patience`.
pub fn workers(access: &Access, patience: Duration) -> Result<Vec<WorkerInfo>> {
    let session = access.listen()?;
    let net = Net::new(session.clone(), &session.zid().to_string(), Default::default())?;
    std::thread::sleep(patience);
    let infos = net.infos();
    drop(net);
    close(session);
    Ok(infos)
}

/// What differs between workers and may change the last bit of results, and what they lack.
fn differences(infos: &[WorkerInfo]) -> Vec<String> {
    let Some((first, others)) = infos.split_first() else {
        return Vec::new();
    };
    let unlike = others.iter().filter(|other| other.computes() != first.computes());
    let told = unlike.map(|other| {
        let (name, one) = (&first.name, &other.name);
        let (computes, differs) = (first.computes(), other.computes());
        format!(
            "the workers {name} ({computes}) and {one} ({differs}) differ: FMUs that use functions \
             of the C library may give other last bits"
        )
    });
    let loose: Vec<&str> = infos.iter().filter(|i| i.is_loose()).map(|i| i.name.as_str()).collect();
    let loose = (!loose.is_empty()).then(|| {
        format!(
            "the FMUs of {} are not confined: the kernel there has no Landlock",
            loose.join(", ")
        )
    });
    told.chain(loose).collect()
}

/// Workers on this machine that end with the run, however it ends.
struct OwnWorkers(Vec<Child>);

impl OwnWorkers {
    /// What is temporary goes into `folder`, which vanishes with the run.
    fn start(cluster: &Cluster, access: &Access, folder: &Path) -> Result<Self> {
        let mut own = Self(Vec::new());
        let Some((program, arguments)) = cluster.program.split_first() else {
            return Ok(own);
        };
        if cluster.own == 0 {
            return Ok(own);
        }
        let endpoint = access.endpoints.first().cloned().unwrap_or_default();
        for number in 1..=cluster.own {
            let child = Command::new(program)
                .args(arguments)
                .args(["--name", &format!("worker-{number}")])
                .args(["--connect", &endpoint])
                .env("TMPDIR", folder)
                .stdin(Stdio::null())
                // Ctrl-C at a terminal is for the process that the user started.
                .process_group(0)
                .spawn();
            own.0.push(child.map_err(|why| {
                Error::new(Code::Session, "a worker cannot be started").at(program).why(why)
            })?);
        }
        Ok(own)
    }
}

/// A folder that is ours alone and vanishes with the run.
fn private_folder() -> Result<tempfile::TempDir> {
    tempfile::Builder::new()
        .prefix("cosim-")
        .tempdir()
        .map_err(|why| Error::new(Code::Output, "no temporary folder could be made").why(why))
}

impl Drop for OwnWorkers {
    fn drop(&mut self) {
        for child in &mut self.0 {
            // Its children end with it; it may have ended already.
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}
