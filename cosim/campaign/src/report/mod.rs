//! The report of a campaign: one page with the verdict, the matrix of cells, each cell, and some
//! runs in full. It stays below five megabytes whatever the number of runs.

mod cells;
mod outage;
mod sample;
mod shown;

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;

use self::cells::{Cell, Main, Source, urgency};
use self::outage::Outages;
use self::sample::{Input, Sampling};
use super::judgement::Judgement;
use super::{Answer, Bench, Campaign, Contents};
use cosim_base::error::{Error, Result};
use cosim_report::{Block, Document, Section, Table, Term, Trace, Units};

/// How a campaign is reported.
#[derive(Debug, Clone, Default)]
pub struct Report {
    /// Title of the page; by default the name of the campaign.
    pub title: Option<String>,
    /// How many runs of each cell are repeated and shown in full: the worst, the median, others.
    pub runs_per_cell: usize,
    /// Runs that are shown in full in any case.
    pub also: Vec<u64>,
    /// The number of runs of each cell, if it is not that of the file.
    pub seeds: Option<usize>,
    /// Paragraphs below the verdict.
    pub summary: Vec<String>,
    /// Text, tables and pictures below the matrix.
    pub sections: Vec<Section>,
}

/// Maximum size in octets of the cells, and of all data.
const CELLS: usize = 2_000_000;
const ALL: usize = 4_500_000;
/// A run that is shown in full has at least this many octets, or it is omitted.
const RUN: usize = 16_000;

/// The campaign as data of the page.
#[derive(Serialize)]
struct CampaignData<'a> {
    folder: String,
    /// The folder, quoted for a shell.
    folder_quoted: String,
    runs: u64,
    expected: u64,
    failed: u64,
    seeds: usize,
    answer: &'static str,
    /// How many thresholds pass, fail and are undecided.
    answers: [usize; 3],
    main: usize,
    figures: Vec<Figure>,
    inputs: Vec<Input>,
    levels: Vec<&'a str>,
    cells: Vec<Cell<'a>>,
}

#[derive(Serialize)]
struct Figure {
    name: String,
    what: String,
    unit: String,
    small_is_bad: bool,
}

/// The page of the campaign whose results are in a folder, and notes on what is missing. `more` is
/// called before each run that is repeated, with the number of runs that are left; if it returns
/// false, the rest is not shown. Fails if the folder is evidently not that of a campaign.
pub fn report(
    folder: &Path,
    options: &Report,
    more: &mut dyn FnMut(usize) -> bool,
) -> Result<(String, Vec<String>)> {
    let read = Contents::read(folder).and_then(|mut contents| {
        let mut read = || contents.read_campaign(folder);
        let both = (read()?, read()?);
        Ok((contents, both))
    });
    let (mut contents, (mut campaign, mut repeated)) = match read {
        Ok(read) => read,
        Err(problem) => return remains(folder, options, problem),
    };
    campaign.seeds = options.seeds.unwrap_or(campaign.seeds);
    repeated.seeds = campaign.seeds;
    contents.notes.dedup();
    let mut notes = contents.notes.clone();
    let bench = shown::bench(repeated, &contents);
    let units = match &bench {
        Ok(bench) => bench.units(0, &["*".to_owned()]).unwrap_or_default(),
        Err(_) => Units::default(),
    };
    let judgement = Judgement::new(&campaign, &contents.rows)?;
    let source = source(&campaign, &contents, &judgement, &units, options)?;
    let main = source.main.figure;
    let unit = |name: &str| units.unit(name).unwrap_or_default().to_owned();
    let outages = bench.as_ref().map(Outages::of).unwrap_or_default();
    let mut sampling = Sampling::new(&campaign, &contents, folder, outages, unit)?;
    let mut cells = fitting(&source, &mut sampling, &mut notes)?;
    let used = octets(&cells) + octets(&options.sections);
    let mut runs = BTreeMap::new();
    let plan = shown::plan(&cells);
    if !plan.is_empty() {
        let space = ALL.saturating_sub(used);
        let most = space / RUN;
        if plan.len() > most {
            let left = plan.len() - most;
            notes.push(format!("{left} runs do not fit on this page: replay them one by one"));
        }
        let (contents, rows) = (&contents, &source.rows);
        let made = shown::Shown { bench, campaign: &campaign, contents, rows };
        runs = made.make(&plan[..plan.len().min(most)], space, &mut cells, more);
    }
    missing(&campaign, &judgement, &mut notes);
    let table = super::contents::table_note(folder, judgement.runs);
    notes.extend(table.clone());
    let document = Document {
        title: options.title.clone().unwrap_or_else(|| name(&campaign)),
        question: campaign.description.clone(),
        summary: options.summary.clone(),
        sections: options.sections.clone(),
        notes: notes.clone(),
        method: method(&campaign),
        provenance: provenance(&campaign, &contents, table.is_none().then_some(folder)),
        identity: identity(&contents),
        campaign: Some(campaign_data(&campaign, folder, &judgement, &units, main, sampling, cells)),
        runs,
    };
    Ok((document.html()?, notes))
}

