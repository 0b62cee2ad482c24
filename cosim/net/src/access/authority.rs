//! A private certificate authority for a test bench or a laboratory: a folder with the authority,
//! and a folder for each member with the files that it needs.
//!
//! ```text
//! keys/authority/     ca.pem, ca.key.pem     stays with the person who makes certificates
//! keys/orchestrator/  ca.pem, cert.pem, key.pem, members.json
//! keys/left/          ca.pem, cert.pem, key.pem
//! ```

use std::io::Write;
use std::net::IpAddr;
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use rcgen::{
    BasicConstraints, CertificateParams, DistinguishedName, DnType, ExtendedKeyUsagePurpose, IsCa,
    Issuer, KeyPair, KeyUsagePurpose, SanType,
};
use time::{Duration, OffsetDateTime};

use super::members::Members;
use cosim_base::error::{Code, Error, Result};
use cosim_base::sha256;

/// The folder and name of the side that others connect to.
const ORCHESTRATOR: &str = "orchestrator";
const AUTHORITY: &str = "authority";
/// How much the clocks of the machines may differ.
const TOLERANCE: Duration = Duration::hours(1);

/// The certificates to make.
#[derive(Debug, Clone)]
pub struct Authority {
    /// The folder for all of them.
    pub folder: PathBuf,
    /// Names of workers.
    pub workers: Vec<String>,
    /// Names of observers.
    pub observers: Vec<String>,
    /// Host names and addresses of the orchestrator's machine, besides the local ones.
    pub hosts: Vec<String>,
    /// Days from now for which the certificates are valid.
    pub days: u32,
}

impl Authority {
    /// Makes all certificates; returns the folders of the members.
    pub fn make(&self) -> Result<Vec<PathBuf>> {
        self.check_names()?;
        let taken = std::fs::read_dir(&self.folder).is_ok_and(|mut there| there.next().is_some());
        if taken {
            return Err(Error::new(Code::Output, "the folder for the keys is not empty")
                .at(&self.folder)
                .why("keys are never overwritten: everything that trusts them would stop working")
                .help("name another folder, or remove this one"));
        }
        let key = KeyPair::generate().map_err(unmade)?;
        // Two authorities of the same name would be mistaken for each other until a signature
        // fails.
        let number = sha256(key.public_key_raw());
        let mut params = self.params(&format!("cosim authority {}", &number[..8]))?;
        params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
        params.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
        let root = params.self_signed(&key).map_err(unmade)?.pem();
        let place = self.make_folder(AUTHORITY)?;
        write(&place.join("ca.pem"), &root)?;
        write(&place.join("ca.key.pem"), &key.serialize_pem())?;

        let issuer = Issuer::new(params, key);
        let mut folders = vec![self.member(ORCHESTRATOR, &root, &issuer)?];
        for name in self.workers.iter().chain(&self.observers) {
            folders.push(self.member(name, &root, &issuer)?);
        }
        let members = Members {
            orchestrators: vec![ORCHESTRATOR.to_owned()],
            workers: self.workers.clone(),
            observers: self.observers.clone(),
        };
        let text = serde_json::to_string_pretty(&members).map_err(unmade)?;
        write(&folders[0].join("members.json"), &text)?;
        Ok(folders)
    }

    /// Names become folder names, parts of keys, and names in certificates.
    fn check_names(&self) -> Result<()> {
        let mut seen = vec![AUTHORITY, ORCHESTRATOR];
        for name in self.workers.iter().chain(&self.observers) {
            let good = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
            if name.is_empty() || name.starts_with('.') || !name.chars().all(good) {
                return Err(Error::new(
                    Code::Usage,
                    format!("'{name}' is not a valid name for a member"),
                )
                .why("a name consists of letters, digits, '-', '_' and '.'"));
            }
            if seen.contains(&name.as_str()) {
                return Err(Error::new(Code::Usage, format!("the name '{name}' is taken")));
            }
            seen.push(name);
        }
        Ok(())
    }

    fn params(&self, name: &str) -> Result<CertificateParams> {
        let mut params = CertificateParams::default();
        let now = OffsetDateTime::now_utc();
        params.not_before = now - TOLERANCE;
        params.not_after = now + Duration::days(i64::from(self.days));
        params.distinguished_name = DistinguishedName::new();
        params.distinguished_name.push(DnType::CommonName, name);
        Ok(params)
    }

    fn member(&self, name: &str, root: &str, issuer: &Issuer<'_, KeyPair>) -> Result<PathBuf> {
        let key = KeyPair::generate().map_err(unmade)?;
        let mut params = self.params(name)?;
        params.use_authority_key_identifier_extension = true;
        params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
        let both = [ExtendedKeyUsagePurpose::ClientAuth, ExtendedKeyUsagePurpose::ServerAuth];
        params.extended_key_usages = both.to_vec();
        let hosts = self.hosts.iter().map(String::as_str).filter(|_| name == ORCHESTRATOR);
        let own = ["localhost", "127.0.0.1", "::1"];
        params.subject_alt_names =
            own.into_iter().chain(hosts).map(alternative).collect::<Result<_>>()?;
        let certificate = params.signed_by(&key, issuer).map_err(unmade)?;
        let place = self.make_folder(name)?;
        write(&place.join("ca.pem"), root)?;
        write(&place.join("cert.pem"), &certificate.pem())?;
        write(&place.join("key.pem"), &key.serialize_pem())?;
        Ok(place)
    }

    fn make_folder(&self, name: &str) -> Result<PathBuf> {
        let folder = self.folder.join(name);
        let made = std::fs::DirBuilder::new().recursive(true).mode(0o700).create(&folder);
        made.map_err(|why| unmade(why).at(&folder))?;
        Ok(folder)
    }
}

fn alternative(host: &str) -> Result<SanType> {
    Ok(match host.parse::<IpAddr>() {
        Ok(address) => SanType::IpAddress(address),
        Err(_) => SanType::DnsName(host.try_into().map_err(|why| {
            Error::new(Code::Usage, format!("'{host}' is not a host name")).why(why)
        })?),
    })
}

fn write(file: &Path, text: &str) -> Result<()> {
    let opened = std::fs::OpenOptions::new().write(true).create_new(true).mode(0o600).open(file);
    let written = opened.and_then(|mut opened| opened.write_all(text.as_bytes()));
    written.map_err(|why| unmade(why).at(file))
}

fn unmade(why: impl std::fmt::Display) -> Error {
    Error::new(Code::Output, "the keys could not be made").why(why)
}
