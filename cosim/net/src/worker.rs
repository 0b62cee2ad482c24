//! `cosim worker`: makes this machine available. It supervises; FMUs run in child processes, one
//! per incarnation of a group, so that an FMU that crashes or hangs takes nothing else with it.

use std::collections::BTreeMap;
use std::io::{self, IsTerminal};
use std::os::unix::process::CommandExt;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use zenoh::query::Query;
use zenoh::sample::SampleKind;
use zenoh::{Session, Wait};

use super::access::allowed::Allowed;
use super::access::members::Role;
use super::access::rights;
use super::access::session::Access;
use super::available_fmu::AvailableFmu;
use super::child::LAST_CALL;
use super::keys;
use super::pool::{Order, WorkerInfo};
use super::process_status::{Call, ProcessState, ProcessStatus};
use cosim_base::error::{Code, Error, Result};
use cosim_base::shown::{relay, visible};
use cosim_confine::{Supervised, environment, kill_orphans, reap_descendants};
use cosim_import::LastCall;
use cosim_import::temporary::Unpacked;

/// Configuration of a worker.
pub struct Worker {
    /// Its name, unique in the pool.
    pub name: String,
    /// How it reaches the coordinator.
    pub access: Access,
    /// The program to start for an incarnation, with arguments that make it call
    /// [`super::child::serve`].
    pub program: Vec<String>,
    /// FMUs are confined where the kernel supports it.
    pub confined: bool,
    /// The FMUs it loads, and advertises if it has the file.
    pub allowed: Allowed,
}

/// How long another worker of the same name may remain.
const NAME_PATIENCE: Duration = Duration::from_secs(3);
/// How long after the end of its connection a process may still take to exit.
const EXIT_DELAY: Duration = Duration::from_millis(50);

/// Requests to the supervisor.
enum Request {
    Info(Query),
    Start(Query),
    Stop(Query),
    Status(Query),
    Fmu(Query),
    /// This run is gone.
    Gone(String),
}