fn source<'a>(
    campaign: &'a Campaign,
    contents: &'a Contents,
    judgement: &'a Judgement,
    units: &Units,
    options: &'a Report,
) -> Result<Source<'a>> {
    let recorded = units.names();
    let freedom =
        campaign.summarized().iter().map(|(_, figure)| figure.freedom(&recorded)).collect();
    Ok(Source {
        campaign,
        judgement,
        contents,
        rows: contents.rows.by_cell(campaign, campaign.runs()),
        freedom,
        main: Main::of(campaign, &contents.rows)?,
        runs_per_cell: options.runs_per_cell,
        also: &options.also,
    })
}

/// All cells, with as many points as there is space for; if there is none, only the urgent cells.
fn fitting<'a>(
    source: &Source<'a>,
    sampling: &mut Sampling,
    notes: &mut Vec<String>,
) -> Result<Vec<Cell<'a>>> {
    let count = source.campaign.cells();
    // A number has about seven octets.
    let of_point = 8 * (1 + sampling.figures + sampling.inputs.len());
    sampling.replicates = CELLS / 2 / (of_point * count);
    let mut cells = source.cells(sampling)?;
    let used = octets(&cells);
    if used > ALL - RUN {
        cells.sort_by_key(urgency);
        let kept = (count * CELLS / used).max(1);
        cells.truncate(kept);
        let left = count - kept;
        notes
            .push(format!("{left} of {count} cells do not fit on this page: summary.json has all"));
    }
    let points = source.rows.iter().map(Vec::len).max().unwrap_or(0);
    if sampling.replicates < points {
        notes.push(format!(
            "points are those of the first {} runs of each cell, of the worst and of those shown in \
             full: numbers, quantiles and verdicts are of all",
            sampling.replicates
        ));
    }
    Ok(cells)
}

/// The size on the page, where `<` is written as `\u003c`.
fn octets(of: &impl Serialize) -> usize {
    let escaped = |octets: &[u8]| octets.iter().filter(|octet| **octet == b'<').count();
    serde_json::to_vec(of).map_or(0, |octets| octets.len() + 5 * escaped(&octets))
}

fn missing(campaign: &Campaign, judgement: &Judgement, notes: &mut Vec<String>) {
    let left = campaign.runs() - judgement.runs;
    if left > 0 {
        notes.push(format!(
            "{left} of {} runs have not been made yet: run cosim campaign again to make them",
            campaign.runs()
        ));
    }
    if campaign.summarized().is_empty() {
        notes.push("the campaign has no figures".to_owned());
    }
}

fn campaign_data<'a>(
    campaign: &'a Campaign,
    folder: &Path,
    judgement: &Judgement,
    units: &Units,
    main: usize,
    sampling: Sampling,
    cells: Vec<Cell<'a>>,
) -> CampaignData<'a> {
    let count = |wanted: fn(&Answer) -> bool| {
        judgement.verdicts.iter().filter(|verdict| wanted(&verdict.answer)).count()
    };
    let answers = [
        count(|answer| *answer == Answer::Pass),
        count(|answer| *answer == Answer::Fail),
        count(|answer| matches!(answer, Answer::Undecided(_))),
    ];
    let figure = |(place, (name, figure)): (usize, &(String, super::figure::Figure))| Figure {
        name: name.clone(),
        what: figure.words(),
        unit: figure.unit(units),
        small_is_bad: cells::small_is_bad(campaign, place),
    };
    let folder = folder.display().to_string();
    CampaignData {
        folder_quoted: format!("'{}'", folder.replace('\'', "'\\''")),
        folder,
        runs: judgement.runs,
        expected: campaign.runs(),
        failed: judgement.failed,
        seeds: campaign.seeds,
        answer: match answers {
            [0, 0, 0] => "none",
            [_, 0, 0] => "pass",
            [_, 0, _] => "undecided",
            _ => "fail",
        },
        answers,
        main,
        figures: campaign.summarized().iter().enumerate().map(figure).collect(),
        levels: campaign
            .factors
            .iter()
            .map(|(name, _)| name.as_str())
            .chain(campaign.list.parameters.iter().map(String::as_str))
            .collect(),
        inputs: sampling.inputs,
        cells,
    }
}

