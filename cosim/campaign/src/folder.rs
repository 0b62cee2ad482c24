//! The folder of a campaign: a log with a line for each finished run, and files derived from it.
//!
//! A line is written by a single call once its run is finished, so that a process that ends loses
//! only the runs in progress. The log is synced each second: a power loss costs the runs of the last
//! one. A line that is incomplete because of a full disk or a lost machine is removed and its run
//! repeated. All other files are derived from the log, each as a whole.

use std::collections::HashSet;
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Read, Write};
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::{Campaign, Row, table};
use cosim_base::error::{Code, Error, Result};
use cosim_base::files;

/// The results of a campaign.
pub struct Folder {
    path: PathBuf,
    log: File,
    synced: Instant,
    rows: Vec<Row>,
}

/// Rows are synced after this time.
const SYNC: Duration = Duration::from_secs(1);

/// The campaign to which the results belong.
#[derive(Serialize, Deserialize)]
struct Manifest {
    file: PathBuf,
    /// What the file and its list were: a report does without them.
    #[serde(default)]
    text: String,
    #[serde(default)]
    list: Option<String>,
    identity: Vec<String>,
    cells: Vec<String>,
    figures: Vec<String>,
}

const MANIFEST: &str = "campaign.json";
const LOG: &str = "runs.jsonl";
const TABLE: &str = "runs.parquet";
/// What else a campaign, its reports and its shards leave in a folder.
const OTHERS: [&str; 6] =
    ["runs.csv", "summary.json", "junit.xml", "changes.json", "report.html", "trajectories"];
/// The names of the folders of shards begin with this.
const SHARD: &str = "shard-";

impl Folder {
    /// The results of a campaign with this identity: new ones, or existing ones. Those of another
    /// campaign are refused.
    pub fn open(path: impl AsRef<Path>, campaign: &Campaign, identity: &[String]) -> Result<Self> {
        let path = path.as_ref().to_owned();
        let unwritten = |what: &Path, e: std::io::Error| {
            Error::new(Code::Output, "the results cannot be written").at(what).why(e)
        };
        std::fs::create_dir_all(&path).map_err(|e| unwritten(&path, e))?;
        let file = path.join(LOG);
        let log = OpenOptions::new().read(true).append(true).create(true).open(&file);
        let log = log.map_err(|e| unwritten(&file, e))?;
        log.try_lock().map_err(|_| {
            Error::new(Code::Output, "the results are being written by another process").at(&file)
        })?;
        let manifest = path.join(MANIFEST);
        if manifest.exists() {
            let fit = fits(&Manifest::read(&path)?.identity, identity, &path);
            fit.map_err(|e| e.help("undo the change, or choose another --output-dir"))?;
        }
        let mut folder = Self { path, log, synced: Instant::now(), rows: Vec::new() };
        folder.read_log()?;
        // The number of seeds, or the location of the file, may have changed.
        let new = Manifest {
            file: campaign.file.clone(),
            text: campaign.text.clone(),
            list: campaign.list_text.clone(),
            identity: identity.to_vec(),
            cells: campaign.cells.iter().map(|cell| cell.name.clone()).collect(),
            figures: campaign.figures().map(str::to_owned).collect(),
        };
        folder.write(MANIFEST, serde_json::to_string_pretty(&new).unwrap_or_default())?;
        Ok(folder)
    }

    /// The file of the campaign whose results are in a folder.
    pub fn campaign(path: impl AsRef<Path>) -> Result<PathBuf> {
        Ok(Manifest::read(path.as_ref())?.file)
    }

    /// The row of a run in a folder whose campaign has this identity.
    pub fn row(path: impl AsRef<Path>, run: u64, identity: &[String]) -> Result<Row> {
        let mut rows = Self::rows_of(&path, identity)?.into_iter();
        rows.find(|row| row.run == run).ok_or_else(|| {
            let what = format!("run {run} is not among the results");
            Error::new(Code::Results, what).at(path.as_ref().join(LOG))
        })
    }

