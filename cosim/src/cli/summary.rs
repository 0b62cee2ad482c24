//! The summary of a run as text and as JSON.

use cosim::Overruns;
use cosim::shown;
use cosim::{Summary, System};
use serde_json::{Value, json};

/// The outcome of a run.
pub(crate) struct RunResult<'a> {
    pub system: &'a System,
    pub summary: &'a Summary,
    /// Seconds of wall-clock time.
    pub spent: f64,
    pub target: &'a str,
    pub overruns: Option<Overruns>,
    /// Digest of all recorded values.
    pub digest: String,
}

/// How many components are listed individually.
const SHOWN: usize = 20;

/// A line for the whole run and a table of the components; if there are many, those that took the
/// most time.
pub(crate) fn text(result: &RunResult) -> String {
    let RunResult { system, summary, spent, target, overruns, digest } = result;
    let mut lines = table(summary);
    if let Some(o) = overruns {
        lines.push(match o.count {
            0 => format!("real time: no overrun, {} instants", o.instants),
            _ => format!(
                "real time: {} of {} instants overrun, the worst {:.3} ms late at t = {}",
                o.count,
                o.instants,
                o.worst * 1e3,
                o.when
            ),
        });
    }
    lines.push(format!("digest {digest}"));
    lines.push(format!(
        "{}: {} s simulated in {spent:.3} s ({:.0} x real time, {} steps); results in {target}",
        system.name(),
        summary.simulated,
        summary.simulated / spent.max(1e-9),
        summary.steps,
    ));
    lines.join("\n")
}

fn table(summary: &Summary) -> Vec<String> {
    let mut components: Vec<_> = summary.components.iter().collect();
    if components.len() > SHOWN {
        components.sort_by(|a, b| b.share.total_cmp(&a.share));
    }
    let rest = components.split_off(components.len().min(SHOWN));
    let width = shown::width(components.iter().map(|c| c.name.as_str())).max(9);
    let head = ["component", "steps", "rejected", "us/step", "share"];
    let mut lines = vec![format!(
        "{:width$} {:>12} {:>9} {:>10} {:>7}",
        head[0], head[1], head[2], head[3], head[4]
    )];
    lines.extend(components.iter().map(|c| {
        format!(
            "{:width$} {:>12} {:>9} {:>10.3} {:>5.1} %",
            c.name,
            c.steps,
            c.rejected,
            c.seconds_per_step * 1e6,
            c.share * 100.0
        )
    }));
    if !rest.is_empty() {
        let share: f64 = rest.iter().map(|c| c.share).sum();
        lines.push(format!(
            "and {} more with {:.1} % in total (--format json has them all)",
            rest.len(),
            share * 100.0
        ));
    }
    lines
}

/// The same as JSON, in SI units.
pub(crate) fn json(result: &RunResult) -> Value {
    let RunResult { system, summary, spent, target, overruns, digest } = result;
    let warnings = [system.warnings(), &summary.warnings].concat();
    json!({
        "name": system.name(),
        "simulated": summary.simulated,
        "spent": spent,
        "steps": summary.steps,
        "stopped": summary.stopped.map(|reason| format!("{reason:?}")),
        "results": target,
        "digest": digest,
        "components": summary.components.iter().map(|c| json!({
            "name": c.name,
            "steps": c.steps,
            "rejected": c.rejected,
            "secondsPerStep": c.seconds_per_step,
            "share": c.share,
        })).collect::<Vec<_>>(),
        "realTime": overruns.map(|o| json!({
            "instants": o.instants,
            "overruns": o.count,
            "worst": o.worst,
            "when": o.when.seconds(),
        })),
        "columns": system.columns().iter().map(|c| json!({
            "name": c.name,
            "type": c.kind.name(),
        })).collect::<Vec<_>>(),
        "warnings": warnings,
        "notes": summary.notes,
        "messages": summary.messages,
    })
}
