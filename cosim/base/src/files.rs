//! Reads and writes files: inputs are never replaced, results are complete or do not exist, and what
//! is synced survives a power loss.
//!
//! | file | what |
//! |---|---|
//! | `inputs` | what is read, and never replaced |
//! | `durable` | results, which grow |
//! | `whole` | files that replace others as a whole |
//! | `given` | files of a confined process, which may open none itself |

mod durable;
mod given;
mod inputs;
mod whole;

use std::fs::{File, OpenOptions};
use std::io::Read;
use std::path::Path;

use crate::error::{Code, Error, Result};
pub use durable::{Durable, save_all};
pub use durable::{sync_folder, synced};
pub use given::{CONTINUED, give, of_outbox, outbox_name};
pub use inputs::{
    note_continued, note_input, open_input, protect_inputs, read_foreign, read_input,
    read_input_text, refuse_inputs,
};
pub use whole::{Unfinished, copy, replace, replace_by};

/// First bytes of files that are not results, and what they are.
const OTHERS: [(&[u8], &str); 6] = [
    (b"PK\x03\x04", "an archive (.fmu, .ssp)"),
    (b"PK\x05\x06", "an archive"),
    (b"<", "an XML file"),
    (b"{", "a JSON file"),
    (b"\x7fELF", "a program or library"),
    (b"-----BEGIN", "a certificate or key"),
];
const SNAPSHOT: (&[u8], &str) = (b"COSIMSNP", "a snapshot");

/// Creates a file for results, digests or a log, emptying an existing one; `what` is the error
/// message. A file that is clearly something else is never replaced.
pub fn create(target: &Path, what: &str) -> Result<Durable> {
    let folder = given::given(target).is_none().then(|| durable::folder_of(target));
    Ok(Durable::new(create_plain(target, what)?, folder))
}

/// The same for a log, which is not worth syncing.
pub fn create_plain(target: &Path, what: &str) -> Result<File> {
    let file = create_later(target, what)?;
    begin(target, &file)?;
    Ok(file)
}

/// A file as by [`create_plain`], but an existing one keeps its content until [`begin`].
pub fn create_later(target: &Path, what: &str) -> Result<File> {
    if let Some(file) = given::given(target) {
        return Ok(file);
    }
    refuse_others(target, what, Some(SNAPSHOT))?;
    let file = OpenOptions::new().write(true).create(true).truncate(false).open(target);
    file.map_err(|why| Error::new(Code::Output, what).at(target).why(why))
}

/// Empties a file of [`create_later`], unless it is an input.
pub fn begin(target: &Path, file: &File) -> Result<()> {
    refuse_inputs(target, [])?;
    // Devices and pipes have no length.
    let plain = file.metadata().is_ok_and(|metadata| metadata.is_file());
    let emptied = if plain && given::given(target).is_none() { file.set_len(0) } else { Ok(()) };
    emptied
        .map_err(|why| Error::new(Code::Output, "the file cannot be emptied").at(target).why(why))
}

/// Refuses a name if there is a file of another kind; `more` is an additional kind to refuse.
pub fn refuse_others(target: &Path, what: &str, more: Option<(&[u8], &str)>) -> Result<()> {
    if !target.metadata().is_ok_and(|metadata| metadata.is_file()) {
        return Ok(());
    }
    let mut begin = [0; 16];
    let read = File::open(target).and_then(|mut file| file.read(&mut begin)).unwrap_or(0);
    let begin = begin[..read].trim_ascii_start();
    let html = begin.get(..14).is_some_and(|b| b.eq_ignore_ascii_case(b"<!doctype html"));
    match OTHERS.into_iter().chain(more).find(|(start, _)| begin.starts_with(start)) {
        Some((_, kind)) if !html => Err(Error::new(Code::Output, what)
            .at(target)
            .why(format!("the existing file is {kind}, which would be lost"))
            .help("choose another name, or remove the file")),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use tempfile::TempDir;

    #[test]
    fn what_is_something_else_is_not_replaced() {
        let folder = TempDir::new().unwrap();
        let target = folder.path().join("a");
        for (content, replaced) in [
            (&b"PK\x03\x04..."[..], false),
            (b"\n <?xml", false),
            (b"{\"events\"", false),
            (b"COSIMSNP...", false),
            (b"-----BEGIN PRIVATE KEY", false),
            (b"time,a\n", true),
            (b"<!doctype html>", true),
            (b"", true),
        ] {
            fs::write(&target, content).unwrap();
            let created = create(&target, "it cannot be written");
            assert_eq!(created.is_ok(), replaced, "{}", String::from_utf8_lossy(content));
            assert_eq!(fs::read(&target).unwrap().is_empty(), replaced);
        }
    }
}
