//! Finds out why the other side cannot be reached with a TLS handshake of its own. Zenoh reports
//! every refusal only as a timeout.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::Arc;
use std::time::Duration;

use rustls::pki_types::ServerName;
use rustls::{AlertDescription, CertificateError, ClientConfig, ClientConnection};

use super::credentials::{Checked, provider};
use super::endpoint::Endpoint;
use cosim_base::error::{Code, Error, Result};

/// Longer than any handshake on a connection that can carry a run.
const PATIENCE: Duration = Duration::from_secs(2);
/// The other side checks our certificate after we have checked its own (TLS 1.3): how long to wait
/// for its refusal.
const VERDICT: Duration = Duration::from_millis(300);

/// Why `endpoint` refuses a connection. `None` if it answers as it should, and also if nothing
/// listens there, because something may do so later.
pub(crate) fn refusal(endpoint: &str, with: Option<&Checked>) -> Option<Error> {
    let Ok(Endpoint::Tls(host, port)) = Endpoint::parse(endpoint) else {
        return None;
    };
    let stream = connect(host, port).ok()?;
    handshake(endpoint, host, stream, with?).err()
}

/// Why nothing answers, as text.
pub(crate) fn silence(endpoint: &str) -> Option<String> {
    let (host, port) = match Endpoint::parse(endpoint) {
        Ok(Endpoint::Tcp(host, port) | Endpoint::Tls(host, port)) => (host, port),
        _ => return None,
    };
    match connect(host, port) {
        Ok(_) => Some(format!("{endpoint} answers, but not as cosim run does")),
        Err(why) if why.kind() == ErrorKind::ConnectionRefused => {
            Some(format!("nothing listens at {endpoint}"))
        }
        Err(why) => Some(format!("{endpoint}: {why}")),
    }
}

/// Whether nothing listens there; false for a Unix socket, for which this is unknown.
pub(crate) fn has_no_listener(endpoint: &str) -> bool {
    match Endpoint::parse(endpoint) {
        Ok(Endpoint::Tcp(host, port) | Endpoint::Tls(host, port)) => {
            connect(host, port).is_err_and(|why| why.kind() == ErrorKind::ConnectionRefused)
        }
        _ => false,
    }
}

fn connect(host: &str, port: u16) -> std::io::Result<TcpStream> {
    let mut last = std::io::Error::new(ErrorKind::NotFound, "the name has no address");
    for address in (host, port).to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, PATIENCE) {
            Ok(stream) => {
                stream.set_read_timeout(Some(PATIENCE))?;
                stream.set_write_timeout(Some(PATIENCE))?;
                return Ok(stream);
            }
            Err(why) => last = why,
        }
    }
    Err(last)
}

fn handshake(endpoint: &str, host: &str, mut stream: TcpStream, with: &Checked) -> Result<()> {
    let other = |why: String| refused(endpoint).why(why);
    let config = ClientConfig::builder_with_provider(provider())
        .with_safe_default_protocol_versions()
        .map_err(|why| other(why.to_string()))?
        .with_root_certificates(with.roots.clone())
        .with_client_auth_cert(with.chain.clone(), with.key.clone_key())
        .map_err(|why| other(why.to_string()))?;
    let name = ServerName::try_from(host.to_owned()).map_err(|why| other(why.to_string()))?;
    let mut tls =
        ClientConnection::new(Arc::new(config), name).map_err(|why| other(why.to_string()))?;
    while tls.is_handshaking() {
        tls.complete_io(&mut stream).map_err(|why| explain(endpoint, host, &why))?;
    }
    // As long as nothing arrives, nothing has been refused.
    stream.set_read_timeout(Some(VERDICT)).map_err(|why| other(why.to_string()))?;
    let mut nothing = [0; 1];
    match rustls::Stream::new(&mut tls, &mut stream).read(&mut nothing) {
        Err(why) if !matches!(why.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
            Err(explain(endpoint, host, &why))
        }
        _ => {
            tls.send_close_notify();
            // The connection ends either way.
            let _ = tls.write_tls(&mut stream).and_then(|_| stream.flush());
            Ok(())
        }
    }
}

/// What a failed handshake means.
fn explain(endpoint: &str, host: &str, why: &std::io::Error) -> Error {
    use AlertDescription as Alert;
    use rustls::Error as Tls;
    let tls = why.get_ref().and_then(|inner| inner.downcast_ref::<Tls>());
    let error = refused(endpoint);
    match tls {
        Some(Tls::InvalidCertificate(why)) => theirs(error, host, why),
        Some(Tls::AlertReceived(alert)) => match alert {
            Alert::UnknownCA | Alert::DecryptError | Alert::BadCertificate => error
                .why("it does not know the authority of our certificate")
                .help("both sides need certificates of the same authority (ca.pem)"),
            Alert::CertificateRequired => error
                .why("it requires a certificate and got none")
                .help("--credentials FOLDER with cert.pem and key.pem"),
            Alert::CertificateExpired => error
                .why("our certificate has expired by its clock")
                .help("make a new one (cosim keys), or set the clocks of both machines"),
            other => error.why(format!("it refused our certificate: {other:?}")),
        },
        Some(Tls::InvalidMessage(_)) => {
            error.why("it does not speak TLS").help("does the other side listen at tcp/...?")
        }
        Some(other) => error.why(other),
        None => error.why(format!("the handshake was cut off: {why}")),
    }
}

/// What is wrong with the other side's certificate.
fn theirs(error: Error, host: &str, why: &CertificateError) -> Error {
    use CertificateError as Wrong;
    match why {
        Wrong::UnknownIssuer | Wrong::BadSignature => error
            .why("its certificate was issued by another authority than ours")
            .help("both sides need certificates of the same authority (ca.pem)"),
        Wrong::NotValidForName => name_is_wrong(error, host, &[]),
        Wrong::NotValidForNameContext { presented, .. } => name_is_wrong(error, host, presented),
        Wrong::Expired | Wrong::ExpiredContext { .. } => {
            error.why("its certificate has expired").help("the other side needs a new one")
        }
        Wrong::NotValidYet | Wrong::NotValidYetContext { .. } => error
            .why("its certificate is not valid yet")
            .help("are the clocks of both machines right?"),
        other => error.why(format!("its certificate is not accepted: {other}")),
    }
}

fn name_is_wrong(error: Error, host: &str, presented: &[String]) -> Error {
    let names = match presented {
        [] => String::new(),
        names => format!(", but for {}", names.join(", ")),
    };
    error
        .why(format!("its certificate is not for the name {host}{names}"))
        .help(format!("connect by a name in its certificate, or: cosim keys FOLDER --host {host}"))
}

fn refused(endpoint: &str) -> Error {
    Error::new(Code::Certificate, format!("no trust between this side and {endpoint}"))
}
