//! Opens Zenoh sessions that only the intended peers can reach.
//!
//! There is no scouting, and nothing listens except on the endpoints named here. An endpoint on
//! another machine requires TLS, unless that is explicitly waived.

use std::path::PathBuf;

use zenoh::{Config, Session, Wait};

use super::configuration::Configuration;
use super::credentials::{Checked, Credentials};
use super::diagnose::{self, silence};
use super::endpoint::Endpoint;
#[cfg(unix)]
use super::linger;
use super::members::Members;
use super::{rights, runtime};
use cosim_base::error::{Code, Error, Result};

/// Where and how to open a session.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Access {
    /// Endpoints such as `tcp/127.0.0.1:7447`, `tls/host:7447`, `unixsock-stream//run/x.sock`.
    pub endpoints: Vec<String>,
    /// A file with Zenoh's configuration (json5), which the settings here override.
    pub configuration: Option<PathBuf>,
    /// Certificates for TLS.
    pub credentials: Option<Credentials>,
    /// An endpoint of another machine needs no TLS.
    pub insecure: bool,
}

/// Where the coordinator listens by default.
pub const DEFAULT_ENDPOINT: &str = "tcp/127.0.0.1:7447";

impl Access {
    /// A session that others connect to.
    pub fn listen(&self) -> Result<Session> {
        self.open(&LISTENING)
    }

    /// A session that connects to a listening one, and reconnects when the connection is lost.
    pub fn dial(&self) -> Result<Session> {
        let checked = self.checked()?;
        let refusals = self.endpoints.iter().map(|e| diagnose::refusal(e, checked.as_ref()));
        match refusals.flatten().next() {
            Some(refusal) => Err(refusal),
            None => self.dial_known(),
        }
    }

    /// The same, to a peer that has accepted us before: no diagnosis first.
    pub(crate) fn dial_known(&self) -> Result<Session> {
        self.open(&DIALLING)
    }

    /// The same twice, for small messages and for large ones: see `channels`.
    pub(crate) fn dial_channels(&self) -> Result<[Session; 2]> {
        let bulk = self.dial_known()?;
        let quick = if self.is_tls()? { bulk.clone() } else { self.open(&QUICK)? };
        Ok([quick, bulk])
    }

    /// Nothing listens at any of the endpoints.
    pub(crate) fn has_no_listener(&self) -> bool {
        self.endpoints.iter().all(|endpoint| diagnose::has_no_listener(endpoint))
    }

    /// Refuses what opening a session would refuse, as far as it is known in advance.
    pub fn check(&self) -> Result<()> {
        self.checked()?;
        self.config(&DIALLING, None).map(drop)
    }

    /// Whether an endpoint uses TLS. Refuses endpoints that are open to others.
    fn is_tls(&self) -> Result<bool> {
        let mut tls = false;
        for endpoint in &self.endpoints {
            tls |= matches!(Endpoint::permit(endpoint, self.insecure)?, Endpoint::Tls(..));
        }
        Ok(tls)
    }

    /// Refuses endpoints that are open to others, and credentials that no peer would accept.
    fn checked(&self) -> Result<Option<Checked>> {
        let tls = self.is_tls()?;
        match &self.credentials {
            Some(credentials) if tls => credentials.check().map(Some),
            None if tls => Err(Error::new(Code::Session, "TLS needs certificates")
                .why(format!("the endpoint is {}", self.endpoints.join(", ")))
                .help("--credentials FOLDER; cosim keys FOLDER makes some")),
            _ => Ok(None),
        }
    }

    fn open(&self, side: &Side) -> Result<Session> {
        let tls = self.checked()?.is_some();
        if tls {
            runtime::is_one_thread()?;
        }
        let members = match &self.credentials {
            Some(credentials) if tls && side.listens => Members::read(&credentials.members)?,
            _ => None,
        };
        let config = self.config(side, members.as_ref())?;
        #[cfg(unix)]
        if side.listens {
            self.endpoints.iter().filter_map(|endpoint| port(endpoint)).for_each(linger::forbid);
        }
        let session = zenoh::open(config).wait().map_err(|why| self.unopened(side, &why))?;
        if let Some(members) = members {
            rights::answer(&session, members)?;
        }
        Ok(session)
    }

