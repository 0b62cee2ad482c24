//! A certificate authority of one's own for a test bench or a laboratory: a folder with the
//! authority, and a folder for each member with what that member needs.
//!
//! ```text
//! keys/authority/     ca.pem, ca.key.pem     stays with whoever makes certificates
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
use crate::digest::sha256;
use crate::error::{Code, Error, Result};

/// The folder of the side that others dial, and its name.
const ORCHESTRATOR: &str = "orchestrator";
const AUTHORITY: &str = "authority";
/// Clocks of machines may differ by so much.
const TOLERANCE: Duration = Duration::hours(1);

/// What is to be made.
#[derive(Debug, Clone)]
pub struct Authority {
    /// Where.
    pub folder: PathBuf,
    /// Names of workers.
    pub workers: Vec<String>,
    /// Names of observers.
    pub observers: Vec<String>,
    /// Names and addresses of the orchestrator's machine, besides those of every machine itself.
    pub hosts: Vec<String>,
    /// How many days from now the certificates are valid.
    pub days: u32,
}

impl Authority {
    /// Makes all; gives the folders of the members.
    pub fn make(&self) -> Result<Vec<PathBuf>> {
        self.check_names()?;
        let taken = std::fs::read_dir(&self.folder).is_ok_and(|mut there| there.next().is_some());
        if taken {
            return Err(Error::new(Code::Output, "the folder for the keys is not empty")
                .at(&self.folder)
                .why("keys are never overwritten: what trusts them would stop to work")
                .help("name another folder, or remove this one"));
        }
        let key = KeyPair::generate().map_err(unmade)?;
        // Two authorities of one name would be taken for each other until a signature fails.
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

    /// Names become folders, parts of keys, and names in certificates.
    fn check_names(&self) -> Result<()> {
        let mut seen = vec![AUTHORITY, ORCHESTRATOR];
        for name in self.workers.iter().chain(&self.observers) {
            let good = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
            if name.is_empty() || name.starts_with('.') || !name.chars().all(good) {
                return Err(Error::new(Code::Usage, format!("'{name}' is no name for a member"))
                    .why("a name has letters, digits, '-', '_' and '.'"));
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
            Error::new(Code::Usage, format!("'{host}' is no name of a machine")).why(why)
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