    /// The rows in a folder whose campaign has this identity, in order of arrival.
    pub fn rows_of(path: impl AsRef<Path>, identity: &[String]) -> Result<Vec<Row>> {
        let path = path.as_ref();
        fits(&Manifest::read(path)?.identity, identity, path)?;
        logged(path)
    }

    /// The contents of a folder, read-only: nothing is changed, and what cannot be read is skipped.
    pub fn contents(path: impl AsRef<Path>) -> Result<Contents> {
        let path = path.as_ref();
        let Manifest { file, text, list, identity, cells, figures } = Manifest::read(path)?;
        let (rows, notes) = rows_alone(path);
        Ok(Contents { campaign: file, text, list, identity, cells, figures, rows, notes })
    }

    fn read_log(&mut self) -> Result<()> {
        let file = self.path.join(LOG);
        let unread = |e| Error::new(Code::Results, "the rows cannot be read").at(&file).why(e);
        let (rows, mut wrong) = (&mut self.rows, None);
        let whole = read_rows(&self.log, |line, row| match row {
            Ok(row) => rows.push(row),
            Err(why) => wrong = wrong.take().or(Some((line, why))),
        });
        let (mut whole, _) = whole.map_err(unread)?;
        if let Some((line, _)) = wrong
            && let Some(damaged) = lost_by_power(&file, line).map_err(unread)?
        {
            self.rows.truncate(line - 1);
            (whole, wrong) = (damaged, None);
        }
        if let Some((line, why)) = wrong {
            let what = Error::new(Code::Results, "a row cannot be read");
            return Err(what.at_line(&file, line).why(why));
        }
        if whole < self.log.metadata().map_err(unread)?.len() {
            self.log.set_len(whole).map_err(unread)?;
        }
        Ok(())
    }

    /// The existing rows, in order of arrival.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Adds a row.
    pub fn add(&mut self, row: Row) -> Result<()> {
        let file = self.path.join(LOG);
        let unwritten = |e: String| {
            Error::new(Code::Output, "a row cannot be written")
                .at(&file)
                .why(e)
                .help("free some space and run the same command again: existing rows are kept")
        };
        let mut line = serde_json::to_vec(&row).map_err(|e| unwritten(e.to_string()))?;
        line.push(b'\n');
        self.log.write_all(&line).map_err(|e| unwritten(e.to_string()))?;
        self.rows.push(row);
        if self.synced.elapsed() > SYNC { self.sync() } else { Ok(()) }
    }

    /// From now on, the rows survive a power loss.
    pub fn sync(&mut self) -> Result<()> {
        self.synced = Instant::now();
        let file = self.path.join(LOG);
        files::synced(self.log.sync_data())
            .and_then(|()| files::sync_folder(&self.path))
            .map_err(|e| Error::new(Code::Output, "the rows cannot be synced").at(file).why(e))
    }

    /// Writes a file of this folder as a whole.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> Result<()> {
        let file = self.path.join(name);
        files::replace(&file, content.as_ref()).map_err(|e| {
            Error::new(Code::Output, "a file of results cannot be written").at(&file).why(e)
        })
    }

    /// Writes `runs.parquet`, and `runs.csv` on request: one row per run, in order, with its
    /// parameters and results.
    pub fn write_table(&self, campaign: &Campaign, identity: &[String], csv: bool) -> Result<()> {
        let file = self.path.join(TABLE);
        files::replace_by(&file, |table| {
            let table = table::parquet(campaign, &self.rows, identity, BufWriter::new(table));
            table.map_err(std::io::Error::other)
        })
        .map_err(|e| {
            Error::new(Code::Output, "the table of runs cannot be written").at(&file).why(e)
        })?;
        if csv {
            self.write("runs.csv", table::csv(campaign, &self.rows))?;
        }
        Ok(())
    }
}

/// Where a line begins that a power loss left empty, as file systems do with parts that were not
/// written yet: it and what follows is lost.
fn lost_by_power(log: &Path, line: usize) -> std::io::Result<Option<u64>> {
    let octets = std::fs::read(log)?;
    let mut lines = octets.split_inclusive(|octet| *octet == b'\n');
    let before: usize = lines.by_ref().take(line - 1).map(<[u8]>::len).sum();
    Ok(lines.next().filter(|line| line.contains(&0)).map(|_| before as u64))
}

