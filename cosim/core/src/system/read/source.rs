//! Resolves the `source` attributes of a file.
//!
//! One rule: the user's own files may refer to any path (an .ssd on disk names its FMUs by any path
//! that the user may read); files from an archive may not refer to anything outside it, however the
//! path is written. Sources are URIs: `%20` is a space, `file:` is the only scheme; nothing is
//! downloaded.

use std::path::{Component, Path, PathBuf};

use crate::system::raw::Place;
use cosim_base::error::{Code, Error, Result};

/// The base of relative sources.
#[derive(Debug, Clone)]
pub(super) struct Base {
    /// The folder of the file; `None` if it is a text without a location.
    pub folder: Option<PathBuf>,
    /// The folder of the unpacked archive that contains the file.
    pub archive: Option<PathBuf>,
}

impl Base {
    pub(super) fn of_file(file: &Path) -> Self {
        let folder = file.parent().unwrap_or(Path::new("")).to_owned();
        Self { folder: Some(folder), archive: None }
    }

    pub(super) fn of_archive(folder: &Path) -> Self {
        Self { folder: Some(folder.to_owned()), archive: Some(folder.to_owned()) }
    }

    /// The base of sources in a file that is reached from this base.
    pub(super) fn of_neighbour(&self, file: &Path) -> Self {
        Self { archive: self.archive.clone(), ..Self::of_file(file) }
    }

    /// The path of a source; an error at its location if it is refused.
    pub(super) fn follow(&self, source: &str, place: &Place) -> Result<PathBuf> {
        self.resolve(source).map_err(|why| {
            let what = format!("the source \"{source}\" is refused");
            let error = place.mark(Error::new(Code::Source, what)).why(why);
            match split_scheme(source).0 {
                Some(scheme) if scheme.eq_ignore_ascii_case("proxyfmu") => error.help(
                    "name the FMU's own file, source=\"x.fmu\"; to compute it in another process \
                     or on another machine, use --distributed or write a remote FMU with cosim \
                     proxy",
                ),
                _ => error,
            }
        })
    }

    /// The same for a file that is read immediately; a text without a location has none.
    pub(super) fn open(&self, source: &str, place: &Place) -> Result<PathBuf> {
        if self.folder.is_none() {
            let what = format!("the source \"{source}\" is refused");
            let error = place.mark(Error::new(Code::Source, what));
            return Err(error.why("a text without a location cannot refer to files"));
        }
        self.follow(source, place)
    }

    /// The path of a source, or why it is refused.
    fn resolve(&self, source: &str) -> Result<PathBuf, String> {
        let (scheme, rest) = split_scheme(source);
        let path = match scheme {
            None => rest,
            Some(scheme) if scheme.eq_ignore_ascii_case("file") => local(rest)?,
            Some(scheme) => {
                return Err(format!(
                    "its scheme is '{scheme}:', and nothing is downloaded or asked"
                ));
            }
        };
        let path = decode(path)?;
        if path.is_empty() || path.contains('\0') {
            return Err("it does not name a file".to_owned());
        }
        let joined = self.folder.as_ref().map_or(PathBuf::from(&path), |f| f.join(&path));
        match &self.archive {
            None => Ok(joined),
            Some(_) if path.contains('\\') => {
                Err("it contains a backslash; inside an archive the separator is '/'".to_owned())
            }
            Some(_) if Path::new(&path).is_absolute() || scheme.is_some() => {
                Err("it is absolute, but files in an archive may not refer to anything outside it"
                    .to_owned())
            }
            Some(archive) => match lexical(&joined) {
                Some(inside) if inside.starts_with(archive) => Ok(inside),
                _ => Err("it leads out of the archive".to_owned()),
            },
        }
    }
}

/// `scheme:rest` of a URI (RFC 3986, 3.1).
fn split_scheme(source: &str) -> (Option<&str>, &str) {
    match source.split_once(':') {
        Some((scheme, rest))
            if scheme.starts_with(|c: char| c.is_ascii_alphabetic())
                && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c)) =>
        {
            (Some(scheme), rest)
        }
        _ => (None, source),
    }
}