    fn config(&self, side: &Side, members: Option<&Members>) -> Result<Config> {
        let mut config = match &self.configuration {
            Some(file) => Configuration::read(file)?.zenoh(file)?,
            None => Config::default(),
        };
        let list = serde_json::to_string(&self.endpoints).map_err(|why| unopened().why(why))?;
        let (mode, endpoints) = match side.listens {
            true => ("\"router\"", "listen/endpoints"),
            false => ("\"client\"", "connect/endpoints"),
        };
        // It sends in any thread, and TLS can only do so in one: see `runtime`.
        let quick = side.quick && !self.is_tls()?;
        let mut entries = vec![
            ("mode", mode.to_owned()),
            ("scouting/multicast/enabled", "false".to_owned()),
            ("scouting/gossip/enabled", "false".to_owned()),
            // Nothing can be found: a session that listens would wait half a second.
            ("scouting/delay", "0".to_owned()),
            ("adminspace/enabled", "false".to_owned()),
            ("listen/endpoints", "[]".to_owned()),
            ("connect/endpoints", "[]".to_owned()),
            (endpoints, list),
            ("connect/timeout_ms", "5000".to_owned()),
            ("connect/exit_on_failure", "true".to_owned()),
            ("connect/retry", RETRY.to_owned()),
            ("transport/link/tx/lease", "1000".to_owned()),
            // Both sides must offer it; a session that does has no message priorities.
            ("transport/unicast/lowlatency", quick.to_string()),
            ("transport/unicast/qos/enabled", (!quick).to_string()),
            // The buffers are large enough for everything on this channel: see `channels`.
            ("transport/link/tx/batch_size", u16::MAX.to_string()),
            // For telemetry, nothing else may be dropped: see `telemetry`.
            ("transport/link/tx/queue/size/data", "16".to_owned()),
            (
                "transport/link/tx/queue/congestion_control/drop/wait_before_drop",
                "100000".to_owned(),
            ),
            ("transport/shared_memory/enabled", "false".to_owned()),
            // Nothing here uses wall-clock timestamps, and every message would be stamped twice.
            ("timestamping/enabled", "false".to_owned()),
        ];
        if let Some(credentials) = &self.credentials {
            entries.extend(credentials.entries()?);
        }
        if let Some(members) = members {
            entries.push(("access_control", members.access_control().to_string()));
        }
        for (key, value) in entries {
            config.insert_json5(key, &value).map_err(|why| {
                unopened().why(format!("the setting {key} = {value} is not accepted: {why}"))
            })?;
        }
        Ok(config)
    }

    /// The name by which the other side knows us, if it does.
    pub(crate) fn common_name(&self) -> Option<String> {
        self.checked().ok().flatten().map(|checked| checked.name)
    }

    fn unopened(&self, side: &Side, why: &zenoh::Error) -> Error {
        let error = unopened();
        let seen = self.endpoints.iter().filter(|_| !side.listens).find_map(|e| silence(e));
        match seen {
            Some(seen) => error.why(seen).help("cosim run --distributed listens there"),
            None => error
                .why(format!("{}: {why}", self.endpoints.join(", ")))
                .help("is it an address of this machine, and is it free?"),
        }
    }
}

#[cfg(unix)]
fn port(endpoint: &str) -> Option<u16> {
    match Endpoint::parse(endpoint) {
        Ok(Endpoint::Tcp(_, port) | Endpoint::Tls(_, port)) => Some(port),
        _ => None,
    }
}

/// What a session is for.
struct Side {
    listens: bool,
    /// It offers the low-latency transport.
    quick: bool,
}

const LISTENING: Side = Side { listens: true, quick: true };
const DIALLING: Side = Side { listens: false, quick: false };
const QUICK: Side = Side { listens: false, quick: true };

/// Frequently at first, then less often: a worker may wait long for its coordinator.
const RETRY: &str = "{period_init_ms:50,period_max_ms:1000,period_increase_factor:1.5}";

fn unopened() -> Error {
    Error::new(Code::Session, "no Zenoh session could be opened")
}
