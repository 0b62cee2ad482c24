//! The folder of a campaign: a log with a line for each finished run, and files derived from it.
//!
//! A line is written by a single call once its run is finished, so that a process that ends loses
//! only the runs in progress. The log is synced each second: a power loss costs the runs of the last
//! one. A line that is incomplete because of a full disk or a lost machine is removed and its run
//! repeated. All other files are derived from the log, each as a whole.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::log::{LOG, Log};
use super::rows::{Kept, Rows};
use super::table::{self, Numeric};
use super::{Campaign, Row};
use cosim_base::error::{Code, Error, Result};
use cosim_base::files;

/// The results of a campaign.
pub struct Folder {
    pub(super) path: PathBuf,
    pub(super) log: Log,
    /// The octets of the log.
    length: u64,
    synced: Instant,
    rows: Rows,
    numeric: Numeric,
}

/// Rows are synced after this time.
const SYNC: Duration = Duration::from_secs(1);

/// The campaign to which the results belong.
#[derive(Serialize, Deserialize)]
pub(super) struct Manifest {
    pub(super) file: PathBuf,
    /// What the file and its list were: a report does without them.
    #[serde(default)]
    pub(super) text: String,
    #[serde(default)]
    pub(super) list: Option<String>,
    pub(super) identity: Vec<String>,
    pub(super) cells: Vec<String>,
    pub(super) figures: Vec<String>,
}

const MANIFEST: &str = "campaign.json";
pub(super) const TABLE: &str = "runs.parquet";
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
        std::fs::create_dir_all(&path).map_err(|e| {
            Error::new(Code::Output, "the results cannot be written").at(&path).why(e)
        })?;
        let log = Log::continued(&path)?;
        let manifest = path.join(MANIFEST);
        if manifest.exists() {
            let fit = fits(&Manifest::read(&path)?.identity, identity, &path);
            fit.map_err(|e| e.help("undo the change, or choose another --output-dir"))?;
        }
        let rows = Rows::new(campaign.figures.len(), &path);
        let (synced, numeric) = (Instant::now(), Numeric::new(campaign));
        let mut folder = Self { path, log, length: 0, synced, rows, numeric };
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
        let mut found = None;
        let log = Self::log_of(path.as_ref(), identity)?;
        // A line that is being written is not a row yet.
        let read = log.read(
            |row| (row.run == run).then_some(row),
            |line| found = found.take().or(line.row.ok().flatten()),
        );
        read.map_err(|e| log.unread(e))?;
        found.ok_or_else(|| {
            let what = format!("run {run} is not among the results");
            Error::new(Code::Results, what).at(&log.path)
        })
    }

    /// The log in a folder whose campaign has this identity.
    pub(super) fn log_of(path: &Path, identity: &[String]) -> Result<Log> {
        fits(&Manifest::read(path)?.identity, identity, path)?;
        let unread = |e| Error::new(Code::Results, "the rows cannot be read").at(path).why(e);
        Log::open(path).map_err(unread)
    }

    fn read_log(&mut self) -> Result<()> {
        let Self { log, rows, numeric, .. } = self;
        let (mut noted, mut wrong, mut texts) = (Ok(()), None, numeric.clone());
        let wanted = |row: Row| (numeric.texts(&row), Kept::from(row));
        let whole = log.read(wanted, |line| match line.row {
            // Nothing after it counts.
            _ if wrong.is_some() || noted.is_err() => (),
            Ok((places, row)) => {
                texts.note(&places);
                noted = rows.push(line.place, &row);
            }
            Err(why) => wrong = Some((line.number, line.place, why)),
        });
        *numeric = texts;
        self.length = whole.map_err(|e| log.unread(e))?.octets;
        noted?;
        if let Some((line, place, why)) = wrong {
            if !log.is_lost(place).map_err(|e| log.unread(e))? {
                let what = Error::new(Code::Results, "a row cannot be read");
                return Err(what.at_line(&log.path, line).why(why));
            }
            self.length = place;
        }
        let all = log.file.metadata().map_err(|e| log.unread(e))?.len();
        if self.length < all {
            log.file.set_len(self.length).map_err(|e| log.unread(e))?;
        }
        Ok(())
    }

    /// The existing rows, in order of arrival.
    pub fn rows(&self) -> &Rows {
        &self.rows
    }

    /// Adds a row.
    pub fn add(&mut self, row: &Row) -> Result<()> {
        let place = self.length;
        self.length += self.log.add(row)?;
        self.numeric.note(&self.numeric.texts(row));
        self.rows.push(place, &row.clone().into())?;
        if self.synced.elapsed() > SYNC { self.sync() } else { Ok(()) }
    }

    /// From now on, the rows survive a power loss.
    pub fn sync(&mut self) -> Result<()> {
        self.synced = Instant::now();
        files::synced(self.log.file.sync_data())
            .and_then(|()| files::sync_folder(&self.path))
            .map_err(|e| {
                Error::new(Code::Output, "the rows cannot be synced").at(&self.log.path).why(e)
            })
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
        let (log, rows) = (&self.log, &self.rows);
        self.write_by(TABLE, |file| {
            table::parquet(campaign, log, rows, &self.numeric, identity, file)
        })?;
        if csv {
            self.write_by("runs.csv", |file| table::csv(campaign, log, rows, file))?;
        }
        Ok(())
    }

    /// Writes a table of the rows as a whole.
    fn write_by(
        &self,
        name: &str,
        write: impl FnOnce(BufWriter<&File>) -> parquet::errors::Result<()>,
    ) -> Result<()> {
        let file = self.path.join(name);
        files::replace_by(&file, |file| write(BufWriter::new(file)).map_err(std::io::Error::other))
            .map_err(|e| {
                Error::new(Code::Output, "the table of runs cannot be written").at(&file).why(e)
            })
    }
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