fn name(campaign: &Campaign) -> String {
    campaign.file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn method(campaign: &Campaign) -> Vec<Term> {
    let mut terms: Vec<Term> = campaign
        .summarized()
        .iter()
        .map(|(name, f)| Term::new(format!("Figure {name}"), f.words()))
        .collect();
    for (term, text) in [
        (
            "Verdict",
            "A threshold bounds a quantile over all possible runs. The exact interval of the \
             share of runs that meet it (Clopper and Pearson 1934) decides: wholly on one side it \
             passes or fails, else it is undecided. A run without figures meets no bound.",
        ),
        (
            "Intervals",
            "Medians and percentiles have 95 % intervals by order statistics (David and Nagaraja \
             2003, 7.1): they make no assumption about the distribution.",
        ),
        (
            "Paired comparison",
            "Runs of one replicate have the same seeds and dispersions in all cells. The \
             difference is formed run by run, and its median is given.",
        ),
        (
            "Sensitivity",
            "Spearman's rank correlation of a figure with a dispersed parameter over the runs of a \
             cell: 1 if it always grows with it, -1 if it always falls, 0 if neither. The outage \
             length is the time of a run during which faults of the kind drop-out act.",
        ),
        (
            "Consistency",
            "NEES and NIS of a consistent filter are chi-square distributed. The mean over n runs \
             of k degrees of freedom lies in [χ²(0.025, n k), χ²(0.975, n k)] / n with 95 %, if a \
             run counts as one sample; a figure is itself a mean over time, so it spreads less.",
        ),
        (
            "Errors over time",
            "Quantiles of the errors of all runs of the cell at each instant, 5 % to 95 % and 25 % to \
             75 %, beside three times the median of the standard deviations that the estimator \
             claims: 99.7 % of normal errors with these deviations are within.",
        ),
        (
            "Box plots",
            "Box from the 25 % to the 75 % quantile, bar at the median, whiskers at 5 % and 95 %.",
        ),
    ] {
        terms.push(Term::new(term, text));
    }
    terms.extend(cosim_report::run_terms());
    terms
}

/// What the page is from; `folder` is given if its table has all runs.
fn provenance(campaign: &Campaign, contents: &Contents, folder: Option<&Path>) -> Vec<Term> {
    let rest = folder.map(|folder| {
        let table = folder.join("runs.parquet");
        let what = "has a row for each run: its parameters, figures and digest";
        Term::new("All runs", format!("{} {what}", table.display()))
    });
    let mut terms = vec![
        Term::new("Campaign", contents.campaign.display().to_string()),
        Term::new("Root seed", campaign.seed.to_string()),
        Term::new("Runs of each cell", campaign.seeds.to_string()),
        Term::new("Identity (SHA-256)", super::fingerprint(&contents.identity)),
        reported_by(),
    ];
    terms.extend(rest);
    terms
}

fn reported_by() -> Term {
    Term::new("Reported by", concat!("cosim ", env!("CARGO_PKG_VERSION")))
}

/// What the log alone says, where the folder's campaign cannot be read; the problem if it is another
/// folder.
fn remains(folder: &Path, options: &Report, problem: Error) -> Result<(String, Vec<String>)> {
    let Some(mut notes) = super::folder::missing(folder) else { return Err(problem) };
    let (_, rows, unread) = super::contents::rows_alone(folder, 0)?;
    let (mut sections, mut why) = (Vec::new(), problem.line());
    if !rows.runs().is_empty() {
        why = format!("only the states of runs are shown: {why}");
        let mut table = Table::new("Runs by how they ended", &["state", "runs"]);
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        let all = rows.in_order(u64::MAX).into_iter();
        all.for_each(|at| *counts.entry(rows.status(at).word()).or_default() += 1);
        counts
            .into_iter()
            .for_each(|(state, runs)| table.push([state.to_owned(), runs.to_string()]));
        sections.push(Section { heading: "Runs".to_owned(), blocks: vec![Block::Table(table)] });
    }
    notes.push(why);
    notes.extend(unread);
    let stem = || folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let document = Document::<()> {
        title: options.title.clone().unwrap_or_else(stem),
        question: String::new(),
        summary: Vec::new(),
        sections,
        notes: notes.clone(),
        method: Vec::new(),
        provenance: vec![reported_by()],
        identity: Vec::new(),
        campaign: None,
        runs: BTreeMap::new(),
    };
    Ok((document.html()?, notes))
}

/// Files and their hashes first.
fn identity(contents: &Contents) -> Vec<String> {
    const LINES: usize = 400;
    let (mut files, others): (Vec<&String>, Vec<&String>) =
        contents.identity.iter().partition(|line| line.contains(" is "));
    let count = files.len() + others.len();
    files.extend(others);
    let mut lines: Vec<String> = files.into_iter().take(LINES).cloned().collect();
    if count > LINES {
        lines.push(format!("and {} more lines: campaign.json", count - LINES));
    }
    lines
}

/// A run that was repeated, by its number.
type Runs = BTreeMap<String, Trace>;

#[cfg(test)]
mod tests;
