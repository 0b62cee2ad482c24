//! `fmuResourceLocation`, a URI (RFC 3986), as a folder.
//!
//! Importers write `file:///x/resources`, `file:/x/resources`, `file:////x/resources`, with or
//! without a trailing slash, with spaces and umlauts percent-encoded or plain; a few pass a plain
//! path. On Windows the path has a drive (`file:///C:/x`, `file:/C:/x`, `file:///C%3A/x`, `C:\x`,
//! `C:/x`) or a server (`file://server/share/x`, `\\server\share\x`).

use std::path::PathBuf;

use crate::author::Resources;

/// The folder that a URI names; none if it is not on this machine's file system.
pub(super) fn resources(uri: &str) -> Resources {
    let path = if cfg!(windows) { on_windows(uri) } else { on_unix(uri) };
    path.map_or_else(Resources::none, |path| Resources::in_folder(PathBuf::from(path)))
}

fn on_unix(uri: &str) -> Option<String> {
    match after_scheme(uri) {
        Some(rest) => {
            let rest = rest.strip_prefix("//localhost").unwrap_or(rest);
            decode(&format!("/{}", rest.trim_start_matches('/')))
        }
        None => uri.starts_with('/').then(|| uri.to_owned()),
    }
}

fn on_windows(uri: &str) -> Option<String> {
    let Some(rest) = after_scheme(uri) else {
        let rooted = has_drive(uri) || uri.starts_with(['/', '\\']);
        return rooted.then(|| uri.to_owned());
    };
    let rest = decode(rest)?.replace('\\', "/");
    let rest = rest.strip_prefix("//localhost").unwrap_or(&rest);
    let path = rest.trim_start_matches('/');
    match rest.len() - path.len() {
        _ if has_drive(path) => Some(path.to_owned()),
        // A server, or, as some write it, a path that begins with two slashes.
        2 | 4.. => Some(format!(r"\\{}", path.replace('/', r"\"))),
        // On the drive of the importer's working directory.
        _ => Some(format!("/{path}")),
    }
}

/// The part after `file:`; none if there is another scheme or none.
fn after_scheme(uri: &str) -> Option<&str> {
    let (scheme, rest) = uri.split_at_checked(5)?;
    scheme.eq_ignore_ascii_case("file:").then_some(rest)
}

/// Whether a path begins with `C:` and is not relative to that drive's working directory.
fn has_drive(path: &str) -> bool {
    match path.as_bytes() {
        [letter, b':'] => letter.is_ascii_alphabetic(),
        [letter, b':', b'/' | b'\\', ..] => letter.is_ascii_alphabetic(),
        _ => false,
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
    use super::{on_unix as folder, on_windows};

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
    fn drives_are_understood_in_all_spellings() {
        for uri in [
            "file:///C:/x y/r\u{e4}",
            "file:/C:/x%20y/r%C3%A4",
            "file:C:/x%20y/r%C3%A4",
            "file:////C:/x%20y/r%C3%A4",
            "file:///C%3A/x%20y/r%C3%A4",
            "file:///C:\\x y\\r\u{e4}",
            "FILE://localhost/C:/x y/r\u{e4}",
            "C:/x y/r\u{e4}",
        ] {
            assert_eq!(on_windows(uri).as_deref(), Some("C:/x y/r\u{e4}"), "{uri}");
        }
        assert_eq!(on_windows(r"C:\x y").as_deref(), Some(r"C:\x y"));
        assert_eq!(on_windows("file:///C:/x/").as_deref(), Some("C:/x/"));
    }

    #[test]
    fn servers_are_understood() {
        for uri in ["file://server/share/r%20x", "file:////server/share/r%20x"] {
            assert_eq!(on_windows(uri).as_deref(), Some(r"\\server\share\r x"), "{uri}");
        }
        for path in [r"\\server\share\r x", r"\\?\C:\r"] {
            assert_eq!(on_windows(path).as_deref(), Some(path));
        }
    }

    #[test]
    fn a_percent_sign_in_a_plain_path_is_one() {
        assert_eq!(on_windows(r"C:\100%41").as_deref(), Some(r"C:\100%41"));
        assert_eq!(folder("/100%41").as_deref(), Some("/100%41"));
    }

    #[test]
    fn what_is_no_file_of_windows_is_none() {
        for uri in ["https://example.com/r", "", "C:relative", "relative", "file:///%ff"] {
            assert_eq!(on_windows(uri), None, "{uri}");
        }
    }

    #[test]
    fn a_lone_percent_sign_stays() {
        assert_eq!(folder("file:///100%/%2").as_deref(), Some("/100%/%2"));
    }
}