/// The rows in a folder, in order of arrival.
fn logged(path: &Path) -> Result<Vec<Row>> {
    let (file, mut rows) = (path.join(LOG), Vec::new());
    // A line that is being written is not a row yet.
    let read = File::open(&file).and_then(|log| read_rows(log, |_, row| rows.extend(row)));
    read.map_err(|e| Error::new(Code::Results, "the rows cannot be read").at(&file).why(e))?;
    Ok(rows)
}

/// What is missing in a folder in which no campaign can be read; `None` if it is another folder.
pub(super) fn missing(path: &Path) -> Option<Vec<String>> {
    let entries = std::fs::read_dir(path).ok()?.filter_map(std::result::Result::ok);
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    let names: Vec<String> = names.collect();
    let has = |wanted: &str| names.iter().any(|name| name == wanted);
    let own = [MANIFEST, LOG, TABLE];
    let shards = names.iter().filter(|name| name.starts_with(SHARD)).count();
    let others = names.iter().filter(|name| OTHERS.contains(&name.as_str())).count();
    if shards + others < names.len() && !own.into_iter().any(has) {
        return None;
    }
    let mut notes = Vec::new();
    if names.is_empty() {
        notes.push("the folder is empty: cosim campaign writes results into it".to_owned());
    }
    if shards > 0 {
        notes.push("its shards are not merged: cosim campaign --merge merges them".to_owned());
    }
    Some(notes)
}

/// What is wrong with the table of the rows in a folder.
pub(super) fn table_note(path: &Path, rows: u64) -> Option<String> {
    let problem = match table::runs(&path.join(TABLE)) {
        Ok(runs) if runs == rows => return None,
        Ok(runs) => format!("has {runs} of {rows} runs"),
        Err(why) => format!("cannot be read: {why}"),
    };
    Some(format!("{TABLE} {problem}; run cosim campaign again to write it anew"))
}

/// The rows in a folder that can be read, each run once, and what cannot be read.
pub(super) fn rows_alone(path: &Path) -> (Vec<Row>, Vec<String>) {
    const SHOWN: usize = 5;
    let (mut rows, mut notes) = (Vec::new(), Vec::new());
    let file = path.join(LOG);
    let log = match File::open(&file) {
        Ok(log) => log,
        Err(e) => return (rows, vec![format!("{} cannot be read: {e}", file.display())]),
    };
    let (mut lost, mut known) = (0, HashSet::new());
    let whole = read_rows(&log, |line, row| match row {
        Ok(row) if known.insert(row.run) => rows.push(row),
        Ok(_) => {}
        Err(e) => {
            lost += 1;
            if lost <= SHOWN {
                notes.push(format!("line {line} of {LOG} is not a row: {e}"));
            }
        }
    });
    if lost > SHOWN {
        notes.push(format!("{} more lines of {LOG} are not rows", lost - SHOWN));
    }
    match (whole, log.metadata()) {
        (Err(e), _) => notes.push(format!("{LOG} cannot be read to its end: {e}")),
        (Ok((whole, lines)), Ok(file)) if whole < file.len() => {
            notes.push(format!("line {} of {LOG} is incomplete", lines + 1));
        }
        _ => {}
    }
    (rows, notes)
}

/// The row in a line of the log.
type Parsed = serde_json::Result<Row>;

/// Octets of the log that are parsed together.
const BLOCK: u64 = 1 << 22;

/// Passes each whole line of a log to `each`, with its number; returns how many octets they have, and
/// how many there are.
fn read_rows(
    mut log: impl Read,
    mut each: impl FnMut(usize, Parsed),
) -> std::io::Result<(u64, usize)> {
    let (mut block, mut whole, mut line) = (Vec::new(), 0, 0);
    loop {
        let read = log.by_ref().take(BLOCK).read_to_end(&mut block)?;
        let end = block.iter().rposition(|octet| *octet == b'\n').map_or(0, |last| last + 1);
        for row in parsed(&block[..end]).into_iter().flatten() {
            line += 1;
            row.into_iter().for_each(|row| each(line, row));
        }
        whole += end as u64;
        block.drain(..end);
        if read == 0 {
            return Ok((whole, line));
        }
    }
}

