//! Certificates and keys as PEM files, checked before Zenoh sees them: Zenoh reports every problem
//! with them only as a failed connection.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use rustls::RootCertStore;
use rustls::crypto::{CryptoProvider, ring};
use rustls::pki_types::pem::{self, PemObject};
use rustls::pki_types::{CertificateDer, PrivateKeyDer, UnixTime};
use rustls::server::WebPkiClientVerifier;
use rustls::sign::CertifiedKey;
use x509_parser::prelude::{ASN1Time, FromDer, X509Certificate};

use cosim_base::error::{Code, Error, Result};

/// Files in PEM format.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Credentials {
    /// The authority that both sides trust.
    pub authority: PathBuf,
    /// Our certificate.
    pub certificate: PathBuf,
    /// Its private key.
    pub key: PathBuf,
    /// Who may do what, for the listening side; if absent, every certificate of the authority may
    /// do everything.
    pub members: PathBuf,
}

/// The contents of the files, checked for consistency.
pub(crate) struct Checked {
    pub(crate) roots: Arc<RootCertStore>,
    pub(crate) chain: Vec<CertificateDer<'static>>,
    pub(crate) key: PrivateKeyDer<'static>,
    /// The common name of the certificate, by which the other side knows us.
    pub(crate) name: String,
}

/// The cryptography provider that Zenoh uses as well.
pub(crate) fn provider() -> Arc<CryptoProvider> {
    Arc::new(ring::default_provider())
}

impl Credentials {
    /// The files `ca.pem`, `cert.pem` and `key.pem` of a folder.
    pub fn in_folder(folder: &Path) -> Self {
        let file = |name: &str| folder.join(name);
        Self {
            authority: file("ca.pem"),
            certificate: file("cert.pem"),
            key: file("key.pem"),
            members: file("members.json"),
        }
    }

    /// The files that a member needs to connect.
    pub(crate) fn own(&self) -> [&PathBuf; 3] {
        [&self.authority, &self.certificate, &self.key]
    }

    /// The settings of Zenoh for mutual TLS with these files.
    pub(crate) fn entries(&self) -> Result<Vec<(&'static str, String)>> {
        let path = |file: &PathBuf| {
            serde_json::to_string(file)
                .map_err(|why| wrong("its name is not valid UTF-8", file).why(why))
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

    /// Reads the files and checks whether a peer that trusts the same authority would accept them
    /// now.
    pub(crate) fn check(&self) -> Result<Checked> {
        let mut roots = RootCertStore::empty();
        for root in certificates(&self.authority)? {
            dates(&root, &self.authority, "the authority's certificate")?;
            roots.add(root).map_err(|why| {
                wrong("the authority's certificate cannot be used", &self.authority).why(why)
            })?;
        }
        let chain = certificates(&self.certificate)?;
        let name = dates(&chain[0], &self.certificate, "the certificate")?;
        let key = PrivateKeyDer::from_pem_slice(&read(&self.key)?)
            .map_err(|why| wrong("it contains no private key", &self.key).why(text(&why)))?;
        CertifiedKey::from_der(chain.clone(), key.clone_key(), &provider()).map_err(|why| {
            let what =
                format!("the key does not match the certificate {}", self.certificate.display());
            wrong(what, &self.key).why(why).help("use both from the same folder of cosim keys")
        })?;
        let roots = Arc::new(roots);
        let judge = WebPkiClientVerifier::builder_with_provider(roots.clone(), provider());
        let judge = judge.build().map_err(|why| {
            wrong("the authority's certificate cannot be used", &self.authority).why(why)
        })?;
        judge.verify_client_cert(&chain[0], &chain[1..], now()).map_err(|why| {
            let authority = self.authority.display();
            wrong(
                format!("the certificate was not issued by the authority {authority}"),
                &self.certificate,
            )
            .why(why)
            .help("use all files from the same folder of cosim keys")
        })?;
        Ok(Checked { roots, chain, key, name })
    }
}

fn now() -> UnixTime {
    UnixTime::since_unix_epoch(since_epoch())
}

fn since_epoch() -> Duration {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default()
}

fn read(file: &Path) -> Result<Vec<u8>> {
    cosim_base::files::read_input(file).map_err(|why| match why.kind() {
        std::io::ErrorKind::NotFound => {
            wrong("a certificate or key is missing", file).help("cosim keys FOLDER makes a set")
        }
        _ => wrong("a certificate or key cannot be read", file).why(why),
    })
}

fn certificates(file: &Path) -> Result<Vec<CertificateDer<'static>>> {
    let bytes = read(file)?;
    let all = CertificateDer::pem_slice_iter(&bytes).collect::<std::result::Result<Vec<_>, _>>();
    let all = all.map_err(|why| wrong("it is not in PEM format", file).why(text(&why)))?;
    if all.is_empty() {
        return Err(wrong("it contains no certificate", file)
            .why("it has no part that begins with -----BEGIN CERTIFICATE-----"));
    }
    Ok(all)
}

fn text(why: &pem::Error) -> String {
    match why {
        pem::Error::NoItemsFound => "it has no such part in PEM format".to_owned(),
        other => other.to_string(),
    }
}

/// Refuses a certificate that is not valid now; returns its common name.
fn dates(certificate: &CertificateDer<'_>, file: &Path, what: &str) -> Result<String> {
    let (_, parsed) = X509Certificate::from_der(certificate)
        .map_err(|why| wrong(format!("{what} cannot be understood"), file).why(why))?;
    let (validity, now) = (parsed.validity(), since_epoch().as_secs() as i64);
    let date = |time: ASN1Time| time.to_string();
    if now > validity.not_after.timestamp() {
        return Err(wrong(format!("{what} has expired"), file)
            .why(format!("it was valid until {}", date(validity.not_after)))
            .help("make new ones: cosim keys FOLDER"));
    }
    if now < validity.not_before.timestamp() {
        return Err(wrong(format!("{what} is not valid yet"), file)
            .why(format!("it is valid from {}", date(validity.not_before)))
            .help("is this machine's clock right?"));
    }
    let name = parsed.subject().iter_common_name().next().and_then(|name| name.as_str().ok());
    Ok(name.unwrap_or_default().to_owned())
}

fn wrong(what: impl Into<String>, file: &Path) -> Error {
    Error::new(Code::Certificate, what).at(file)
}
