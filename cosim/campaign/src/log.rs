//! The log of a campaign: a line for each finished run.
//!
//! It is read twice: from its beginning, to know all runs, and at the places of some lines, to use
//! them.

use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::os::unix::fs::FileExt;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::thread;

use serde::de::DeserializeOwned;

use super::Row;
use super::rows::ordered;
use cosim_base::error::{Code, Error, Result};

/// The name of the log in its folder.
pub(super) const LOG: &str = "runs.jsonl";

/// A log.
pub(super) struct Log {
    pub(super) file: File,
    pub(super) path: PathBuf,
}

/// A line that ends, and is not empty.
pub(super) struct Line<T> {
    /// Counted from 1.
    pub(super) number: usize,
    /// The octet at which it begins.
    pub(super) place: u64,
    /// What is wanted of its row.
    pub(super) row: serde_json::Result<T>,
}

/// How much of a log has been read: lines that end.
pub(super) struct Whole {
    pub(super) octets: u64,
    pub(super) lines: usize,
}

/// Octets of the log that are parsed together.
const BLOCK: u64 = 1 << 19;
/// Octets of the log that are read together for single lines.
const NEAR: usize = 1 << 16;

impl Log {
    /// The log in a folder, for reading.
    pub(super) fn open(folder: &Path) -> std::io::Result<Self> {
        let path = folder.join(LOG);
        Ok(Self { file: File::open(&path)?, path })
    }

    /// The log in a folder, for this process alone to continue; a new one if there is none.
    pub(super) fn continued(folder: &Path) -> Result<Self> {
        let path = folder.join(LOG);
        let file = OpenOptions::new().read(true).append(true).create(true).open(&path);
        let file = file.map_err(|e| {
            Error::new(Code::Output, "the results cannot be written").at(&path).why(e)
        })?;
        file.try_lock().map_err(|_| {
            Error::new(Code::Output, "the results are being written by another process").at(&path)
        })?;
        Ok(Self { file, path })
    }

    /// An error of reading.
    pub(super) fn unread(&self, why: std::io::Error) -> Error {
        Error::new(Code::Results, "the rows cannot be read").at(&self.path).why(why)
    }

    /// Adds a line; returns how many octets it has.
    pub(super) fn add(&mut self, row: &Row) -> Result<u64> {
        let line = serde_json::to_vec(row).map_err(std::io::Error::from).and_then(|mut line| {
            line.push(b'\n');
            self.file.write_all(&line).map(|()| line.len() as u64)
        });
        line.map_err(|e| {
            Error::new(Code::Output, "a row cannot be written")
                .at(&self.path)
                .why(e)
                .help("free some space and run the same command again: existing rows are kept")
        })
    }

    /// Passes each whole line to `each`, in order, with what `wanted` takes from its row. All cores
    /// take part in this.
    pub(super) fn read<T: Send>(
        &self,
        wanted: impl Fn(Row) -> T + Sync,
        mut each: impl FnMut(Line<T>),
    ) -> std::io::Result<Whole> {
        let (mut log, mut block) = (At(&self.file, 0), Vec::new());
        let mut whole = Whole { octets: 0, lines: 0 };
        loop {
            let read = log.by_ref().take(BLOCK).read_to_end(&mut block)?;
            let end = block.iter().rposition(|octet| *octet == b'\n').map_or(0, |last| last + 1);
            for (octets, row) in parsed(&block[..end], &wanted).into_iter().flatten() {
                whole.lines += 1;
                if let Some(row) = row {
                    each(Line { number: whole.lines, place: whole.octets, row });
                }
                whole.octets += octets as u64;
            }
            block.drain(..end);
            if read == 0 {
                return Ok(whole);
            }
        }
    }

    /// What lines have that begin at these places, in the same order: rows, or parts of them.
    pub(super) fn rows<T: DeserializeOwned + Send>(&self, places: &[u64]) -> Result<Vec<T>> {
        let rows = on_cores(places.chunks(share(places.len())), |places| self.part(places));
        let all = rows.into_iter().reduce(|all, part| {
            let mut all = all?;
            all.extend(part?);
            Ok(all)
        });
        all.unwrap_or(Ok(Vec::new())).map_err(|e| self.unread(e))
    }

    fn part<T: DeserializeOwned>(&self, places: &[u64]) -> std::io::Result<Vec<T>> {
        // From the beginning of the log to its end, because most lines are close to the one before.
        let mut order: Vec<usize> = (0..places.len()).collect();
        order.sort_by_key(|at| places[*at]);
        let mut log = BufReader::with_capacity(NEAR, At(&self.file, 0));
        let (mut place, mut line, mut rows) = (0, Vec::new(), Vec::with_capacity(places.len()));
        for at in order {
            log.seek_relative(places[at] as i64 - place as i64)?;
            line.clear();
            place = places[at] + log.read_until(b'\n', &mut line)? as u64;
            rows.push((at, row(&line)?));
        }
        Ok(ordered(rows))
    }

