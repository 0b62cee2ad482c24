//! `cosim campaign --merge`: merges the results of shards into those of one campaign.

use std::collections::BTreeMap;
use std::path::Path;

use cosim::campaign::{self, Bench, Folder, Row};
use cosim::{Code, Error, Result};

use super::keep::keep;
use super::{Campaign, verdict};

/// How many missing runs are listed.
const NAMED: usize = 5;

impl Campaign {
    /// Merges the rows, and judges them.
    pub(super) fn merged(&self) -> Result<()> {
        let (Some(first), Some(output)) = (self.merge.first(), &self.output_dir) else {
            return Err(Error::new(Code::Usage, "--merge needs folders and --output-dir"));
        };
        let bench = Bench::open(campaign::Campaign::read(Folder::campaign(first)?)?)?;
        let identity = bench.identity()?;
        let mut results = Folder::open(output, bench.campaign(), &identity)?;
        let own = results.rows().iter().cloned().map(|row| (row.run, (output.as_path(), row)));
        let mut all: BTreeMap<u64, (&Path, Row)> = own.collect();
        let mut new = Vec::new();
        for folder in &self.merge {
            for row in Folder::rows_of(folder, &identity)? {
                match all.get(&row.run) {
                    Some((_, other)) if other.agrees(&row) => {}
                    Some((other, _)) => return Err(parted(row.run, other, folder)),
                    None => {
                        new.push(row.run);
                        all.insert(row.run, (folder, row));
                    }
                }
            }
        }
        new.sort_unstable();
        for run in new {
            if let Some((_, row)) = all.get(&run) {
                results.add(row.clone())?;
            }
        }
        let judgement = self.conclude(&bench, &identity, &results)?;
        let missing: Vec<u64> =
            (0..bench.campaign().runs()).filter(|run| !all.contains_key(run)).collect();
        if !missing.is_empty() {
            return Err(incomplete(&missing, bench.campaign().runs()));
        }
        keep(&bench, output, results)?;
        verdict(&judgement)
    }
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

fn incomplete(missing: &[u64], all: u64) -> Error {
    let named: Vec<String> = missing.iter().take(NAMED).map(u64::to_string).collect();
    let rest = if missing.len() > NAMED { ", …" } else { "" };
    Error::new(Code::Campaign, format!("{} of {all} runs are missing", missing.len()))
        .why(format!("there is no row of {}{rest}", named.join(", ")))
        .help("run the shards again, then merge again")
}
