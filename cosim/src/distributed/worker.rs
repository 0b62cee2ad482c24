//! `cosim worker`: lends this machine. It supervises; FMUs run in child processes, one per life
//! of a group, so that one that crashes or spins takes nothing with it.

use std::collections::BTreeMap;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use zenoh::Wait;
use zenoh::query::Query;

use super::keys;
use super::members::Role;
use super::pool::{Order, WorkerInfo};
use super::rights;
use super::session::Access;
use crate::error::{Code, Error, Result};

/// A worker to be run.
pub struct Worker {
    /// Its name, unique in the pool.
    pub name: String,
    /// How it reaches the coordinator.
    pub access: Access,
    /// The program to start for a life, with arguments that make it call [`super::child::serve`].
    pub program: Vec<String>,
    /// FMUs are confined where the kernel can.
    pub confined: bool,
}

/// What the supervisor is asked to do.
enum Request {
    Info(Query),
    Start(Query),
    Stop(Query),
}

/// What is asked under a name below the worker's key.
type Asked = (&'static str, fn(Query) -> Request);

impl Worker {
    /// Serves until `ended` says so.
    pub fn serve(&self, ended: &dyn Fn() -> bool) -> Result<()> {
        let session = self.access.dial()?;
        self.may_work(&session)?;
        let (requests, inbox) = channel();
        let key = keys::worker(&self.name);
        let mut queryables = Vec::new();
        let kinds: [Asked; 3] =
            [("info", Request::Info), ("start", Request::Start), ("stop", Request::Stop)];
        for (name, request) in kinds {
            let requests: Sender<Request> = requests.clone();
            let queryable = session
                .declare_queryable(format!("{key}/{name}"))
                .callback(move |query| {
                    // The receiver is gone only when the worker ends.
                    let _ = requests.send(request(query));
                })
                .wait();
            queryables.push(queryable.map_err(refused)?);
        }
        let _token = session.liveliness().declare_token(&key).wait().map_err(refused)?;
        let mut children = Children { worker: self, lives: BTreeMap::new() };
        children.serve(&inbox, ended);
        Ok(())
    }
}

impl Worker {
    /// A worker speaks under the name in its certificate; another one is dropped in silence.
    fn may_work(&self, session: &zenoh::Session) -> Result<()> {
        match rights::ask(session, &self.access, Role::Worker)? {
            Some((name, Role::Worker)) if name != self.name => {
                let what = format!("the worker '{}' has the certificate of '{name}'", self.name);
                Err(Error::new(Code::Forbidden, what)
                    .why("a worker may speak under the name in its certificate only")
                    .help(format!("--name {name}, or --credentials of '{}'", self.name)))
            }
            _ => Ok(()),
        }
    }
}

fn refused(why: zenoh::Error) -> Error {
    Error::new(Code::Session, "the worker cannot announce itself").why(why)
}

/// The lives that this worker keeps.
struct Children<'a> {
    worker: &'a Worker,
    lives: BTreeMap<(String, usize), Life>,
}

/// A child process and the folder that is its own: whatever it leaves there goes with it.
struct Life {
    generation: u32,
    child: Child,
    _folder: tempfile::TempDir,
}

impl Children<'_> {
    fn serve(&mut self, inbox: &Receiver<Request>, ended: &dyn Fn() -> bool) {
        let info = WorkerInfo::of_this(&self.worker.name, self.worker.confined);
        while !ended() {
            let answered = match inbox.recv_timeout(Duration::from_millis(200)) {
                Ok(Request::Info(query)) => answer(&query, &info),
                Ok(Request::Start(query)) => self.with_order(&query, Self::start),
                Ok(Request::Stop(query)) => self.with_order(&query, Self::stop),
                Err(RecvTimeoutError::Timeout) => Ok(()),
                Err(RecvTimeoutError::Disconnected) => return,
            };
            if let Err(why) = answered {
                eprintln!("worker {}: an answer was not sent: {why}", self.worker.name);
            }
            self.reap();
        }
    }

    fn with_order(
        &mut self,
        query: &Query,
        act: fn(&mut Self, &Order) -> std::io::Result<()>,
    ) -> Result<(), zenoh::Error> {
        let payload = query.payload().map(|payload| payload.to_bytes().into_owned());
        let order = payload.as_deref().map(postcard::from_bytes::<Order>);
        let outcome = match order {
            Some(Ok(order)) => act(self, &order).map_err(|why| why.to_string()),
            _ => Err("the order cannot be read".to_owned()),
        };
        answer(query, &outcome)
    }

    fn start(&mut self, order: &Order) -> std::io::Result<()> {
        let program = &self.worker.program;
        let (name, arguments) = program.split_first().ok_or(std::io::ErrorKind::InvalidInput)?;
        let folder = tempfile::Builder::new().prefix("cosim-").tempdir()?;
        let child = Command::new(name)
            .args(arguments)
            .args(["--run", &order.run])
            .args(["--group", &order.group.to_string()])
            .args(["--generation", &order.generation.to_string()])
            .env("TMPDIR", folder.path())
            .stdin(Stdio::null())
            // Ctrl-C at a terminal is for the process that the user started.
            .process_group(0)
            .spawn()?;
        let life = Life { generation: order.generation, child, _folder: folder };
        if let Some(former) = self.lives.insert((order.run.clone(), order.group), life) {
            end(former);
        }
        Ok(())
    }

    fn stop(&mut self, order: &Order) -> std::io::Result<()> {
        let key = (order.run.clone(), order.group);
        if self.lives.get(&key).is_some_and(|life| life.generation == order.generation)
            && let Some(life) = self.lives.remove(&key)
        {
            end(life);
        }
        Ok(())
    }

    /// Forgets children that ended by themselves.
    fn reap(&mut self) {
        self.lives.retain(|(run, group), life| match life.child.try_wait() {
            Ok(Some(status)) if !status.success() => {
                eprintln!("group {group}.{} of run {run} ended: {status}", life.generation);
                false
            }
            Ok(Some(_)) | Err(_) => false,
            Ok(None) => true,
        });
    }
}

impl Drop for Children<'_> {
    fn drop(&mut self) {
        std::mem::take(&mut self.lives).into_values().for_each(end);
    }
}

/// Kills a child: an FMU that spins listens to nothing softer.
fn end(mut life: Life) {
    // It may have ended already.
    let _ = life.child.kill();
    let _ = life.child.wait();
}

fn answer<T: serde::Serialize>(query: &Query, value: &T) -> Result<(), zenoh::Error> {
    let bytes = postcard::to_stdvec(value)?;
    query.reply(query.key_expr().clone(), bytes).wait()
}