/// A request by its name below the worker's key.
type Asked = (&'static str, fn(Query) -> Request);

impl Worker {
    /// Serves until `ended` returns true.
    pub fn serve(&self, ended: &dyn Fn() -> bool) -> Result<()> {
        let Some(session) = self.dialled(ended)? else {
            return Ok(());
        };
        self.may_work(&session)?;
        let (requests, inbox) = channel();
        let key = keys::worker(&self.name);
        let mut queryables = Vec::new();
        self.have_name(&session, &key)?;
        let kinds: [Asked; 5] = [
            ("info", Request::Info),
            ("start", Request::Start),
            ("stop", Request::Stop),
            ("fate", Request::Status),
            ("offer", Request::Fmu),
        ];
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
        let _runs = session
            .liveliness()
            .declare_subscriber(keys::running("*"))
            .history(true)
            .callback(move |sample| {
                let gone = sample.kind() == SampleKind::Delete;
                if let Some(run) = keys::parse_running(sample.key_expr().as_str()).filter(|_| gone)
                {
                    let _ = requests.send(Request::Gone(run.to_owned()));
                }
            })
            .wait()
            .map_err(refused)?;
        let _token = session.liveliness().declare_token(&key).wait().map_err(refused)?;
        reap_descendants();
        let mut children = Children { worker: self, incarnations: BTreeMap::new() };
        children.serve(&inbox, ended);
        Ok(())
    }

    /// A session with the listening side; a worker that is allowed to wait does so until something
    /// listens.
    fn dialled(&self, ended: &dyn Fn() -> bool) -> Result<Option<Session>> {
        self.access.check()?;
        while !ended() {
            match self.access.dial() {
                Err(_) if self.access.has_no_listener() => {}
                dialled => return dialled.map(Some),
            }
        }
        Ok(None)
    }

    /// A worker speaks under the name in its certificate; messages under another name are dropped
    /// silently.
    fn may_work(&self, session: &zenoh::Session) -> Result<()> {
        match rights::ask(session, &self.access, Role::Worker)? {
            Some((name, Role::Worker)) if name != self.name => {
                let what = format!("the worker '{}' has the certificate of '{name}'", self.name);
                Err(Error::new(Code::Forbidden, what)
                    .why("a worker may only use the name in its certificate")
                    .help(format!("--name {name}, or --credentials of '{}'", self.name)))
            }
            _ => Ok(()),
        }
    }

    /// Waits until no other worker has our name: a killed worker is gone at once, one that was cut
    /// off after its lease.
    fn have_name(&self, session: &Session, key: &str) -> Result<()> {
        let begun = Instant::now();
        loop {
            let there = session.liveliness().get(key).timeout(NAME_PATIENCE).wait();
            let taken = there.map_err(refused)?.into_iter().any(|reply| reply.result().is_ok());
            if !taken {
                return Ok(());
            }
            if begun.elapsed() > NAME_PATIENCE {
                let what = format!("a worker named '{}' is already connected", self.name);
                return Err(Error::new(Code::Session, what).help("choose another --name"));
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

fn refused(why: zenoh::Error) -> Error {
    Error::new(Code::Session, "the worker cannot announce itself").why(why)
}

/// The incarnations that this worker runs.
struct Children<'a> {
    worker: &'a Worker,
    incarnations: BTreeMap<(String, usize), Incarnation>,
}

/// A child process and its own folder, which is removed with everything left in it.
struct Incarnation {
    generation: u32,
    child: Supervised,
    folder: Unpacked,
    /// Its exit status if it exited by itself.
    ended: Option<ExitStatus>,
}

impl Children<'_> {
    fn serve(&mut self, inbox: &Receiver<Request>, ended: &dyn Fn() -> bool) {
        let info = WorkerInfo::of_this(&self.worker.name, self.worker.confined);
        while !ended() {
            let answered = match inbox.recv_timeout(Duration::from_millis(50)) {
                Ok(Request::Info(query)) => answer(&query, &info),
                Ok(Request::Start(query)) => self.with_order(&query, Self::start),
                Ok(Request::Stop(query)) => self.with_order(&query, Self::stop),
                Ok(Request::Status(query)) => self.with_order(&query, Self::status),
                Ok(Request::Fmu(query)) => answer(&query, &self.available_fmu(&query)),
                Ok(Request::Gone(run)) => {
                    self.end_run(&run);
                    Ok(())
                }
                Err(RecvTimeoutError::Timeout) => Ok(()),
                Err(RecvTimeoutError::Disconnected) => return,
            };
            if let Err(why) = answered {
                eprintln!(
                    "worker {}: an answer was not sent: {}",
                    self.worker.name,
                    visible(&why.to_string())
                );
            }
            self.reap();
        }
    }

    fn with_order<T: serde::Serialize>(
        &mut self,
        query: &Query,
        act: fn(&mut Self, &Order) -> std::io::Result<T>,
    ) -> Result<(), zenoh::Error> {
        let payload = query.payload().map(|payload| payload.to_bytes().into_owned());
        let order = payload.as_deref().map(postcard::from_bytes::<Order>);
        let outcome = match order {
            Some(Ok(order)) => act(self, &order).map_err(|why| why.to_string()),
            _ => Err("the order cannot be read".to_owned()),
        };
        answer(query, &outcome)
    }

    fn available_fmu(&self, query: &Query) -> Result<AvailableFmu, String> {
        let payload = query.payload().map(|payload| payload.to_bytes().into_owned());
        let wanted = String::from_utf8(payload.unwrap_or_default());
        AvailableFmu::of(&self.worker.allowed, &wanted.map_err(|why| why.to_string())?)
    }

    fn start(&mut self, order: &Order) -> std::io::Result<()> {
        let program = &self.worker.program;
        let (name, arguments) = program.split_first().ok_or(std::io::ErrorKind::InvalidInput)?;
        let folder = Unpacked::new().map_err(std::io::Error::other)?;
        let mut command = Command::new(name);
        command
            .args(arguments)
            .args(["--run", &order.run])
            .args(["--worker", &self.worker.name])
            .args(["--group", &order.group.to_string()])
            .args(["--generation", &order.generation.to_string()])
            .stdin(Stdio::null())
            // What FMUs print may contain commands for a terminal, which they must not have.
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            // Ctrl-C at a terminal is for the process that the user started.
            .process_group(0);
        if self.worker.confined {
            command.env_clear().envs(environment());
        }
        command.env("TMPDIR", folder.path());
        let mut child = Supervised::start(&mut command)?;
        child.0.stdout.take().map(|from| relay(from, io::stdout(), io::stdout().is_terminal()));
        child.0.stderr.take().map(|from| relay(from, io::stderr(), true));
        let incarnation = Incarnation { generation: order.generation, child, folder, ended: None };
        // A former one ends here.
        drop(self.incarnations.insert((order.run.clone(), order.group), incarnation));
        Ok(())
    }

    fn stop(&mut self, order: &Order) -> std::io::Result<()> {
        let key = (order.run.clone(), order.group);
        if self
            .incarnations
            .get(&key)
            .is_some_and(|incarnation| incarnation.generation == order.generation)
        {
            self.incarnations.remove(&key);
        }
        Ok(())
    }

    /// How an incarnation ended, or what it is doing.
    fn status(&mut self, order: &Order) -> std::io::Result<ProcessStatus> {
        let incarnation = self.incarnations.get_mut(&(order.run.clone(), order.group));
        let incarnation =
            incarnation.filter(|incarnation| incarnation.generation == order.generation);
        let incarnation =
            incarnation.ok_or_else(|| std::io::Error::other("there is no such incarnation"))?;
        let begun = Instant::now();
        while incarnation.ended.is_none() && begun.elapsed() < EXIT_DELAY {
            incarnation.ended = incarnation.child.0.try_wait()?;
            std::thread::sleep(Duration::from_millis(1));
        }
        let process = match incarnation.ended {
            Some(status) => ProcessState::ended(status),
            None => ProcessState::running(incarnation.child.0.id()),
        };
        let call = LastCall::read(incarnation.folder.path().join(LAST_CALL)).map(Call::from);
        Ok(ProcessStatus { process, call })
    }

    /// Ends all incarnations of a run.
    fn end_run(&mut self, run: &str) {
        self.incarnations.retain(|(of, _), _| of != run);
    }

    /// Notes which children exited by themselves; the coordinator asks for them.
    fn reap(&mut self) {
        let mut left = false;
        for incarnation in
            self.incarnations.values_mut().filter(|incarnation| incarnation.ended.is_none())
        {
            incarnation.ended = incarnation.child.0.try_wait().ok().flatten();
            left |= incarnation.ended.is_some();
        }
        if left {
            kill_orphans();
        }
    }
}

fn answer<T: serde::Serialize>(query: &Query, value: &T) -> Result<(), zenoh::Error> {
    let bytes = postcard::to_stdvec(value)?;
    query.reply(query.key_expr().clone(), bytes).wait()
}
