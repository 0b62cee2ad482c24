//! `cosim campaign`: many runs, stored one by one, and their statistics.

mod keep;
mod merge;
mod pool;
mod render;
mod shard;
mod worker;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use cosim::campaign::{self, Answer, Bench, Contents, Folder, Judgement};
use cosim::confine::reap_descendants;
use cosim::{Code, Error, Result};
use indicatif::{ProgressBar, ProgressStyle};

use super::output::print;
use super::{Format, interrupt, messages, problems};

pub(crate) use worker::CampaignWorker;

/// Run many variations of a system (seeds, parameters, components, faults) and judge the results
#[derive(Args)]
pub(crate) struct Campaign {
    /// The campaign (TOML)
    #[arg(required_unless_present = "merge")]
    file: Option<PathBuf>,
    /// Folder for the results; results that are already there are continued (default: NAME_campaign
    /// in the current folder)
    #[arg(long, value_name = "FOLDER")]
    output_dir: Option<PathBuf>,
    /// Make only the runs of this part, such as 1/8, in a subfolder of the output folder; auto
    /// takes both numbers from a Slurm array, auto/8 takes the first one from a Slurm array or an
    /// indexed Kubernetes job
    #[arg(long, value_name = "I/N")]
    shard: Option<shard::Shard>,
    /// Merge the results of shards, and judge them
    #[arg(
        long,
        value_name = "FOLDER",
        num_args = 1..,
        requires = "output_dir",
        conflicts_with_all = ["file", "shard", "dry_run", "jobs"]
    )]
    merge: Vec<PathBuf>,
    /// Number of parallel runs (default: one per core)
    #[arg(long, short, value_name = "N")]
    jobs: Option<std::num::NonZeroUsize>,
    /// Check everything and estimate the number of runs, their duration and the size of the
    /// results; one run is made for the estimate
    #[arg(long)]
    dry_run: bool,
    /// Report which figures became significantly better or worse than in the results in this folder
    #[arg(long, value_name = "FOLDER")]
    compare: Option<PathBuf>,
    /// Also write runs.csv beside runs.parquet
    #[arg(long)]
    csv: bool,
    /// Format of the summary on stdout
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Show no progress and no summary
    #[arg(long, short)]
    quiet: bool,
}

/// Interval at which the verdicts so far are updated.
const LOOK: Duration = Duration::from_secs(5);

impl Campaign {
    pub(crate) fn run(self) -> Result<()> {
        interrupt::listen();
        // What FMUs start in the processes that make runs ends with them.
        reap_descendants();
        problems::reported(self.format, self.computed())
    }

    fn computed(&self) -> Result<()> {
        let Some(file) = &self.file else {
            return self.merged();
        };
        let bench = Bench::open(campaign::Campaign::read(file)?)?;
        bench.check()?;
        let past = self.compare.as_ref().map(Contents::read).transpose()?;
        let identity = bench.identity()?;
        let cores = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let jobs = self.jobs.map_or_else(cores, std::num::NonZero::get);
        let pool = pool::Pool::new(&bench, &identity, jobs)?;
        if self.dry_run {
            return self.estimate(&bench, &pool, jobs);
        }
        let mut folder = self.output_dir.clone().unwrap_or_else(|| {
            let name = file.file_stem().unwrap_or_default().to_string_lossy();
            PathBuf::from(format!("{name}_campaign"))
        });
        if let Some(shard) = self.shard {
            if bench.campaign().looks().len() > 1 {
                return Err(Error::new(Code::Usage, "a sequential campaign has no shards")
                    .why("which runs it makes depends on all previous runs")
                    .help("remove --shard, or `sequential` from the file"));
            }
            folder.push(shard.folder());
        }
        let mut results = Folder::open(&folder, bench.campaign(), &identity)?;
        let outcome = self.make(&bench, &pool, &mut results);
        results.sync()?;
        let judgement = self.conclude(&bench, &identity, &results)?;
        if let Some(past) = past {
            let changes = campaign::changes(bench.campaign(), results.rows(), &past)?;
            results.write("changes.json", render::json(&changes)?)?;
            if self.format == Format::Text && !self.quiet {
                print(&render::changes(&changes))?;
            }
        }
        outcome?;
        if self.shard.is_none() {
            keep::keep(&bench, &folder, results)?;
        }
        if interrupt::interrupted() {
            return Err(Error::new(Code::Interrupted, "the campaign was interrupted")
                .why(format!("{} of {} runs are done", judgement.runs, bench.campaign().runs()))
                .help("run the same command again to continue"));
        }
        match self.shard {
            // The result of one part is not a verdict.
            Some(_) => Ok(()),
            None => verdict(&judgement),
        }
    }