/// The path of a `file:` URI: `file:///a`, `file:/a`, `file://localhost/a`.
fn local(rest: &str) -> Result<&str, String> {
    let Some(rest) = rest.strip_prefix("//") else {
        return Ok(rest);
    };
    match rest.find('/') {
        Some(0) => Ok(rest),
        Some(end) if &rest[..end] == "localhost" => Ok(&rest[end..]),
        _ => Err("it names another machine".to_owned()),
    }
}

fn decode(text: &str) -> Result<String, String> {
    let bytes = text.as_bytes();
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        if bytes[at] != b'%' {
            decoded.push(bytes[at]);
            at += 1;
            continue;
        }
        let digits = text.get(at + 1..at + 3).filter(|d| d.bytes().all(|b| b.is_ascii_hexdigit()));
        let byte = digits.and_then(|digits| u8::from_str_radix(digits, 16).ok());
        decoded.push(byte.ok_or("a '%' must be followed by two hexadecimal digits (%25 is '%')")?);
        at += 3;
    }
    String::from_utf8(decoded).map_err(|_| "it is not UTF-8 once decoded".to_owned())
}

/// The path without `.` and `..`; `None` if it would leave its root.
fn lexical(path: &Path) -> Option<PathBuf> {
    let mut clean = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => (),
            Component::ParentDir if !clean.pop() => return None,
            Component::ParentDir => (),
            other => clean.push(other),
        }
    }
    Some(clean)
}

/// A path as a source, relative to `folder` where possible.
pub(in crate::system) fn write(path: &Path, folder: &Path) -> String {
    let absolute = |p: &Path| p.canonicalize().unwrap_or_else(|_| p.to_owned());
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let (path, folder) = (absolute(path), absolute(folder));
    let shared = path.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    // Two locations that share no more than the root are unrelated.
    let relative: PathBuf = if shared < 2 {
        path
    } else {
        let up = folder.components().skip(shared).map(|_| Component::ParentDir);
        up.chain(path.components().skip(shared)).collect()
    };
    encode(&relative)
}

fn encode(path: &Path) -> String {
    let mut uri = String::new();
    for &byte in path.as_os_str().as_encoded_bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' => uri.push(byte as char),
            b'/' | b'-' | b'_' | b'.' | b'~' | b'+' | b'=' | b'@' => uri.push(byte as char),
            _ => uri.push_str(&format!("%{byte:02X}")),
        }
    }
    uri
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_users_files_may_point_anywhere() {
        let base = Base::of_file(Path::new("a/b/x.ssd"));
        for (source, path) in [
            ("../c.fmu", "a/b/../c.fmu"),
            ("/d/e.fmu", "/d/e.fmu"),
            ("file:///d/e%20f.fmu", "/d/e f.fmu"),
            ("file://localhost/d", "/d"),
            ("my%20model.fmu", "a/b/my model.fmu"),
        ] {
            assert_eq!(base.resolve(source).as_deref(), Ok(Path::new(path)));
        }
        for source in ["http://a/b.fmu", "file://server/x", "a%2", "a%zz", "", "a%00", "C:\\x"] {
            assert!(base.resolve(source).is_err(), "{source}");
        }
    }

    #[test]
    fn an_archive_is_not_left() {
        let base = Base::of_archive(Path::new("/tmp/unpacked"));
        let inside = base.resolve("resources/../a.fmu");
        assert_eq!(inside.as_deref(), Ok(Path::new("/tmp/unpacked/a.fmu")));
        for source in [
            "../x",
            "a/../../x",
            "/etc/passwd",
            "file:///etc/passwd",
            "%2e%2e/x",
            "..%2Fx",
            "a\\..\\x",
            "../unpacked2/x",
        ] {
            assert!(base.resolve(source).is_err(), "{source}");
        }
    }

    #[test]
    fn what_is_written_is_read_as_the_same() {
        let folder = tempfile::TempDir::new().unwrap();
        let (place, file) = (folder.path().join("out"), folder.path().join("a b%ü.fmu"));
        std::fs::create_dir(&place).unwrap();
        std::fs::write(&file, "").unwrap();
        let source = write(&file, &place);
        assert!(source.starts_with("../a%20b%25"), "{source}");
        let back = Base::of_file(&place.join("x.ssd")).resolve(&source).unwrap();
        assert_eq!(back.canonicalize().unwrap(), file.canonicalize().unwrap());
    }
}
