//! Configuration files: Zenoh's own json5, with our settings under `cosim`.
//!
//! ```json5
//! {
//!   transport: { link: { tx: { keep_alive: 4 } } },   // any setting of Zenoh
//!   cosim: { connect: "tls/10.0.0.1:7447", credentials: "keys/left", allow: ["fmus/"] },
//! }
//! ```
//!
//! The command line takes precedence, and what is refused there is refused here.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::Value;
use zenoh::Config;

use cosim_base::error::{Code, Error, Result};
use cosim_base::names::did_you_mean;
use cosim_base::{MOST, is_too_deep};

/// The contents of a file.
pub struct Configuration {
    zenoh: Value,
    /// Our settings.
    pub ours: Ours,
}

/// Settings under `cosim`; paths are relative to the folder of the file.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct Ours {
    /// Where a run listens; a remote FMU takes the first free one of several, separated by commas.
    pub listen: Option<String>,
    /// Where a worker or an observer connects.
    pub connect: Option<String>,
    /// The folder with certificates.
    pub credentials: Option<PathBuf>,
    /// An endpoint of another machine needs no TLS.
    pub insecure: bool,
    /// A worker's name.
    pub name: Option<String>,
    /// The FMUs that a worker loads.
    pub allow: Vec<String>,
    /// A worker loads every FMU that a run sends.
    pub allow_upload: bool,
    /// A worker's FMUs are not confined.
    pub no_confine: bool,
    /// The worker that computes a remote FMU, if it is connected.
    pub worker: Option<String>,
    /// How long a remote FMU waits for a worker, in seconds.
    pub wait: Option<f64>,
    /// How long its answer may take, in seconds.
    pub deadline: Option<f64>,
    /// The state is saved after this many steps; 0: never.
    pub save_every: Option<u64>,
}

/// The settings known under `cosim`.
const KEYS: [&str; 12] = [
    "listen",
    "connect",
    "credentials",
    "insecure",
    "name",
    "allow",
    "allow_upload",
    "no_confine",
    "worker",
    "wait",
    "deadline",
    "save_every",
];

impl Configuration {
    /// Reads a file.
    pub fn read(file: &Path) -> Result<Self> {
        let text = cosim_base::files::read_input_text(file)
            .map_err(|why| wrong(file, "the configuration cannot be read").why(why))?;
        if is_too_deep(&text) {
            return Err(wrong(file, "the configuration is not json5")
                .why(format!("its brackets have more than {} levels", MOST)));
        }
        let mut zenoh: Value = json5::from_str(&text)
            .map_err(|why| wrong(file, "the configuration is not json5").why(why))?;
        let Some(settings) = zenoh.as_object_mut() else {
            return Err(
                wrong(file, "the configuration is not json5").why("it is not an object {...}")
            );
        };
        let ours = match settings.remove("cosim") {
            Some(ours) => ours_of(file, ours)?,
            None => Ours::default(),
        };
        for place in ["multicast", "gossip"] {
            if zenoh.pointer(&format!("/scouting/{place}/enabled")) == Some(&Value::Bool(true)) {
                return Err(wrong(file, format!("scouting by {place} is refused"))
                    .why("it would announce this process to the whole network and join others")
                    .help("name the endpoints"));
            }
        }
        for what in ["listen", "connect"] {
            if zenoh.get(what).is_some_and(|said| said.get("endpoints").is_some()) {
                return Err(wrong(file, format!("{what}/endpoints cannot be set here"))
                    .help(format!("set it as cosim: {{ {what}: \"tls/HOST:PORT\" }}")));
            }
        }
        if zenoh.pointer("/transport/link/tls").is_some() {
            return Err(wrong(file, "transport/link/tls cannot be set here")
                .why("certificates are checked before they are used")
                .help("set it as cosim: { credentials: \"FOLDER\" }"));
        }
        let configuration = Self { zenoh, ours };
        configuration.zenoh(file)?;
        Ok(configuration)
    }

    /// The settings passed to Zenoh.
    pub(crate) fn zenoh(&self, file: &Path) -> Result<Config> {
        Config::from_json5(&self.zenoh.to_string())
            .map_err(|why| wrong(file, "Zenoh does not accept this configuration").why(why))
    }
}

fn ours_of(file: &Path, value: Value) -> Result<Ours> {
    let Some(said) = value.as_object() else {
        return Err(wrong(file, "the value of cosim is not an object {...}"));
    };
    if let Some(key) = said.keys().find(|key| !KEYS.contains(&key.as_str())) {
        return Err(wrong(file, format!("there is no setting 'cosim/{key}'"))
            .why(format!("there are: {}", KEYS.join(", ")))
            .maybe_help(did_you_mean(key, KEYS)));
    }
    let mut ours: Ours = serde_json::from_value(value)
        .map_err(|why| wrong(file, "a setting under cosim has the wrong type").why(why))?;
    let folder = file.parent().unwrap_or(Path::new(""));
    ours.credentials = ours.credentials.map(|path| folder.join(path));
    for allowed in &mut ours.allow {
        if !super::allowed::is_hash(allowed) {
            *allowed = folder.join(&*allowed).to_string_lossy().into_owned();
        }
    }
    Ok(ours)
}

fn wrong(file: &Path, what: impl Into<String>) -> Error {
    Error::new(Code::Configuration, what).at(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Ours> {
        let folder = tempfile::TempDir::new().unwrap();
        let file = folder.path().join("c.json5");
        std::fs::write(&file, text).unwrap();
        let mut ours = Configuration::read(&file)?.ours;
        ours.credentials =
            ours.credentials.map(|path| path.strip_prefix(folder.path()).unwrap().to_owned());
        Ok(ours)
    }

    #[test]
    fn ours_and_zenohs_stand_side_by_side() {
        let ours = read(
            "{ // a comment\n transport: { link: { tx: { keep_alive: 4 } } },\n\
             cosim: { connect: 'tcp/127.0.0.1:1', credentials: 'keys/left', allow_upload: true } }",
        );
        let wanted = Ours {
            connect: Some("tcp/127.0.0.1:1".to_owned()),
            credentials: Some("keys/left".into()),
            allow_upload: true,
            ..Ours::default()
        };
        assert_eq!(ours.unwrap(), wanted);
        assert_eq!(read("{}").unwrap(), Ours::default());
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, part) in [
            ("{ cosim: { alow: ['x'] } }", "did you mean 'allow'?"),
            ("{ cosim: { insecure: 'yes' } }", "wrong type"),
            ("{ cosim: 1 }", "not an object"),
            ("[1]", "not an object"),
            ("{ cosim: { ", "not json5"),
            ("{ transprot: {} }", "Zenoh does not accept"),
            ("{ scouting: { multicast: { enabled: true } } }", "scouting by multicast"),
            ("{ scouting: { gossip: { enabled: true } } }", "scouting by gossip"),
            ("{ listen: { endpoints: ['tcp/0.0.0.0:1'] } }", "cosim: { listen:"),
            ("{ transport: { link: { tls: { enable_mtls: false } } } }", "credentials"),
        ] {
            let error = read(text).unwrap_err();
            assert_eq!(error.code(), Code::Configuration, "{text}");
            assert!(error.to_string().contains(part), "{text}: {error}");
        }
    }
}