    /// Whether a power loss left the line at this place empty, as file systems do with parts that
    /// were not written yet.
    pub(super) fn is_lost(&self, place: u64) -> std::io::Result<bool> {
        let mut line = Vec::new();
        BufReader::new(At(&self.file, place)).read_until(b'\n', &mut line)?;
        Ok(line.contains(&0))
    }
}

/// A file from an octet on: every reader has its own.
struct At<'a>(&'a File, u64);

impl Read for At<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let read = self.0.read_at(buffer, self.1)?;
        self.1 += read as u64;
        Ok(read)
    }
}

impl Seek for At<'_> {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        let place = match to {
            SeekFrom::Start(place) => Some(place),
            SeekFrom::Current(by) => self.1.checked_add_signed(by),
            SeekFrom::End(_) => None,
        };
        self.1 = place.ok_or(std::io::ErrorKind::InvalidInput)?;
        Ok(self.1)
    }
}

/// The share of each core.
fn share(count: usize) -> usize {
    count.div_ceil(thread::available_parallelism().map_or(1, usize::from)).max(1)
}

/// What becomes of each part on a core of its own.
fn on_cores<T: Send, R: Send>(
    parts: impl IntoIterator<Item = T>,
    each: impl Fn(T) -> R + Sync,
) -> Vec<R> {
    thread::scope(|scope| {
        let each = &each;
        let threads = parts.into_iter().map(|part| scope.spawn(move || each(part)));
        let threads: Vec<_> = threads.collect();
        let joined = threads.into_iter().map(|thread| thread.join());
        joined.map(|part| part.unwrap_or_else(|panic| resume_unwind(panic))).collect()
    })
}

/// A line that was parsed: how many octets it has, and what is wanted of its row; none if it is
/// empty.
type Parsed<T> = (usize, Option<serde_json::Result<T>>);

/// These lines in parts, each parsed on another core.
fn parsed<T: Send>(lines: &[u8], wanted: &(impl Fn(Row) -> T + Sync)) -> Vec<Vec<Parsed<T>>> {
    let (mut parts, mut rest, share) = (Vec::new(), lines, share(lines.len()));
    while !rest.is_empty() {
        let least = share.min(rest.len()) - 1;
        let end = rest[least..].iter().position(|octet| *octet == b'\n');
        let (part, after) = rest.split_at(end.map_or(rest.len(), |end| least + end + 1));
        parts.push(part);
        rest = after;
    }
    let one = |line: &[u8]| (line.len(), (line != b"\n").then(|| row(line).map(wanted)));
    on_cores(parts, |part| part.split_inclusive(|octet| *octet == b'\n').map(one).collect())
}

/// What a line has.
fn row<T: DeserializeOwned>(line: &[u8]) -> serde_json::Result<T> {
    // A text is parsed faster than octets of which each part must be checked.
    match str::from_utf8(line) {
        Ok(text) => serde_json::from_str(text),
        Err(_) => serde_json::from_slice(line),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Status;

    #[test]
    fn lines_are_found_again_in_any_order_however_long_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let mut log = Log::continued(folder.path()).unwrap();
        let reason = |run: u64| "é".repeat(if run % 7 == 3 { NEAR } else { run as usize });
        let row = |run: u64| Row::without_figures(run, Status::Failed, reason(run));
        let (mut places, mut end) = (Vec::new(), 0);
        for run in 0..50 {
            places.push(end);
            end += log.add(&row(run)).unwrap();
        }
        log.file.write_all(b"\n{\"run\":").unwrap();
        let mut found = Vec::new();
        let whole =
            log.read(|row| row, |line| found.push((line.place, line.row.unwrap()))).unwrap();
        // The empty line counts, and the one that does not end does not.
        assert_eq!((whole.octets, whole.lines), (end + 1, 51));
        assert!(found.iter().map(|(place, _)| place).eq(&places));
        assert!(found.iter().zip(0..).all(|((_, found), run)| *found == row(run)));
        let order: Vec<u64> = (0..50).map(|run| run * 17 % 50).collect();
        let wanted: Vec<u64> = order.iter().map(|run| places[*run as usize]).collect();
        let again: Vec<Row> = log.rows(&wanted).unwrap();
        assert!(again.iter().zip(order).all(|(again, run)| *again == row(run)));
        assert!(log.rows::<Row>(&[end + 1]).is_err());
    }
}
