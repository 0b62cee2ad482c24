//! `cosim campaign --merge`: merges the results of shards into those of one campaign.

use cosim::campaign::{self, Bench, Folder};
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
        results.merge(&self.merge, &identity)?;
        let judgement = self.conclude(&bench, &identity, &results)?;
        let all = bench.campaign().runs();
        let there = results.rows().made(all);
        let missing: Vec<u64> = (0..all).filter(|run| !there[*run as usize]).collect();
        if !missing.is_empty() {
            return Err(incomplete(&missing, all));
        }
        keep(&bench, output, results)?;
        verdict(&judgement)
    }
}

fn incomplete(missing: &[u64], all: u64) -> Error {
    let named: Vec<String> = missing.iter().take(NAMED).map(u64::to_string).collect();
    let rest = if missing.len() > NAMED { ", …" } else { "" };
    Error::new(Code::Campaign, format!("{} of {all} runs are missing", missing.len()))
        .why(format!("there is no row of {}{rest}", named.join(", ")))
        .help("run the shards again, then merge again")
}
