//! Changes from one campaign to another: figures of the same cells, run by run.

use serde::Serialize;

use super::rows::{ordered, pairs};
use super::statistics::{Estimate, quantile};
use super::{Campaign, Contents, Rows};
use cosim_base::error::Result;

/// A figure of a cell, now and before.
#[derive(Debug, Serialize)]
pub struct Change {
    /// The cell.
    pub cell: String,
    /// The figure.
    pub figure: String,
    /// Runs with the same number in their cell in both campaigns.
    pub pairs: usize,
    /// The median of now minus before, with 95 % confidence.
    pub difference: Estimate,
    /// The meaning of that.
    pub meaning: Meaning,
}

/// Whether a change is significant, and in which direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Meaning {
    /// It is better now.
    Better,
    /// It is worse now.
    Worse,
    /// The interval holds 0.
    Unclear,
}

/// Every figure that both campaigns have, without single instants, for the cells that both have.
/// Smaller is better, unless a threshold says `at-least`.
pub fn changes(campaign: &Campaign, rows: &Rows, past: &Contents) -> Result<Vec<Change>> {
    let paired = paired(campaign, rows, past);
    let mut changes = Vec::new();
    for (place, (figure, _)) in campaign.summarized().iter().enumerate() {
        let Some(old) = past.figures.iter().position(|known| known == figure) else { continue };
        let (now, before) = (rows.figure(place)?, past.rows.figure(old)?);
        for (cell, pairs) in &paired {
            let differences = pairs.iter().map(|(at, other)| now[*at] - before[*other]);
            let differences: Vec<f64> = differences.filter(|value| !value.is_nan()).collect();
            let difference = quantile(&differences, 0.5, 0.95);
            let [low, high] = difference.interval;
            let more = campaign.verdicts.iter().any(|t| t.figure == place && t.least.is_some());
            let meaning = match (low > 0.0, high < 0.0) {
                (false, false) => Meaning::Unclear,
                (grown, _) if grown == more => Meaning::Better,
                _ => Meaning::Worse,
            };
            let change = Change {
                cell: campaign.cell_name(*cell).to_owned(),
                figure: figure.clone(),
                pairs: differences.len(),
                difference,
                meaning,
            };
            changes.push((*cell, change));
        }
    }
    Ok(ordered(changes))
}

/// The cells that both campaigns have, and the rows of the same replicates of each.
fn paired(campaign: &Campaign, rows: &Rows, past: &Contents) -> Vec<(usize, Vec<(usize, usize)>)> {
    let count = past.cells.len().max(1) as u64;
    let mut before = vec![Vec::new(); past.cells.len()];
    for at in past.rows.in_order(u64::MAX) {
        let cell = before.get_mut((past.rows.runs()[at] % count) as usize);
        cell.into_iter().for_each(|cell: &mut Vec<usize>| cell.push(at));
    }
    let replicate = |at: usize| campaign.replicate_of(rows.runs()[at]) as u64;
    let old_replicate = |at: usize| past.rows.runs()[at] / count;
    let all = rows.by_cell(campaign, campaign.runs()).into_iter().enumerate();
    let both = all.filter_map(|(cell, own)| {
        let old = past.cells.iter().position(|known| known == campaign.cell_name(cell))?;
        Some((cell, pairs(&own, &before[old], replicate, old_replicate)))
    });
    both.collect()
}