    fn make(&self, bench: &Bench, pool: &pool::Pool<'_>, results: &mut Folder) -> Result<()> {
        let campaign = bench.campaign();
        let over = results.rows().made(campaign.runs());
        let wanted = |run: &u64| self.shard.is_none_or(|shard| shard.has(*run, campaign.cells()));
        let left = |run: &u64| wanted(run) && !over[*run as usize];
        let all = (0..campaign.runs()).filter(wanted).count();
        let count = (0..campaign.runs()).filter(left).count();
        if count < all && !self.quiet {
            messages::note(&format!("{} of {all} runs are already done", all - count));
        }
        let bar = if self.quiet { ProgressBar::hidden() } else { bar(count as u64) };
        let (mut failed, mut looked) = (0, Instant::now());
        let mut cells: Vec<usize> = (0..campaign.cells()).collect();
        let (mut outcome, mut begin) = (Ok(()), 0);
        for end in campaign.looks() {
            // Results of other blocks, such as those of an earlier run, are counted later.
            let block = (begin..end).flat_map(|replicate| {
                cells.iter().map(move |cell| (replicate * campaign.cells() + cell) as u64)
            });
            outcome = pool.make(block.filter(left), &mut |row| {
                failed += u64::from(row.status != campaign::Status::Ok);
                results.add(&row)?;
                bar.inc(1);
                if looked.elapsed() > LOOK {
                    looked = Instant::now();
                    let judgement = Judgement::new(campaign, results.rows())?;
                    bar.set_message(format!("{failed} failed; {}", render::counted(&judgement)));
                }
                Ok(())
            });
            if outcome.is_err() || interrupt::interrupted() || end == campaign.seeds {
                break;
            }
            let until = (end * campaign.cells()) as u64;
            let open = Judgement::until(campaign, results.rows(), until)?.open_cells(campaign);
            cells.retain(|cell| open.contains(cell));
            begin = end;
        }
        bar.finish_and_clear();
        outcome
    }

    /// Writes everything derived from the rows, and prints the summary.
    fn conclude(&self, bench: &Bench, identity: &[String], results: &Folder) -> Result<Judgement> {
        let campaign = bench.campaign();
        let (judgement, written) = std::thread::scope(|scope| {
            let table = scope.spawn(|| results.write_table(campaign, identity, self.csv));
            (Judgement::new(campaign, results.rows()), table.join())
        });
        written.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
        let judgement = judgement?;
        let json = render::json(&judgement)?;
        results.write("summary.json", &json)?;
        results.write("junit.xml", render::junit(&judgement))?;
        if self.format == Format::Json {
            print(&json)?;
        } else if !self.quiet && self.shard.is_none() {
            print(&render::text(&judgement))?;
        }
        Ok(judgement)
    }

    fn estimate(&self, bench: &Bench, pool: &pool::Pool<'_>, jobs: usize) -> Result<()> {
        let campaign = bench.campaign();
        let mut first = None;
        pool.make(std::iter::once(0), &mut |row| {
            first = Some(row);
            Ok(())
        })?;
        let Some(row) = first else {
            return Err(Error::new(Code::Interrupted, "the campaign was interrupted"));
        };
        if row.status != campaign::Status::Ok {
            return Err(Error::new(Code::Fmu, "the first run fails").why(row.reason));
        }
        let seconds = row.cpu_ms.0 / 1e3 * campaign.runs() as f64;
        let octets = serde_json::to_vec(&row).map_or(0, |row| row.len()) as u64 * campaign.runs();
        print(&format!(
            "{} cells of {} runs: {} runs\nabout {} on {jobs} cores ({} ms of processor time for \
             the first run)\nabout {:.1} MB of results",
            campaign.cells(),
            campaign.seeds,
            campaign.runs(),
            render::span(seconds / jobs as f64),
            row.cpu_ms,
            // The log and the table.
            1.6 * octets as f64 / 1e6
        ))
    }
}

fn bar(count: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} runs, {eta} left; {msg}");
    let bar = ProgressBar::new(count);
    style.map_or(bar.clone(), |style| bar.with_style(style))
}

fn verdict(judgement: &Judgement) -> Result<()> {
    let count = |wanted: fn(&Answer) -> bool| {
        judgement.verdicts.iter().filter(|verdict| wanted(&verdict.answer)).count()
    };
    let all = judgement.verdicts.len();
    let missed = count(|answer| *answer == Answer::Fail);
    if missed > 0 {
        let what = format!("{missed} of {all} thresholds are not met");
        return Err(Error::new(Code::Missed, what));
    }
    let open = count(|answer| matches!(answer, Answer::Undecided(_)));
    if open > 0 {
        let what = format!("{open} of {all} thresholds are undecided");
        return Err(Error::new(Code::Undecided, what)
            .help("raise `seeds` in the file and run the same command again"));
    }
    Ok(())
}