/// The rows in these lines in parts, each parsed on another core; nothing for an empty line.
fn parsed(lines: &[u8]) -> Vec<Vec<Option<Parsed>>> {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let (mut parts, mut rest) = (Vec::new(), lines);
    while !rest.is_empty() {
        let least = (lines.len() / cores).min(rest.len() - 1);
        let end = rest[least..].iter().position(|octet| *octet == b'\n');
        let (part, after) = rest.split_at(end.map_or(rest.len(), |end| least + end + 1));
        parts.push(part);
        rest = after;
    }
    let row = |line: &[u8]| (line != b"\n").then(|| serde_json::from_slice(line));
    let rows = |part: &[u8]| part.split_inclusive(|octet| *octet == b'\n').map(row).collect();
    thread::scope(|scope| {
        let threads: Vec<_> = parts.iter().map(|part| scope.spawn(|| rows(part))).collect();
        let joined = threads.into_iter().map(|thread| thread.join());
        joined
            .map(|rows: thread::Result<Vec<_>>| rows.unwrap_or_else(|e| resume_unwind(e)))
            .collect()
    })
}

/// The contents of a folder.
pub struct Contents {
    /// The file of the campaign.
    pub campaign: PathBuf,
    text: String,
    list: Option<String>,
    /// The identity of the campaign, as lines of text.
    pub identity: Vec<String>,
    /// The names of its cells: run `n` belongs to cell `n` modulo their number.
    pub cells: Vec<String>,
    /// The names of its figures, in the order of the rows.
    pub figures: Vec<String>,
    /// A row for each finished run.
    pub rows: Vec<Row>,
    /// What cannot be read, and why.
    pub notes: Vec<String>,
}

impl Contents {
    /// The campaign from its file, or as it was if that cannot be read or is another campaign now;
    /// this is noted.
    pub(super) fn read_campaign(&mut self, path: &Path) -> Result<Campaign> {
        let fitting = |campaign: Campaign| self.fit(&campaign, path).map(|()| campaign);
        Campaign::read(&self.campaign).and_then(fitting).or_else(|problem| {
            if self.text.is_empty() {
                return Err(problem);
            }
            let was = Campaign::parse_with(&self.text, &self.campaign, self.list.as_deref())?;
            self.fit(&was, path)?;
            let why = problem.line();
            self.notes
                .push(format!("the campaign is shown as it was when its runs were made: {why}"));
            Ok(was)
        })
    }

    /// Fails with the first differences if they belong to another campaign than this file.
    fn fit(&self, campaign: &Campaign, path: &Path) -> Result<()> {
        // Hashes of files decide whether runs can be repeated, not what their rows mean.
        let hash = |text: &str| text.len() == 64 && text.bytes().all(|b| b.is_ascii_hexdigit());
        let of_file = |line: &&String| {
            // After the GUID, for components.
            line.rsplit(' ').next().is_some_and(hash) || line.starts_with("cosim ")
        };
        let before: Vec<String> = self.identity.iter().filter(|l| !of_file(l)).cloned().collect();
        let now = campaign.identity();
        fits(&before, &now, path)
    }
}

impl Manifest {
    fn read(path: &Path) -> Result<Self> {
        let file = path.join(MANIFEST);
        let unread = |e: String| {
            Error::new(Code::Results, "the folder holds no results of a campaign").at(&file).why(e)
        };
        let text = std::fs::read_to_string(&file).map_err(|e| unread(e.to_string()))?;
        serde_json::from_str(&text).map_err(|e| unread(e.to_string()))
    }
}

