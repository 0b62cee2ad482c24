//! Detached signatures of files: Ed25519 over all bytes of FILE, 64 bytes in FILE.sig. Keys are in
//! PEM format (PKCS#8, SubjectPublicKeyInfo), as read and written by OpenSSL.

use std::fs::File;
use std::io::{Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use rcgen::{KeyPair, PKCS_ED25519, SigningKey};
use ring::signature::{ED25519, UnparsedPublicKey};
use rustls::pki_types::SubjectPublicKeyInfoDer;
use rustls::pki_types::pem::PemObject;

use cosim_base::error::{Code, Error, Result};
use cosim_base::files;

/// Maximum size of a key file, bytes.
const MAX_KEY: u64 = 1 << 16;
/// Length of a signature, bytes.
const LENGTH: u64 = 64;
/// The bytes before the 32 bytes of an Ed25519 key in a SubjectPublicKeyInfo (RFC 8410, section 4).
const PREFIX: [u8; 12] = [0x30, 0x2a, 0x30, 0x05, 0x06, 0x03, 0x2b, 0x65, 0x70, 0x03, 0x21, 0x00];

/// Makes a key pair: `NAME.key`, which only its owner may read, and `NAME.pub`.
///
/// # Errors
/// `E302` if one of them cannot be written or already exists.
pub fn make(name: &Path) -> Result<[PathBuf; 2]> {
    let pair = KeyPair::generate_for(&PKCS_ED25519).map_err(|why| unmade().why(why))?;
    let paths = ["key", "pub"].map(|ending| with(name, ending));
    for (path, text, mode) in
        [(&paths[0], pair.serialize_pem(), 0o600), (&paths[1], pair.public_key_pem(), 0o644)]
    {
        let made = File::options().write(true).create_new(true).mode(mode).open(path);
        let written = made.and_then(|mut file| file.write_all(text.as_bytes()));
        written.map_err(|why| unmade().at(path).why(why))?;
    }
    Ok(paths)
}

/// Signs a file; returns the path of its signature.
///
/// # Errors
/// `E101` if the file or the key cannot be read, `E506` if that is not an Ed25519 key, `E302` if
/// the signature cannot be written.
pub fn sign(file: &Path, key: &Path) -> Result<PathBuf> {
    let text = String::from_utf8_lossy(&read(key, MAX_KEY, "the key")?).into_owned();
    let pair = KeyPair::from_pem(&text).map_err(|why| no_key(key, "private").why(why))?;
    if !pair.is_compatible(&PKCS_ED25519) {
        return Err(no_key(key, "private").why("it is of another kind"));
    }
    let bytes = read(file, u64::MAX, "the file")?;
    let beside = with(file, "sig");
    let unwritten = || Error::new(Code::Output, "the signature cannot be written").at(&beside);
    let signature = pair.sign(&bytes).map_err(|why| unwritten().why(why))?;
    files::replace(&beside, &signature).map_err(|why| unwritten().why(why))?;
    Ok(beside)
}

/// Verifies the signature beside a file.
///
/// # Errors
/// `E108` if it is missing, or by another key or for other content; `E101` if file or key cannot be
/// read, `E506` if that is not an Ed25519 key.
pub fn verify(file: &Path, key: &Path) -> Result<()> {
    verify_bytes(&read(file, u64::MAX, "the file")?, file, key)
}

/// The same with the bytes of the file.
pub(crate) fn verify_bytes(bytes: &[u8], file: &Path, key: &Path) -> Result<()> {
    let text = read(key, MAX_KEY, "the key")?;
    let info = SubjectPublicKeyInfoDer::from_pem_slice(&text).ok();
    let public = info.as_deref().and_then(|info| info.strip_prefix(&PREFIX));
    let public = public.ok_or_else(|| no_key(key, "public"))?;
    let beside = with(file, "sig");
    let signature = read(&beside, LENGTH + 1, "the signature").map_err(|error| {
        Error::new(Code::Signature, "the file is not signed").at(file).why(error.what())
    })?;
    UnparsedPublicKey::new(&ED25519, public).verify(bytes, &signature).map_err(|_| {
        Error::new(Code::Signature, "the signature does not match the file").at(file).why(format!(
            "{} was made with another key than {}, or for other content",
            beside.display(),
            key.display()
        ))
    })
}

/// The path with an additional extension.
fn with(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".");
    name.push(ending);
    name.into()
}

/// All bytes of a file, up to a limit.
fn read(path: &Path, most: u64, what: &str) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let read = files::open_input(path).and_then(|file| file.take(most).read_to_end(&mut bytes));
    let unread = |why| {
        let what = format!("{what} {} cannot be read: {why}", path.display());
        Error::new(Code::File, what).at(path)
    };
    read.map_err(unread)?;
    Ok(bytes)
}

fn unmade() -> Error {
    Error::new(Code::Output, "the keys could not be made")
}

fn no_key(key: &Path, kind: &str) -> Error {
    Error::new(Code::Certificate, format!("it contains no {kind} Ed25519 key"))
        .at(key)
        .help("`cosim keys pair NAME` makes NAME.key and NAME.pub")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn one_byte_another_key_and_no_signature_are_refused() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = |name: &str| folder.path().join(name);
        let [key, public] = make(&path("a")).unwrap();
        let [_, other] = make(&path("b")).unwrap();
        assert!(make(&path("a")).unwrap_err().to_string().contains("E302"));
        let file = path("x.fmu");
        fs::write(&file, b"content").unwrap();
        let code = |key: &Path| verify(&file, key).map_err(|error| error.code());
        assert_eq!(code(&public), Err(Code::Signature), "not signed");
        let beside = sign(&file, &key).unwrap();
        assert_eq!((beside.clone(), fs::read(&beside).unwrap().len()), (path("x.fmu.sig"), 64));
        assert_eq!(code(&public), Ok(()));
        assert_eq!(code(&other), Err(Code::Signature), "another key");
        assert_eq!(code(&key), Err(Code::Certificate), "no public key");
        assert!(sign(&file, &public).is_err());
        fs::write(&file, b"Content").unwrap();
        assert_eq!(code(&public), Err(Code::Signature), "another byte");
        fs::write(&file, b"content").unwrap();
        assert_eq!(code(&public), Ok(()));
        for change in [&|s: &mut Vec<u8>| s[0] ^= 1, &|s: &mut Vec<u8>| s.push(0)]
            as [&dyn Fn(&mut Vec<u8>); 2]
        {
            let mut signature = fs::read(&beside).unwrap();
            change(&mut signature);
            let kept = fs::read(&beside).unwrap();
            fs::write(&beside, signature).unwrap();
            assert_eq!(code(&public), Err(Code::Signature), "another signature");
            fs::write(&beside, kept).unwrap();
        }
    }
}
