//! Command-line options for workers.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use cosim::Result;
pub(crate) use cosim::distributed::Cluster;
use cosim::distributed::{
    Access, Configuration, Credentials, DEFAULT_ENDPOINT, OnFatal, Options, Ours, Rate,
};

use super::{messages, values};

/// How to reach the other side.
#[derive(Args, Clone)]
pub(crate) struct Reach {
    /// A configuration file: Zenoh's json5, with our settings under cosim: {}
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// A folder with ca.pem, cert.pem and key.pem (cosim keys), for endpoints tls/HOST:PORT
    #[arg(long, value_name = "FOLDER")]
    credentials: Option<PathBuf>,
    /// Allow an endpoint on another machine without TLS
    #[arg(long)]
    insecure: bool,
}

impl Reach {
    /// Our settings in the configuration file.
    pub(crate) fn ours(&self) -> Result<Ours> {
        let read = self.config.as_deref().map(Configuration::read).transpose()?;
        Ok(read.map(|read| read.ours).unwrap_or_default())
    }

    /// Whether there are certificates, without which there is no TLS.
    fn has_credentials(&self) -> bool {
        let filed = || self.ours().is_ok_and(|ours| ours.credentials.is_some());
        self.credentials.is_some() || filed()
    }

    /// The command line overrides the configuration file.
    pub(crate) fn access(&self, endpoint: String, ours: &Ours) -> Access {
        let credentials = self.credentials.as_ref().or(ours.credentials.as_ref());
        Access {
            endpoints: vec![endpoint],
            configuration: self.config.clone(),
            credentials: credentials.map(|folder| Credentials::in_folder(folder)),
            insecure: self.insecure || ours.insecure,
        }
    }

    /// The same as arguments for a process started here.
    pub(crate) fn arguments(&self) -> Vec<String> {
        let mut arguments = Vec::new();
        let text = |path: &PathBuf| path.to_string_lossy().into_owned();
        if let Some(file) = &self.config {
            arguments.extend(["--config".to_owned(), text(file)]);
        }
        if let Some(folder) = &self.credentials {
            arguments.extend(["--credentials".to_owned(), text(folder)]);
        }
        if self.insecure {
            arguments.push("--insecure".to_owned());
        }
        arguments
    }
}

/// What happens to a run with a fatal FMU.
#[derive(Clone, Copy, Default, clap::ValueEnum)]
enum Fatal {
    /// It ends
    #[default]
    End,
    /// It continues in another process
    Resume,
}

/// Options for runs on workers.
#[derive(Args)]
#[command(next_help_heading = "Distributed runs")]
pub(crate) struct Distributed {
    /// Compute in this many worker processes on this machine, started for this run
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    workers: Option<u32>,
    /// Compute on the workers that connect to the endpoint of --listen
    #[arg(long, conflicts_with = "workers")]
    distributed: bool,
    /// Where workers connect to this run (default: tcp/127.0.0.1:7447)
    #[arg(long, value_name = "ENDPOINT")]
    listen: Option<String>,
    /// Wait for this many workers
    #[arg(long, value_name = "N", default_value_t = 1)]
    min_workers: u32,
    /// How long to wait for workers, in seconds
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = values::seconds)]
    wait: f64,
    /// Compute a component on this worker (repeatable; the rest is placed by coupling)
    #[arg(long, value_name = "COMPONENT=WORKER", value_parser = values::assignment)]
    place: Vec<(String, String)>,
    /// Save the state of every worker after this many instants; 0: never
    #[arg(long, value_name = "N", default_value_t = 50)]
    save_every: u64,
    /// Give up a worker that does not answer within this many seconds
    #[arg(long, value_name = "SECONDS", default_value = "5", value_parser = values::seconds)]
    deadline: f64,
    /// How often components may be restarted on another worker
    #[arg(long, value_name = "N", default_value_t = 1000)]
    recoveries: u32,
    /// End the run if components are lost whose state was not saved, instead of computing them
    /// again from the start
    #[arg(long)]
    require_resume: bool,
    /// What happens to the run if an FMU returns fmi2Fatal; with resume, its components are
    /// restarted in another process, as after a crash
    #[arg(long, value_name = "WHAT", value_enum, default_value_t)]
    on_fatal: Fatal,
    /// Send recorded values to observers, at most RATE times a second (default: always)
    #[arg(long, value_name = "RATE", value_parser = values::factor, require_equals = true)]
    telemetry: Option<Option<f64>>,
    #[command(flatten)]
    reach: Reach,
}

impl Distributed {
    /// Whether workers may connect with TLS.
    pub(crate) fn may_use_tls(&self) -> bool {
        self.reach.has_credentials()
    }

    /// Whether the run starts local workers.
    pub(crate) fn starts_workers(&self) -> bool {
        self.workers.is_some()
    }

    /// Where the run is computed; `None`: in this process. FMUs in local workers may read
    /// `readable`.
    pub(crate) fn cluster(
        &self,
        quiet: bool,
        readable: impl Iterator<Item = String>,
    ) -> Result<Option<Cluster>> {
        if !self.distributed && self.workers.is_none() {
            return Ok(None);
        }
        let local = self.workers.unwrap_or(0) as usize;
        let mut program = vec![super::this_program()?, "worker".to_owned()];
        // They belong to this user, and this user runs everything they are sent.
        program.extend(["--with-parent", "--allow-upload"].map(str::to_owned));
        program.extend(readable.flat_map(|path| ["--allow-read".to_owned(), path]));
        program.extend(self.reach.arguments());
        let ours = self.reach.ours()?;
        let listen = self.listen.clone().or_else(|| ours.listen.clone());
        let options = Options {
            save_every: Some(self.save_every).filter(|every| *every > 0),
            deadline: Duration::from_secs_f64(self.deadline),
            recoveries: self.recoveries,
            on_fatal: match self.on_fatal {
                Fatal::End => OnFatal::End,
                Fatal::Resume => OnFatal::Resume,
            },
            require_resume: self.require_resume,
            // A terminal shows a progress bar; losses are reported at the end.
            report: if quiet || std::io::stderr().is_terminal() { |_| () } else { messages::note },
            telemetry: self.telemetry.map(|rate| rate.map_or(Rate::All, Rate::PerSecond)),
            ..Options::default()
        };
        let endpoint = match local {
            0 => Some(listen.unwrap_or(DEFAULT_ENDPOINT.to_owned())),
            _ => listen,
        };
        Ok(Some(Cluster {
            access: endpoint.map(|endpoint| self.reach.access(endpoint, &ours)),
            local,
            program,
            needed: self.min_workers.max(1) as usize,
            patience: Duration::from_secs_f64(self.wait),
            places: self.place.clone(),
            options,
        }))
    }
}
