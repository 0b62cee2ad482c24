//! The folder of a campaign: a log with a line for each finished run, and files derived from it.
//!
//! A line is written by a single call once its run is finished, so that a process that ends loses
//! only the runs in progress. A line that is incomplete because of a full disk or a lost machine is
//! removed and its run repeated. All other files are derived from the log, each as a whole.

use std::collections::HashSet;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{Campaign, Row, table};
use crate::error::{Code, Error, Result};
use crate::files;

/// The results of a campaign.
pub struct Folder {
    path: PathBuf,
    log: File,
    rows: Vec<Row>,
}

/// The campaign to which the results belong.
#[derive(Serialize, Deserialize)]
struct Manifest {
    file: PathBuf,
    identity: Vec<String>,
    cells: Vec<String>,
    figures: Vec<String>,
}

const MANIFEST: &str = "campaign.json";
const LOG: &str = "runs.jsonl";

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
            fits(&Manifest::read(&path)?.identity, identity, &path)?;
        }
        let mut folder = Self { path, log, rows: Vec::new() };
        folder.read_log()?;
        // The number of seeds, or the location of the file, may have changed.
        let new = Manifest {
            file: campaign.file.clone(),
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
        let Manifest { file, identity, cells, figures } = Manifest::read(path)?;
        let (rows, notes) = (Vec::new(), Vec::new());
        let mut contents = Contents { campaign: file, identity, cells, figures, rows, notes };
        let log = path.join(LOG);
        match File::open(&log) {
            Err(e) => contents.notes.push(format!("{} cannot be read: {e}", log.display())),
            Ok(log) => contents.read_rows(BufReader::new(log)),
        }
        Ok(contents)
    }

    fn read_log(&mut self) -> Result<()> {
        let file = self.path.join(LOG);
        let unread = |e| Error::new(Code::Results, "the rows cannot be read").at(&file).why(e);
        let mut log = BufReader::new(&self.log);
        let (mut whole, mut line, mut text) = (0, 0, Vec::new());
        while log.read_until(b'\n', &mut text).map_err(unread)? > 0 && text.ends_with(b"\n") {
            (whole, line) = (whole + text.len() as u64, line + 1);
            if text.len() > 1 {
                let row = serde_json::from_slice(&text).map_err(|e| {
                    Error::new(Code::Results, "a row cannot be read").at_line(&file, line).why(e)
                })?;
                self.rows.push(row);
            }
            text.clear();
        }
        if !text.is_empty() {
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
        Ok(())
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
        let parquet = table::parquet(campaign, &self.rows, identity).map_err(|e| {
            Error::new(Code::Output, "the table of runs cannot be made").at(&self.path).why(e)
        })?;
        self.write("runs.parquet", parquet)?;
        if csv {
            self.write("runs.csv", table::csv(campaign, &self.rows))?;
        }
        Ok(())
    }
}

/// The rows in a folder, in order of arrival.
fn logged(path: &Path) -> Result<Vec<Row>> {
    let file = path.join(LOG);
    let text = std::fs::read_to_string(&file)
        .map_err(|e| Error::new(Code::Results, "the rows cannot be read").at(&file).why(e))?;
    // A line that is being written, or is incomplete, is not a row yet.
    Ok(text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect())
}

/// The contents of a folder.
pub struct Contents {
    /// The file of the campaign.
    pub campaign: PathBuf,
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
    fn read_rows(&mut self, log: impl BufRead) {
        const SHOWN: usize = 5;
        let (mut lost, mut known) = (0, HashSet::new());
        for (line, text) in log.split(b'\n').enumerate() {
            let text = match text {
                Ok(text) if text.is_empty() => continue,
                Ok(text) => text,
                Err(e) => return self.notes.push(format!("{LOG} cannot be read to its end: {e}")),
            };
            match serde_json::from_slice::<Row>(&text) {
                Ok(row) if known.insert(row.run) => self.rows.push(row),
                Ok(_) => {}
                Err(e) => {
                    lost += 1;
                    if lost <= SHOWN {
                        self.notes.push(format!("line {} of {LOG} is not a row: {e}", line + 1));
                    }
                }
            }
        }
        if lost > SHOWN {
            self.notes.push(format!("{} more lines of {LOG} are not rows", lost - SHOWN));
        }
    }

    /// Fails with the first differences if they belong to another campaign than this file.
    pub(super) fn fit(&self, campaign: &Campaign, path: &Path) -> Result<()> {
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
        .why(format!("they were made with: {}. Now: {}", shown(gone), shown(new)))
        .help("undo the change, or choose another --output-dir"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::Status;
    use crate::campaign::row::Number;
    use crate::observe::Recording;

    fn campaign() -> Campaign {
        let text = "seeds = 3\n[systems]\na = 'a.ssd'\n[figures.f]\nkind = 'max'\nof = 'x'\n";
        Campaign::parse(text, Path::new("/c/c.toml")).unwrap()
    }

    fn row(run: u64) -> Row {
        let mut row = Row::without_figures(run, Status::Ok, "said \"a, b\"");
        (row.figures, row.cpu_ms) = (vec![Number(0.1 + 0.2)], "1".into());
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
        let read = Recording::read(folder.path().join("runs.parquet"));
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
