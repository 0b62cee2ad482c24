//! `fmuResourceLocation`, a URI (RFC 3986), as a folder.
//!
//! Importers write `file:///x/resources`, `file:/x/resources`, `file:////x/resources`, with a
//! slash at the end or without, with spaces and umlauts percent-encoded or plain; a few pass a
//! plain path.

use std::path::PathBuf;

use crate::author::Resources;

/// The folder a URI names; none if it names none on this machine's file system.
pub(super) fn resources(uri: &str) -> Resources {
    let path = match uri.get(..5) {
        Some(scheme) if scheme.eq_ignore_ascii_case("file:") => {
            let rest = uri.get(5..).unwrap_or_default();
            let rest = rest.strip_prefix("//localhost").unwrap_or(rest);
            decode(&format!("/{}", rest.trim_start_matches('/')))
        }
        _ if uri.starts_with('/') => Some(uri.to_owned()),
        _ => None,
    };
    match path {
        Some(path) => Resources::in_folder(PathBuf::from(drive(&path))),
        None => Resources::none(),
    }
}

/// `/C:/x` is `C:/x` where paths have drives.
fn drive(path: &str) -> &str {
    match path.as_bytes() {
        [b'/', letter, b':', ..] if cfg!(windows) && letter.is_ascii_alphabetic() => {
            path.get(1..).unwrap_or(path)
        }
        _ => path,
    }
}

/// Undoes percent-encoding; a `%` not followed by two hexadecimal digits stays.
fn decode(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    loop {
        let hex = |digit: u8| char::from(digit).to_digit(16);
        match *rest {
            [] => return String::from_utf8(bytes).ok(),
            [b'%', high, low, ref tail @ ..] if hex(high).is_some() && hex(low).is_some() => {
                let value = hex(high).unwrap_or_default() << 4 | hex(low).unwrap_or_default();
                bytes.push(value as u8);
                rest = tail;
            }
            [byte, ref tail @ ..] => {
                bytes.push(byte);
                rest = tail;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(uri: &str) -> Option<String> {
        resources(uri).folder().map(|path| path.to_str().unwrap().to_owned())
    }

    #[test]
    fn all_spellings_name_the_same_folder() {
        for uri in [
            "file:///tmp/x y/r\u{e4}",
            "file:////tmp/x%20y/r%C3%A4",
            "file:/tmp/x%20y/r%c3%a4",
            "FILE://localhost/tmp/x%20y/r\u{e4}",
            "/tmp/x y/r\u{e4}",
        ] {
            assert_eq!(folder(uri).as_deref(), Some("/tmp/x y/r\u{e4}"), "{uri}");
        }
        assert_eq!(folder("file:///tmp/r/").as_deref(), Some("/tmp/r/"));
    }

    #[test]
    fn what_is_no_file_is_none() {
        assert_eq!(folder("https://example.com/r"), None);
        assert_eq!(folder(""), None);
        assert_eq!(folder("file:///%ff"), None);
    }

    #[test]
    fn a_lone_percent_sign_stays() {
        assert_eq!(folder("file:///100%/%2").as_deref(), Some("/100%/%2"));
    }
}