impl Manifest {
    pub(super) fn read(path: &Path) -> Result<Self> {
        let file = path.join(MANIFEST);
        let unread = |e: String| {
            Error::new(Code::Results, "the folder holds no results of a campaign").at(&file).why(e)
        };
        let text = std::fs::read_to_string(&file).map_err(|e| unread(e.to_string()))?;
        serde_json::from_str(&text).map_err(|e| unread(e.to_string()))
    }
}

/// Fails with the first differences if the results belong to another campaign.
pub(super) fn fits(before: &[String], now: &[String], path: &Path) -> Result<()> {
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

    /// All rows, in order of arrival.
    fn rows(folder: &Folder) -> Vec<Row> {
        let all: Vec<usize> = (0..folder.rows().runs().len()).collect();
        folder.log.rows(&folder.rows().places(&all)).unwrap()
    }

    #[test]
    fn rows_outlive_the_process_and_a_line_cut_short_is_made_again() {
        let (folder, campaign) = (tempfile::tempdir().unwrap(), campaign());
        let identity = campaign.identity();
        let open = || Folder::open(folder.path(), &campaign, &identity);
        let mut first = open().unwrap();
        first.add(&row(2)).unwrap();
        first.add(&row(0)).unwrap();
        assert!(open().err().unwrap().to_string().contains("another process"));
        drop(first);
        let log = folder.path().join(LOG);
        let whole = std::fs::read(&log).unwrap();
        std::fs::write(&log, [&whole[..], b"{\"run\":1,\"sta"].concat()).unwrap();
        let mut second = open().unwrap();
        assert_eq!(rows(&second), [row(2), row(0)]);
        second.add(&row(1)).unwrap();
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
        (0..2).for_each(|run| first.add(&row(run)).unwrap());
        drop(first);
        let log = folder.path().join(LOG);
        let whole = std::fs::read(&log).unwrap();
        let second = serde_json::to_vec(&row(2)).unwrap();
        std::fs::write(&log, [&whole[..], &[0; 300], b"\n", &second, b"\n"].concat()).unwrap();
        let again = Folder::open(folder.path(), &campaign, &identity).unwrap();
        assert_eq!(rows(&again), [row(0), row(1)]);
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
