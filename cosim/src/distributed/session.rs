//! Opening Zenoh sessions, closed to everybody who is not meant.
//!
//! Nothing is found by scouting and nothing listens but on the endpoints named here. An endpoint
//! that is not of this machine needs TLS, unless that is waived in so many words.

use std::net::{IpAddr, ToSocketAddrs};
use std::path::PathBuf;

use zenoh::{Config, Session, Wait};

use crate::error::{Code, Error, Result};

/// Where and how to open a session.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Access {
    /// Endpoints such as `tcp/127.0.0.1:7447`, `tls/host:7447`, `unixsock-stream//run/x.sock`.
    pub endpoints: Vec<String>,
    /// A file with Zenoh's configuration (json5), under what is set here.
    pub configuration: Option<PathBuf>,
    /// Certificates for TLS.
    pub credentials: Option<Credentials>,
    /// An endpoint of another machine needs no TLS.
    pub insecure: bool,
}

/// Files in PEM form.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Credentials {
    /// The authority that both sides trust.
    pub authority: PathBuf,
    /// Our certificate.
    pub certificate: PathBuf,
    /// Its private key.
    pub key: PathBuf,
}

/// Where the coordinator listens when nothing else is said.
pub const DEFAULT_ENDPOINT: &str = "tcp/127.0.0.1:7447";

impl Access {
    /// A session that others dial.
    pub fn listen(&self) -> Result<Session> {
        self.open("router", "listen/endpoints")
    }

    /// A session that dials a listening one, and does so again when it is cut off.
    pub fn dial(&self) -> Result<Session> {
        self.open("client", "connect/endpoints")
    }

    fn open(&self, mode: &str, endpoints: &str) -> Result<Session> {
        self.endpoints.iter().try_for_each(|endpoint| self.permit(endpoint))?;
        let mut config = match &self.configuration {
            Some(file) => Config::from_file(file).map_err(|why| {
                Error::new(Code::Session, "the Zenoh configuration cannot be used")
                    .at(file)
                    .why(why)
            })?,
            None => Config::default(),
        };
        let list = serde_json::to_string(&self.endpoints).map_err(|why| unopened().why(why))?;
        let mut entries = vec![
            ("mode", format!("\"{mode}\"")),
            ("scouting/multicast/enabled", "false".to_owned()),
            ("scouting/gossip/enabled", "false".to_owned()),
            ("listen/endpoints", "[]".to_owned()),
            ("connect/endpoints", "[]".to_owned()),
            (endpoints, list),
            ("connect/timeout_ms", "5000".to_owned()),
            ("connect/exit_on_failure", "true".to_owned()),
            ("connect/retry", RETRY.to_owned()),
            ("transport/link/tx/lease", "1000".to_owned()),
            ("transport/shared_memory/enabled", "false".to_owned()),
        ];
        if let Some(credentials) = &self.credentials {
            entries.extend(credentials.entries()?);
        }
        for (key, value) in entries {
            config.insert_json5(key, &value).map_err(|why| {
                unopened().why(format!("the setting {key} = {value} is not accepted: {why}"))
            })?;
        }
        zenoh::open(config).wait().map_err(|why| {
            unopened()
                .why(format!("{}: {why}", self.endpoints.join(", ")))
                .help("is the address right and free, does the other side run, do both use TLS?")
        })
    }

    /// Refuses what would be open to others.
    fn permit(&self, endpoint: &str) -> Result<()> {
        let refused = |why: &str| {
            Err(Error::new(Code::Session, format!("the endpoint {endpoint} is refused")).why(why))
        };
        let Some((protocol, address)) = endpoint.split_once('/') else {
            return refused("an endpoint is a protocol and an address: tcp/127.0.0.1:7447");
        };
        match protocol {
            "unixsock-stream" => Ok(()),
            "tls" if self.credentials.is_none() => {
                refused("TLS needs certificates: --credentials FOLDER")
            }
            "tls" => Ok(()),
            "tcp" if self.insecure || is_loopback(address) => Ok(()),
            "tcp" => match refused("anybody who reaches it could load code into a worker") {
                Err(error) => Err(error.help("tls/... with --credentials, or --insecure")),
                ok => ok,
            },
            _ => refused("the protocols are tcp, tls and unixsock-stream"),
        }
    }
}

/// First soon, then less often: a worker may wait long for its coordinator.
const RETRY: &str = "{period_init_ms:50,period_max_ms:1000,period_increase_factor:1.5}";

impl Credentials {
    /// The files `ca.pem`, `cert.pem` and `key.pem` of a folder.
    pub fn in_folder(folder: &std::path::Path) -> Self {
        let file = |name: &str| folder.join(name);
        Self { authority: file("ca.pem"), certificate: file("cert.pem"), key: file("key.pem") }
    }

    fn entries(&self) -> Result<Vec<(&'static str, String)>> {
        let path = |file: &PathBuf| {
            if !file.is_file() {
                return Err(Error::new(Code::Session, "a certificate is missing").at(file));
            }
            serde_json::to_string(file).map_err(|why| unopened().why(why))
        };
        let (authority, certificate, key) =
            (path(&self.authority)?, path(&self.certificate)?, path(&self.key)?);
        Ok(vec![
            ("transport/link/tls/root_ca_certificate", authority),
            ("transport/link/tls/listen_certificate", certificate.clone()),
            ("transport/link/tls/listen_private_key", key.clone()),
            ("transport/link/tls/connect_certificate", certificate),
            ("transport/link/tls/connect_private_key", key),
            ("transport/link/tls/enable_mtls", "true".to_owned()),
            ("transport/link/tls/verify_name_on_connect", "true".to_owned()),
        ])
    }
}

fn is_loopback(address: &str) -> bool {
    // A name counts as what it means here; one that means nothing is not ours.
    let addresses = address.split('?').next().unwrap_or(address).to_socket_addrs();
    addresses.is_ok_and(|mut all| {
        let mut some = false;
        all.all(|address| {
            some = true;
            match address.ip() {
                IpAddr::V4(ip) => ip.is_loopback(),
                IpAddr::V6(ip) => ip.is_loopback(),
            }
        }) && some
    })
}

fn unopened() -> Error {
    Error::new(Code::Session, "no Zenoh session could be opened")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(endpoint: &str, access: &Access) -> Option<String> {
        access.permit(endpoint).err().map(|error| error.to_string())
    }

    #[test]
    fn only_this_machine_is_open_without_tls() {
        let access = Access::default();
        for own in ["tcp/127.0.0.1:7447", "tcp/[::1]:7447", "unixsock-stream//tmp/x.sock"] {
            assert_eq!(refusal(own, &access), None, "{own}");
        }
        for open in ["tcp/0.0.0.0:7447", "tcp/[::]:7447", "tcp/192.0.2.1:7447"] {
            assert!(refusal(open, &access).is_some_and(|e| e.contains("--insecure")), "{open}");
            let waived = Access { insecure: true, ..Access::default() };
            assert_eq!(refusal(open, &waived), None, "{open}");
        }
        assert!(refusal("udp/127.0.0.1:7447", &access).is_some());
        assert!(refusal("127.0.0.1:7447", &access).is_some());
        assert!(
            refusal("tls/localhost:7447", &access).is_some_and(|e| e.contains("--credentials"))
        );
    }
}
