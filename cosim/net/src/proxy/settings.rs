//! How workers are reached: a file in the resources, overridden by the environment.

use std::env;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::{Access, Configuration, Credentials, DEFAULT_ENDPOINT, Ours, Reached, several};
use cosim_base::error::{Code, Error, Result};
use cosim_import::proxy::manifest::CONNECTION;

/// The environment variables and their settings.
const FILE: &str = "COSIM_REMOTE_CONFIG";
const LISTEN: &str = "COSIM_REMOTE_LISTEN";
const CREDENTIALS: &str = "COSIM_REMOTE_CREDENTIALS";
const WORKER: &str = "COSIM_REMOTE_WORKER";
const WAIT: &str = "COSIM_REMOTE_WAIT";
const DEADLINE: &str = "COSIM_REMOTE_DEADLINE";
const SAVE_EVERY: &str = "COSIM_REMOTE_SAVE_EVERY";

/// Defaults.
const WAIT_S: f64 = 10.0;
const DEADLINE_S: f64 = 5.0;
const SAVED_EVERY: u64 = 50;

/// The settings written into the resources of a remote FMU.
#[derive(Debug, Clone, Default)]
pub(super) struct Settings {
    pub listen: Vec<String>,
    pub credentials: Option<PathBuf>,
    pub insecure: bool,
    pub worker: Option<String>,
    pub wait: Option<f64>,
    pub deadline: Option<f64>,
    pub save_every: Option<u64>,
}

impl Settings {
    /// The endpoints where workers connect, as in the file.
    fn listen(&self) -> String {
        match &self.listen[..] {
            [] => DEFAULT_ENDPOINT.to_owned(),
            named => named.join(", "),
        }
    }

    /// The folder of certificates as an absolute path: a relative one would refer to the file in
    /// the FMU.
    fn folder(&self) -> Option<PathBuf> {
        let folder = self.credentials.as_ref()?;
        Some(std::path::absolute(folder).unwrap_or_else(|_| folder.clone()))
    }

    /// The same endpoints for us.
    pub(super) fn accesses(&self) -> Vec<Access> {
        let access = |endpoint: &str| Access {
            endpoints: vec![endpoint.to_owned()],
            credentials: self.folder().as_deref().map(Credentials::in_folder),
            insecure: self.insecure,
            ..Access::default()
        };
        several(&self.listen()).map(access).collect()
    }

    /// How long to wait for a worker.
    pub(super) fn patience(&self) -> Result<Duration> {
        duration(WAIT, self.wait.unwrap_or(WAIT_S))
    }

    /// The text of the file, if its settings are valid here.
    pub(super) fn text(&self) -> Result<String> {
        self.accesses().iter().try_for_each(Access::check)?;
        let (listen, folder) = (self.listen(), self.folder());
        let quoted = |text: &str| format!("\"{}\"", text.escape_default());
        let line = |name: &str, value: Option<String>, default: &str, what: &str| {
            let begin = if value.is_some() { "" } else { "// " };
            let value = value.unwrap_or_else(|| default.to_owned());
            format!("    // {what}\n    {begin}{name}: {value},\n")
        };
        let folder = folder.map(|folder| quoted(&folder.to_string_lossy()));
        let worker = self.worker.as_deref().map(quoted);
        Ok([
            "// How workers are reached: Zenoh's own settings, and ours under cosim. The environment\n\
             // overrides this file: COSIM_REMOTE_LISTEN, COSIM_REMOTE_WAIT, ...; COSIM_REMOTE_CONFIG\n\
             // names another file. Paths are relative to this one.\n{\n  cosim: {\n"
                .to_owned(),
            line("listen", Some(quoted(&listen)), "", "Where workers connect: the first free endpoint."),
            line("credentials", folder, "\"keys/orchestrator\"", "Certificates, for tls/HOST:PORT."),
            line(
                "insecure",
                self.insecure.then(|| "true".to_owned()),
                "false",
                "Whether an endpoint on another machine needs no TLS.",
            ),
            line("worker", worker, "\"left\"", "The worker that computes it, if it is connected."),
            line("wait", self.wait.map(|s| format!("{s:?}")), "10.0", "Seconds to wait for a worker."),
            line(
                "deadline",
                self.deadline.map(|s| format!("{s:?}")),
                "5.0",
                "Seconds that an answer may take, or 100 times the longest so far.",
            ),
            line(
                "save_every",
                self.save_every.map(|n| n.to_string()),
                "50",
                "The state is saved after this many steps; 0: never.",
            ),
            "  },\n}\n".to_owned(),
        ]
        .concat())
    }
}

impl Reached {
    /// Settings from the resources and the environment.
    pub fn of(resources: &Path) -> Result<Self> {
        let file = said(FILE)?.map_or_else(|| resources.join(CONNECTION), PathBuf::from);
        let Ours { listen, credentials, insecure, worker, wait, deadline, save_every, .. } =
            Configuration::read(&file)?.ours;
        let listen = said(LISTEN)?.or(listen).unwrap_or(DEFAULT_ENDPOINT.to_owned());
        let credentials = said(CREDENTIALS)?.map(PathBuf::from).or(credentials);
        let access = |endpoint: &str| Access {
            endpoints: vec![endpoint.to_owned()],
            configuration: Some(file.clone()),
            credentials: credentials.as_deref().map(Credentials::in_folder),
            insecure,
        };
        let save_every = number(SAVE_EVERY)?.or(save_every).unwrap_or(SAVED_EVERY);
        let seconds = |name, filed: Option<f64>, default| -> Result<Duration> {
            duration(name, number(name)?.or(filed).unwrap_or(default))
        };
        Ok(Self {
            accesses: several(&listen).map(access).collect(),
            worker: said(WORKER)?.or(worker),
            wait: seconds(WAIT, wait, WAIT_S)?,
            deadline: seconds(DEADLINE, deadline, DEADLINE_S)?,
            save_every: Some(save_every).filter(|every| *every > 0),
        })
    }
}

fn duration(name: &str, seconds: f64) -> Result<Duration> {
    Duration::try_from_secs_f64(seconds)
        .map_err(|why| Error::new(Code::Configuration, format!("{name} is {seconds} s")).why(why))
}

/// An environment variable that is not empty.
fn said(name: &str) -> Result<Option<String>> {
    match env::var(name) {
        Ok(text) => Ok(Some(text).filter(|text| !text.is_empty())),
        Err(env::VarError::NotPresent) => Ok(None),
        Err(why) => Err(Error::new(Code::Configuration, name).why(why)),
    }
}

fn number<T: std::str::FromStr>(name: &str) -> Result<Option<T>> {
    let Some(text) = said(name)? else {
        return Ok(None);
    };
    text.trim().parse().map(Some).map_err(|_| {
        Error::new(Code::Configuration, format!("{name} is '{text}'"))
            .why("that is not a valid number")
    })
}
