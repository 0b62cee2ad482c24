//! Writes archives.

use std::fs::{self, File};
use std::io::{Result as IoResult, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::Content;
use cosim_base::files::Unfinished;

pub(super) fn write<'a>(
    path: &Path,
    entries: impl IntoIterator<Item = (&'a str, Content<'a>)>,
) -> IoResult<()> {
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::create_dir_all(folder)?;
    let unfinished = Unfinished::new(path)?;
    let mut zip = ZipWriter::new(unfinished.file());
    let options = SimpleFileOptions::default().last_modified_time(DateTime::default());
    for (name, content) in entries {
        let (mode, method) = match content {
            Content::Bytes(_) => (0o644, CompressionMethod::Deflated),
            Content::File(path) => (mode(path)?, CompressionMethod::Deflated),
            Content::Compressed(_) => (0o644, CompressionMethod::Stored),
        };
        zip.start_file(name, options.unix_permissions(mode).compression_method(method))?;
        match content {
            Content::Bytes(bytes) => zip.write_all(bytes)?,
            Content::File(path) | Content::Compressed(path) => {
                std::io::copy(&mut File::open(path)?, &mut zip)?;
            }
        }
    }
    zip.finish()?;
    unfinished.finish()
}

fn mode(path: &Path) -> IoResult<u32> {
    let own = fs::metadata(path)?.permissions().mode();
    Ok(if own & 0o100 == 0 { 0o644 } else { 0o755 })
}
