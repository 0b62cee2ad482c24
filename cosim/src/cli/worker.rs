//! `cosim worker`: makes this machine available to runs; also the process for one group of
//! components.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use cosim::distributed::{Allowed, DEFAULT_ENDPOINT, Order, Ours, serve_group};
use cosim::{Code, Result, distributed};
use rustix::process::Signal;

use super::distributed::Reach;
use super::interrupt;

/// Make this machine available to distributed runs
#[derive(Args)]
pub(crate) struct Worker {
    /// Name of this worker (default: the host name and a number)
    #[arg(long)]
    name: Option<String>,
    /// Where runs and remote FMUs listen; several, separated by commas, are all served (default:
    /// tcp/127.0.0.1:7447)
    #[arg(long, value_name = "ENDPOINT")]
    connect: Option<String>,
    #[command(flatten)]
    lent: Lent,
    /// End with the process that started this one
    #[arg(long, hide = true)]
    with_parent: bool,
    #[command(flatten)]
    reach: Reach,
}

/// What a worker provides to runs.
#[derive(Args)]
struct Lent {
    /// Load this FMU if a run sends it: its SHA-256, its file, or a folder of FMUs (repeatable)
    #[arg(long, value_name = "HASH|FILE|FOLDER")]
    allow: Vec<String>,
    /// Refuse to start unless each file of --allow has a signature FILE.sig by this public key
    #[arg(long, value_name = "KEY.pub")]
    verify_signature: Option<PathBuf>,
    /// Load every FMU that a run sends
    #[arg(long)]
    allow_upload: bool,
    /// Do not confine FMUs: they may do anything this user may
    #[arg(long)]
    no_confine: bool,
    /// Let confined FMUs read this file or folder (repeatable)
    #[arg(long, value_name = "PATH")]
    allow_read: Vec<PathBuf>,
}

impl Lent {
    /// Combined with the configuration file.
    fn and(self, ours: &Ours) -> Self {
        Self {
            allow: [self.allow, ours.allow.clone()].concat(),
            allow_upload: self.allow_upload || ours.allow_upload,
            verify_signature: self.verify_signature,
            no_confine: self.no_confine || ours.no_confine,
            allow_read: self.allow_read,
        }
    }

    /// For the processes of groups: the files are read only once.
    fn arguments(&self, allowed: &Allowed) -> Vec<String> {
        let hashes = allowed.list().flat_map(|item| ["--allow".to_owned(), item]);
        let flags = [(allowed.all, "--allow-upload"), (self.no_confine, "--no-confine")];
        let flags = flags.into_iter().filter(|(is, _)| *is).map(|(_, flag)| flag.to_owned());
        let readable = self.allow_read.iter().filter_map(|path| path.to_str());
        let readable = readable.flat_map(|path| ["--allow-read".to_owned(), path.to_owned()]);
        flags.chain(hashes).chain(readable).collect()
    }
}

/// List the workers that connect to an endpoint
#[derive(Args)]
pub(crate) struct Workers {
    /// Where workers connect (default: tcp/127.0.0.1:7447)
    #[arg(long, value_name = "ENDPOINT")]
    listen: Option<String>,
    /// How long to wait for them, in seconds
    #[arg(long, value_name = "SECONDS", default_value = "2", value_parser = super::values::seconds)]
    wait: f64,
    #[command(flatten)]
    reach: Reach,
}

impl Workers {
    pub(crate) fn run(self) -> Result<()> {
        let patience = std::time::Duration::from_secs_f64(self.wait);
        let ours = self.reach.ours()?;
        let listen = self.listen.or_else(|| ours.listen.clone());
        let access = self.reach.access(listen.unwrap_or(DEFAULT_ENDPOINT.to_owned()), &ours);
        for worker in distributed::workers(&access, patience)? {
            let (name, host, process) = (&worker.name, &worker.host, worker.process);
            super::output::print(&format!(
                "{name}: {host}, process {process}, {}, {}",
                worker.computes(),
                worker.confined
            ))?;
        }
        Ok(())
    }
}

