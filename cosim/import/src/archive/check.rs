//! The rules for the entries of an archive.
//!
//! A name must stay inside the folder on every system (no `..`, `/x`, `C:`, NUL; `\` is a separator
//! like `/`, because tools on Windows write it), must not collide with another one on a
//! case-insensitive file system, and must not be both a file and a folder. Only plain files and
//! folders are accepted, no links and devices. Numbers, sizes, depth and ratios are bounded, and no
//! two entries share bytes of the archive (overlapping entries make a small archive large without a
//! suspicious ratio).
//! archive large without a suspicious ratio).

use std::collections::HashMap;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use zip::unstable::read::ZipIterable;
use zip::{CompressionMethod, ZipReadOptions};

use super::read::{broken, refused};
use cosim_base::error::{Code, Error, Result};

const MAX_ENTRIES: usize = 10_000;
/// Files and folders, including folders that appear only as parts of names: creating each takes
/// time.
const MAX_PLACES: usize = 20_000;
const MAX_BYTES: u64 = 4 << 30;
/// Ratio refused for entries above `RATIO_FROM` bytes; deflate reaches 1032 on zeros, but not on
/// real content.
const MAX_RATIO: u64 = 500;
const RATIO_FROM: u64 = 10 << 20;
/// Ratio refused for archives that unpack to more than `TOTAL_RATIO_FROM` bytes.
const MAX_TOTAL_RATIO: u64 = 200;
const TOTAL_RATIO_FROM: u64 = 100 << 20;
const MAX_DEPTH: usize = 32;
/// Maximum length of one part of a name, and of the whole name, in bytes; the limits of common file
/// systems.
const MAX_PART: usize = 255;
const MAX_NAME: usize = 1024;

/// File type in the upper bits of the Unix mode.
const S_IFMT: u32 = 0o170_000;
const S_IFREG: u32 = 0o100_000;
const S_IFDIR: u32 = 0o040_000;

/// An entry that may be unpacked.
pub(super) struct Checked {
    pub name: String,
    pub path: PathBuf,
    pub is_folder: bool,
    pub executable: bool,
    pub size: u64,
}

/// Checks all entries, in order.
pub(super) fn entries<R: Read + Seek>(
    zip: &mut ZipIterable<R>,
    archive: &Path,
) -> Result<Vec<Checked>> {
    if zip.len() > MAX_ENTRIES {
        let what = format!("an archive of {} entries is refused", zip.len());
        let why = format!("more than {MAX_ENTRIES} are refused");
        return Err(Error::new(Code::Archive, what).at(archive).why(why));
    }
    let files = zip.files().map_err(|e| broken(archive, e))?;
    let length = files.reader_mut().seek(SeekFrom::End(0)).map_err(|e| broken(archive, e))?;
    let mut places = Places { archive, seen: HashMap::new(), spans: Vec::new(), total: 0, length };
    let mut checked = Vec::new();
    while let Some(entry) = files.next() {
        let entry = entry.map_err(|e| broken(archive, e))?;
        let name = entry.name().map_err(|e| broken(archive, e))?.into_owned();
        let refuse = |why: String| Err(refused(archive, &name).why(why));
        let is_folder = name.ends_with(['/', '\\']);
        let mode = entry.unix_mode().unwrap_or(0);
        match mode & S_IFMT {
            0 | S_IFREG | S_IFDIR => (),
            0o120_000 => return refuse("it is a symbolic link".to_owned()),
            _ => return refuse("it is a device or another special file".to_owned()),
        }
        let path = relative(&name).map_err(|why| refused(archive, &name).why(why))?;
        places.take(&name, &path, is_folder)?;
        if entry.encrypted() {
            return refuse("it is encrypted".to_owned());
        }
        if !matches!(entry.compression(), CompressionMethod::Stored | CompressionMethod::Deflated) {
            return refuse(format!("its compression ({}) is not deflate", entry.compression()));
        }
        let (size, packed) = (entry.size(), entry.compressed_size());
        places.measure(&name, size, packed)?;
        let start = entry.header_start();
        let content = entry
            .with_reader(files.reader_mut(), ZipReadOptions::new())
            .map_err(|e| refused(archive, &name).why(e))?;
        let end = content.data_start().and_then(|data| data.checked_add(packed));
        match end {
            Some(end) if end <= length => places.spans.push((start, end, checked.len())),
            _ => return refuse("it reaches beyond the end of the archive".to_owned()),
        }
        let executable = mode & 0o111 != 0;
        checked.push(Checked { name, path, is_folder, executable, size });
    }
    places.overlap(&checked)?;
    Ok(checked)
}

