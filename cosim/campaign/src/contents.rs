//! What is in the folder of a campaign, for readers that change nothing and skip what they cannot
//! read.

use std::path::{Path, PathBuf};

use super::folder::{Manifest, TABLE, fits};
use super::log::{LOG, Log};
use super::rows::{Kept, Rows};
use super::{Campaign, Row, table};
use cosim_base::error::Result;

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
    pub rows: Rows,
    log: Option<Log>,
    /// What cannot be read, and why.
    pub notes: Vec<String>,
}

impl Contents {
    /// The contents of a folder.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let Manifest { file, text, list, identity, cells, figures } = Manifest::read(path)?;
        let (log, rows, notes) = rows_alone(path, figures.len())?;
        Ok(Self { campaign: file, text, list, identity, cells, figures, rows, log, notes })
    }

    /// These rows, as they are in the log.
    pub(super) fn logged(&self, rows: &[usize]) -> Result<Vec<Row>> {
        let log = self.log.as_ref();
        log.map_or(Ok(Vec::new()), |log| log.rows(&self.rows.places(rows)))
    }

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

/// What is wrong with the table of the rows in a folder.
pub(super) fn table_note(path: &Path, rows: u64) -> Option<String> {
    let problem = match table::runs(&path.join(TABLE)) {
        Ok(runs) if runs == rows => return None,
        Ok(runs) => format!("has {runs} of {rows} runs"),
        Err(why) => format!("cannot be read: {why}"),
    };
    Some(format!("{TABLE} {problem}; run cosim campaign again to write it anew"))
}

/// The log of a folder, the rows that can be read with so many figures, and what cannot be read.
pub(super) fn rows_alone(path: &Path, figures: usize) -> Result<(Option<Log>, Rows, Vec<String>)> {
    const SHOWN: usize = 5;
    let (mut rows, mut notes) = (Rows::new(figures, path), Vec::new());
    let log = match Log::open(path) {
        Ok(log) => log,
        Err(e) => {
            notes.push(format!("{} cannot be read: {e}", path.join(LOG).display()));
            return Ok((None, rows, notes));
        }
    };
    let (mut lost, mut noted) = (0, Ok(()));
    let whole = log.read(Kept::from, |line| match line.row {
        Ok(row) if noted.is_ok() => noted = rows.push(line.place, &row),
        Ok(_) => (),
        Err(e) => {
            lost += 1;
            if lost <= SHOWN {
                notes.push(format!("line {} of {LOG} is not a row: {e}", line.number));
            }
        }
    });
    noted?;
    if lost > SHOWN {
        notes.push(format!("{} more lines of {LOG} are not rows", lost - SHOWN));
    }
    match (whole, log.file.metadata()) {
        (Err(e), _) => notes.push(format!("{LOG} cannot be read to its end: {e}")),
        (Ok(whole), Ok(file)) if whole.octets < file.len() => {
            notes.push(format!("line {} of {LOG} is incomplete", whole.lines + 1));
        }
        _ => {}
    }
    Ok((Some(log), rows, notes))
}
