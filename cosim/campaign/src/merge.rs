//! Merges the results of shards.

use std::path::{Path, PathBuf};

use super::log::Log;
use super::rows::ordered;
use super::{Folder, Row};
use cosim_base::error::{Code, Error, Result};

/// Rows that are in memory together.
const BATCH: usize = 1 << 12;

/// Where a row is.
#[derive(Clone, Copy)]
struct Known {
    run: u64,
    /// The position of its log among all.
    log: usize,
    place: u64,
}

impl Folder {
    /// Adds the rows of other folders of the same campaign, in the order of their runs. Nothing is
    /// added if two rows of a run differ in more than the time that it took.
    pub fn merge(&mut self, folders: &[PathBuf], identity: &[String]) -> Result<()> {
        let others = folders.iter().map(|folder| Self::log_of(folder, identity));
        let others: Vec<Log> = others.collect::<Result<_>>()?;
        let logs: Vec<&Log> = std::iter::once(&self.log).chain(&others).collect();
        let mut known = Vec::new();
        for (position, log) in logs.iter().enumerate() {
            // A line that is being written is not a row yet.
            let read = log.read(
                |row| row.run,
                |line| {
                    let at = |run| Known { run, log: position, place: line.place };
                    known.extend(line.row.ok().map(at));
                },
            );
            read.map_err(|e| log.unread(e))?;
        }
        known.sort_by_key(|known| known.run);
        let runs = || known.chunk_by(|one, other| one.run == other.run);
        let repeated: Vec<[Known; 2]> =
            runs().flat_map(|same| same[1..].iter().map(|other| [same[0], *other])).collect();
        for part in repeated.chunks(BATCH) {
            let of = |which: usize| -> Result<Vec<Row>> {
                let known: Vec<Known> = part.iter().map(|both| both[which]).collect();
                rows(&logs, &known)
            };
            let (first, second) = (of(0)?, of(1)?);
            let mut all = part.iter().zip(first.iter().zip(&second));
            if let Some((both, _)) = all.find(|(_, (one, other))| !one.agrees(other)) {
                let folder = |of: Known| logs[of.log].path.parent().unwrap_or(Path::new(""));
                return Err(parted(both[0].run, folder(both[0]), folder(both[1])));
            }
        }
        let new: Vec<Known> = runs().map(|same| same[0]).filter(|first| first.log > 0).collect();
        for part in new.chunks(BATCH) {
            let logs: Vec<&Log> = std::iter::once(&self.log).chain(&others).collect();
            rows(&logs, part)?.iter().try_for_each(|row| self.add(row))?;
        }
        Ok(())
    }
}

/// These rows, in the same order.
fn rows(logs: &[&Log], known: &[Known]) -> Result<Vec<Row>> {
    let mut rows = Vec::with_capacity(known.len());
    for (position, log) in logs.iter().enumerate() {
        let of_log = known.iter().enumerate().filter(|(_, known)| known.log == position);
        let (at, places): (Vec<usize>, Vec<u64>) =
            of_log.map(|(at, known)| (at, known.place)).unzip();
        rows.extend(at.into_iter().zip(log.rows(&places)?));
    }
    Ok(ordered(rows))
}

fn parted(run: u64, one: &Path, other: &Path) -> Error {
    let what = format!("run {run} differs between {} and {}", one.display(), other.display());
    Error::new(Code::Parted, what)
        .why("the same run gave different figures, or ended differently")
        .help(format!(
            "check it with cosim replay {} {run}, then omit one of the folders",
            other.display()
        ))
}
