//! The table of goals, and the measures of every mission as a file.

use std::fmt::Write;

use anyhow::Context;

use super::goals::{Cells, Row};
use super::score::{CHANNELS, Score};
use super::system::folder;

/// Prints the table, and writes `table.md` and `results.csv`.
pub(crate) fn write(results: &[Cells<'_>], rows: &[Row]) -> anyhow::Result<()> {
    let table = table(rows);
    println!("{table}");
    for (name, text) in [("table.md", table), ("results.csv", csv(results)?)] {
        let file = folder()?.join(name);
        std::fs::write(&file, text).with_context(|| format!("cannot write {}", file.display()))?;
        println!("{}", file.display());
    }
    Ok(())
}

fn table(rows: &[Row]) -> String {
    let header = ["cell", "filter", "quantity", "reached", "95 %", "goal", "spec", "verdict"];
    let mut lines = vec![header.map(str::to_owned)];
    for Row { cell, filter, verdict, reference } in rows {
        let [low, high] = verdict.interval;
        let has_goal = verdict.low.is_finite() || verdict.high.is_finite();
        let (goal, word) = match has_goal {
            true => (verdict.bounds(), verdict.word()),
            false => Default::default(),
        };
        lines.push([
            cell.clone(),
            (*filter).to_owned(),
            verdict.what.clone(),
            verdict.value(),
            format!("{low:.3} to {high:.3}"),
            goal,
            (*reference).to_owned(),
            word.split(':').next().unwrap_or_default().to_owned(),
        ]);
    }
    let width = |i: usize| lines.iter().map(|l| l[i].chars().count()).max().unwrap_or_default();
    let widths: [usize; 8] = std::array::from_fn(width);
    lines.insert(1, widths.map(|width| "-".repeat(width)));
    let mut text = String::new();
    for line in lines {
        for (cell, width) in line.iter().zip(widths) {
            text += &format!("| {cell:<width$} ");
        }
        text += "|\n";
    }
    text
}

/// Measures that are one number.
type Measure = (&'static str, fn(&Score) -> f64);
const MEASURES: [Measure; 18] = [
    ("rmse_m", |s| s.rmse),
    ("x_rmse_m", |s| s.axes[0]),
    ("y_rmse_m", |s| s.axes[1]),
    ("settled_rmse_m", |s| s.settled),
    ("settled_depth_rmse_m", |s| s.depth),
    ("settled_heading_rmse_rad", |s| s.heading),
    ("settled_variance_m2", |s| s.variance),
    ("window_rmse_m", |s| s.window),
    ("last_error_m", |s| s.last),
    ("last_nees2", |s| s.last_nees),
    ("detected_after_s", |s| s.detected),
    ("right_thruster", |s| f64::from(u8::from(s.right))),
    ("false_alarms", |s| s.false_alarms),
    ("hours", |s| s.hours),
    ("total_m", |s| s.total),
    ("vertical_m", |s| s.vertical),
    ("finished", |s| f64::from(u8::from(s.finished))),
    ("load", |s| s.load),
];

fn csv(results: &[Cells<'_>]) -> anyhow::Result<String> {
    let mut text = "cell,filter,seed".to_owned();
    for (name, _) in MEASURES {
        write!(text, ",{name}")?;
    }
    for (name, _) in CHANNELS {
        write!(text, ",nis_{name}")?;
    }
    text.push('\n');
    for Cells { cell, scores, .. } in results {
        for (filter, scores) in scores {
            for (seed, score) in (1..).zip(scores) {
                write!(text, "{},{},{seed}", cell.name, filter.name())?;
                for (_, measure) in MEASURES {
                    write!(text, ",{}", measure(score))?;
                }
                for [sum, number] in score.nis {
                    write!(text, ",{}", sum / number)?;
                }
                text.push('\n');
            }
        }
    }
    Ok(text)
}
