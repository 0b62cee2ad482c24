//! Results of a campaign as text, as JSON, and for continuous integration.

use std::fmt::Write;

use cosim::campaign::{Answer, Change, Estimate, Judgement, Meaning};
use cosim::{Code, Error, Result};
use serde::Serialize;

/// As JSON; infinite values become null.
pub(super) fn json(what: &impl Serialize) -> Result<String> {
    serde_json::to_string_pretty(what)
        .map_err(|e| Error::new(Code::Output, "the summary cannot be written").why(e))
}

/// How many verdicts there are of each kind.
pub(super) fn counted(judgement: &Judgement) -> String {
    let count = |wanted: fn(&Answer) -> bool| {
        judgement.verdicts.iter().filter(|verdict| wanted(&verdict.answer)).count()
    };
    format!(
        "{} pass, {} fail, {} undecided",
        count(|answer| *answer == Answer::Pass),
        count(|answer| *answer == Answer::Fail),
        count(|answer| matches!(answer, Answer::Undecided(_)))
    )
}

/// A duration as text.
pub(super) fn span(seconds: f64) -> String {
    if seconds < 90.0 {
        format!("{seconds:.0} s")
    } else if seconds < 5400.0 {
        format!("{:.0} min", seconds / 60.0)
    } else {
        format!("{:.1} h", seconds / 3600.0)
    }
}

fn word(answer: &Answer) -> String {
    match answer {
        Answer::Pass => "pass".to_owned(),
        Answer::Fail => "FAIL".to_owned(),
        Answer::Undecided(Some(more)) => format!("undecided: {more} more seeds"),
        Answer::Undecided(None) => "undecided: it is too close to the threshold".to_owned(),
    }
}

fn number(value: f64) -> String {
    match value {
        v if v == f64::INFINITY => "inf".to_owned(),
        v if v == f64::NEG_INFINITY => "-inf".to_owned(),
        v if v != 0.0 && !(1e-3..1e6).contains(&v.abs()) => format!("{v:.3e}"),
        v => format!("{v:.4}"),
    }
}

fn estimate(estimate: &Estimate) -> String {
    let [low, high] = estimate.interval.map(number);
    format!("{} [{low}, {high}]", number(estimate.value))
}

/// As text tables.
pub(super) fn text(judgement: &Judgement) -> String {
    let mut text = format!("{} runs, {} without figures\n", judgement.runs, judgement.failed);
    let figures = judgement.figures.iter().map(|f| {
        [
            f.cell.clone(),
            f.figure.clone(),
            f.runs.to_string(),
            estimate(&f.median),
            estimate(&f.percentile_95),
        ]
    });
    text += &table(["cell", "figure", "runs", "median [95 %]", "95th percentile [95 %]"], figures);
    if !judgement.compared.is_empty() {
        let compared = judgement.compared.iter().map(|c| {
            let (pairs, difference) = (c.pairs.to_string(), estimate(&c.difference));
            [c.with.clone(), c.cell.clone(), c.figure.clone(), pairs, difference]
        });
        text += &table(["cell", "minus", "figure", "pairs", "median difference [95 %]"], compared);
    }
    let consistent = consistent(judgement);
    if !consistent.is_empty() {
        let head = ["cell", "over time", "mean", "instants within the 95 % band", ""];
        text += &table(head, consistent.into_iter());
    }
    if !judgement.verdicts.is_empty() {
        let verdicts = judgement.verdicts.iter().map(|v| {
            [
                v.cell.clone(),
                v.figure.clone(),
                v.threshold.clone(),
                format!("{} of {}", v.kept, v.runs),
                word(&v.answer),
            ]
        });
        text += &table(["cell", "figure", "threshold", "runs that meet it", "verdict"], verdicts);
        text += &format!("\n{}", counted(judgement));
    }
    text.trim_end().to_owned()
}

/// The significant changes as a text table.
pub(super) fn changes(changes: &[Change]) -> String {
    let clear = changes.iter().filter(|change| change.meaning != Meaning::Unclear);
    let rows: Vec<[String; 5]> = clear
        .map(|change| {
            let word = if change.meaning == Meaning::Better { "better" } else { "WORSE" };
            [
                change.cell.clone(),
                change.figure.clone(),
                change.pairs.to_string(),
                estimate(&change.difference),
                word.to_owned(),
            ]
        })
        .collect();
    let summary = format!("{} of {} figures have changed significantly", rows.len(), changes.len());
    if rows.is_empty() {
        return summary;
    }
    let head = ["cell", "figure", "pairs", "median difference [95 %]", ""];
    format!("{}\n{summary}", table(head, rows.into_iter()))
}

/// How many instants lie within their band, per cell and figure.
fn consistent(judgement: &Judgement) -> Vec<[String; 5]> {
    let mut rows: Vec<([String; 2], usize, usize, f64)> = Vec::new();
    for at in &judgement.consistency {
        let key = [at.cell.clone(), at.figure.clone()];
        let inside = usize::from(at.band[0] <= at.mean && at.mean <= at.band[1]);
        match rows.last_mut().filter(|(known, ..)| *known == key) {
            Some((_, within, all, sum)) => {
                (*within, *all, *sum) = (*within + inside, *all + 1, *sum + at.mean);
            }
            None => rows.push((key, inside, 1, at.mean)),
        }
    }
    let row = |([cell, figure], within, all, sum): ([String; 2], usize, usize, f64)| {
        let share = format!("{within} of {all}");
        [cell, figure, number(sum / all as f64), share, String::new()]
    };
    rows.into_iter().map(row).collect()
}

fn table(head: [&str; 5], rows: impl Iterator<Item = [String; 5]>) -> String {
    let rows: Vec<[String; 5]> = std::iter::once(head.map(str::to_owned)).chain(rows).collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max();
    let widths: [usize; 5] = std::array::from_fn(|column| width(column).unwrap_or(0));
    let mut text = String::from("\n");
    for row in &rows {
        let cells = row.iter().zip(widths).map(|(cell, width)| format!("{cell:width$}"));
        text += cells.collect::<Vec<_>>().join("  ").trim_end();
        text.push('\n');
    }
    text
}

/// As JUnit XML: a test for each threshold of each cell; an undecided one is an error.
pub(super) fn junit(judgement: &Judgement) -> String {
    let count = |wanted: fn(&Answer) -> bool| {
        judgement.verdicts.iter().filter(|verdict| wanted(&verdict.answer)).count()
    };
    let (failures, errors) = (
        count(|answer| *answer == Answer::Fail),
        count(|answer| matches!(answer, Answer::Undecided(_))),
    );
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"campaign\" tests=\"{}\" \
         failures=\"{failures}\" errors=\"{errors}\">\n",
        judgement.verdicts.len()
    );
    for verdict in &judgement.verdicts {
        let (cell, name) =
            (escaped(&verdict.cell), format!("{} {}", verdict.figure, verdict.threshold));
        _ = write!(text, "  <testcase classname=\"{cell}\" name=\"{}\"", escaped(&name));
        let message = format!(
            "{} of {} runs meet it; it is {}",
            verdict.kept,
            verdict.runs,
            estimate(&verdict.quantile)
        );
        let element = match verdict.answer {
            Answer::Pass => {
                text += "/>\n";
                continue;
            }
            Answer::Fail => "failure",
            Answer::Undecided(_) => "error",
        };
        _ = writeln!(
            text,
            "><{element} message=\"{}\">{}</{element}></testcase>",
            escaped(&word(&verdict.answer)),
            escaped(&message)
        );
    }
    text + "</testsuite>\n"
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