/// What the previous entries use.
struct Places<'a> {
    archive: &'a Path,
    /// Names in lower case, with whether they are folders and whether they have their own entry.
    seen: HashMap<String, (bool, bool)>,
    /// Bytes of the archive: start, end, entry.
    spans: Vec<(u64, u64, usize)>,
    total: u64,
    length: u64,
}

impl Places<'_> {
    fn take(&mut self, name: &str, path: &Path, is_folder: bool) -> Result<()> {
        let refuse = |why: &str| Err(refused(self.archive, name).why(why));
        let key = |path: &Path| path.to_string_lossy().to_lowercase();
        for parent in path.ancestors().skip(1).filter(|p| !p.as_os_str().is_empty()) {
            let (folder, _) = self.seen.entry(key(parent)).or_insert((true, false));
            if !*folder {
                return refuse("another entry is a file where this one needs a folder");
            }
        }
        let earlier = self.seen.insert(key(path), (is_folder, true));
        if self.seen.len() > MAX_PLACES {
            return refuse("with it, the archive has more than 20000 files and folders");
        }
        match earlier {
            // A folder may be listed again, also after its files.
            None => Ok(()),
            Some((true, _)) if is_folder => Ok(()),
            Some((true, false)) => refuse("it is a file, and a folder of other entries"),
            Some(_) => refuse("another entry has the same place, or one that differs only in case"),
        }
    }

    fn measure(&mut self, name: &str, size: u64, packed: u64) -> Result<()> {
        let refuse = |why: &str| Err(refused(self.archive, name).why(why));
        self.total = self.total.saturating_add(size);
        if size > RATIO_FROM && size / packed.max(1) > MAX_RATIO {
            return refuse("its compression ratio is implausible");
        }
        if self.total > TOTAL_RATIO_FROM && self.total / self.length.max(1) > MAX_TOTAL_RATIO {
            return refuse("with it, the compression ratio of the archive is implausible");
        }
        if self.total > MAX_BYTES {
            return refuse("with it, the archive unpacks to more than 4 GiB");
        }
        Ok(())
    }

    fn overlap(&mut self, checked: &[Checked]) -> Result<()> {
        self.spans.sort_unstable();
        match self.spans.windows(2).find(|pair| pair[0].1 > pair[1].0) {
            None => Ok(()),
            Some(pair) => {
                let (first, second) = (&checked[pair[0].2].name, &checked[pair[1].2].name);
                let why = format!("it shares bytes of the archive with '{}'", first.escape_debug());
                Err(refused(self.archive, second).why(why))
            }
        }
    }
}

/// The path of an entry inside the folder, or why it has none.
fn relative(name: &str) -> Result<PathBuf, &'static str> {
    let name = &name.replace('\\', "/");
    if name.chars().any(char::is_control) {
        return Err("its name contains control characters");
    }
    if name.starts_with('/') {
        return Err("its name is absolute: it would be written outside the unpacked folder");
    }
    if name.get(1..2) == Some(":") {
        return Err("its name begins with a drive: it would be written outside the folder");
    }
    let parts: Vec<&str> = name.split('/').filter(|part| !matches!(*part, "" | ".")).collect();
    if parts.contains(&"..") {
        return Err("its name contains '..': it would be written outside the unpacked folder");
    }
    // Some tools pack the folder itself.
    if name == "./" {
        return Ok(PathBuf::new());
    }
    if parts.is_empty() {
        return Err("its name is empty");
    }
    if name.len() > MAX_NAME || parts.iter().any(|part| part.len() > MAX_PART) {
        return Err("its name is too long");
    }
    if parts.len() > MAX_DEPTH {
        return Err("it is nested too deeply: more than 32 folders");
    }
    Ok(parts.iter().collect())
}