/// Fails with the first differences if the results belong to another campaign.
fn fits(before: &[String], now: &[String], path: &Path) -> Result<()> {
    let missing = |of: &[String], from: &[String]| -> Vec<String> {
        of.iter().filter(|line| !from.contains(line)).take(3).cloned().collect()
    };
    let (gone, new) = (missing(before, now), missing(now, before));
    if gone.is_empty() && new.is_empty() {
        return Ok(());
    }
    let shown = |lines: Vec<String>| {
        if lines.is_empty() { "nothing instead".to_owned() } else { lines.join("; ") }
    };
    Err(Error::new(Code::Campaign, "the existing results belong to another campaign")
        .at(path)
        .why(format!("they were made with: {}. Now: {}", shown(gone), shown(new))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Status;
    use crate::row::Number;

    fn campaign() -> Campaign {
        let text = "seeds = 3\n[systems]\na = 'a.ssd'\n[figures.f]\nkind = 'max'\nof = 'x'\n";
        Campaign::parse(text, Path::new("/c/c.toml")).unwrap()
    }

    fn row(run: u64) -> Row {
        let mut row = Row::without_figures(run, Status::Ok, "said \"a, b\"");
        (row.figures, row.cpu_ms) = ([Number(0.1 + 0.2)].into(), Number(1.0));
        row
    }

    #[test]
    fn rows_outlive_the_process_and_a_line_cut_short_is_made_again() {
        let (folder, campaign) = (tempfile::tempdir().unwrap(), campaign());
        let identity = campaign.identity();
        let open = || Folder::open(folder.path(), &campaign, &identity);
        let mut first = open().unwrap();
        first.add(row(2)).unwrap();
        first.add(row(0)).unwrap();
        assert!(open().err().unwrap().to_string().contains("another process"));
        drop(first);
        let log = folder.path().join(LOG);
        let whole = std::fs::read(&log).unwrap();
        std::fs::write(&log, [&whole[..], b"{\"run\":1,\"sta"].concat()).unwrap();
        let mut second = open().unwrap();
        assert_eq!(second.rows(), [row(2), row(0)]);
        second.add(row(1)).unwrap();
        second.write_table(&campaign, &identity, true).unwrap();
        let read = cosim_results::read(folder.path().join("runs.parquet"));
        assert!(read.unwrap_err().to_string().contains("not called 'time'"));
        let table = std::fs::read_to_string(folder.path().join("runs.csv")).unwrap();
        let lines: Vec<&str> = table.lines().collect();
        assert_eq!(lines[0], "run,cell,replicate,status,reason,simulated,f,digest,cpu_ms");
        assert_eq!(lines[1], "0,a,0,ok,\"said \"\"a, b\"\"\",,0.30000000000000004,,1");
        assert_eq!(lines.len(), 4);
        drop(second);
        assert_eq!(Folder::row(folder.path(), 1, &identity).unwrap(), row(1));
    }

    #[test]
    fn what_a_power_loss_left_empty_is_made_again() {
        let (folder, campaign) = (tempfile::tempdir().unwrap(), campaign());
        let identity = campaign.identity();
        let mut first = Folder::open(folder.path(), &campaign, &identity).unwrap();
        (0..2).for_each(|run| first.add(row(run)).unwrap());
        drop(first);
        let log = folder.path().join(LOG);
        let whole = std::fs::read(&log).unwrap();
        let second = serde_json::to_vec(&row(2)).unwrap();
        std::fs::write(&log, [&whole[..], &[0; 300], b"\n", &second, b"\n"].concat()).unwrap();
        let again = Folder::open(folder.path(), &campaign, &identity).unwrap();
        assert_eq!(again.rows(), [row(0), row(1)]);
        assert_eq!(std::fs::read(&log).unwrap(), whole);
        drop(again);
        std::fs::write(&log, [&whole[..], b"nonsense\n"].concat()).unwrap();
        let wrong = Folder::open(folder.path(), &campaign, &identity).err().unwrap();
        assert!(wrong.to_string().contains("runs.jsonl:3"), "{wrong}");
    }

    #[test]
    fn results_of_another_campaign_are_refused_with_what_changed() {
        let (folder, campaign) = (tempfile::tempdir().unwrap(), campaign());
        let mut identity = campaign.identity();
        drop(Folder::open(folder.path(), &campaign, &identity).unwrap());
        identity.push("stop when = soon".to_owned());
        let error = Folder::open(folder.path(), &campaign, &identity).err().unwrap().to_string();
        assert!(error.contains("stop when = soon"), "{error}");
        assert!(Folder::row(folder.path(), 1, &identity).is_err());
    }
}