/// Compute a group of components, as requested by a worker
#[derive(Args)]
#[command(hide = true)]
pub(crate) struct Group {
    #[arg(long)]
    connect: String,
    #[arg(long)]
    run: String,
    #[arg(long)]
    worker: String,
    #[arg(long)]
    group: usize,
    #[arg(long)]
    generation: u32,
    #[command(flatten)]
    lent: Lent,
    #[command(flatten)]
    reach: Reach,
}

impl Worker {
    pub(crate) fn run(self) -> Result<()> {
        if self.with_parent {
            interrupt::end_with_parent(Signal::KILL)?;
        }
        let ours = self.reach.ours()?;
        let connect = self.connect.or_else(|| ours.connect.clone());
        let connect = connect.unwrap_or(DEFAULT_ENDPOINT.to_owned());
        let lent = self.lent.and(&ours);
        let mut arguments = self.reach.arguments();
        let allowed =
            Allowed::new(lent.allow_upload, &lent.allow, lent.verify_signature.as_deref())?;
        arguments.extend(lent.arguments(&allowed));
        let name = self.name.or_else(|| ours.name.clone());
        let name = name.unwrap_or_else(distributed::default_name);
        interrupt::listen();
        let confined = !lent.no_confine;
        if let Some(why) = distributed::unconfined().filter(|_| confined && !self.with_parent) {
            super::messages::warning(&why);
        }
        let program = super::this_program()?;
        let workers = cosim::distributed::several(&connect).map(|endpoint| {
            let own = [&program, "group", "--connect", endpoint].map(str::to_owned);
            distributed::Worker {
                name: name.clone(),
                access: self.reach.access(endpoint.to_owned(), &ours),
                program: own.into_iter().chain(arguments.iter().cloned()).collect(),
                confined,
                allowed: allowed.clone(),
            }
        });
        serve_all(&workers.collect::<Vec<_>>(), &interrupt::interrupted)
    }
}

/// How long to wait before trying a failed endpoint again.
const PAUSE: Duration = Duration::from_secs(1);

/// Serves each endpoint in its own thread. If there are several, a failure of one is reported and
/// does not end the others; a lost session is connected again.
fn serve_all(workers: &[distributed::Worker], ended: &(dyn Fn() -> bool + Sync)) -> Result<()> {
    if let [only] = workers {
        return only.serve(ended);
    }
    workers.iter().try_for_each(|worker| worker.access.check())?;
    std::thread::scope(|threads| {
        let threads = workers.iter().map(|w| threads.spawn(move || serve_again(w, ended)));
        let threads: Vec<_> = threads.collect();
        let join = |thread: std::thread::ScopedJoinHandle<'_, _>| {
            thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        };
        let outcomes: Vec<Result<()>> = threads.into_iter().map(join).collect();
        // Workers that were asked to end take precedence over those that failed before.
        outcomes.into_iter().reduce(|a, b| if a.is_ok() { a } else { b }).unwrap_or(Ok(()))
    })
}

fn serve_again(worker: &distributed::Worker, ended: &(dyn Fn() -> bool + Sync)) -> Result<()> {
    let mut reported = String::new();
    loop {
        let error = match worker.serve(ended) {
            Err(error) if !ended() => error,
            served => return served,
        };
        let text = error.to_string();
        if text != reported {
            let endpoint = worker.access.endpoints.join(", ");
            super::messages::warning(&format!("the endpoint {endpoint} is not served: {text}"));
            reported = text;
        }
        if error.code() != Code::Session {
            return Err(error);
        }
        let failed = Instant::now();
        while failed.elapsed() < PAUSE && !ended() {
            std::thread::sleep(PAUSE / 20);
        }
    }
}

impl Group {
    pub(crate) fn run(self) -> Result<()> {
        interrupt::end_with_parent(Signal::KILL)?;
        distributed::close_inherited(&[]);
        cosim::fmi::guard_process();
        let order = Order { run: self.run, group: self.group, generation: self.generation };
        let access = self.reach.access(self.connect, &self.reach.ours()?);
        let allowed = Allowed::new(self.lent.allow_upload, &self.lent.allow, None)?;
        let readable = (!self.lent.no_confine).then_some(&self.lent.allow_read[..]);
        serve_group(&access, &self.worker, &order, allowed, readable)
    }
}
