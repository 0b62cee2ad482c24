//! Changes from one campaign to another: figures of the same cells, run by run.

use std::collections::HashMap;

use serde::Serialize;

use super::statistics::{Estimate, quantile};
use super::{Campaign, Contents, Row};

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

/// Every figure that both campaigns have, without single instants, for the cells that both have. Smaller is better, unless a
/// threshold says `at-least`.
pub fn changes(campaign: &Campaign, rows: &[Row], past: &Contents) -> Vec<Change> {
    let mut before: HashMap<(&str, u64), &Row> = HashMap::new();
    let count = past.cells.len().max(1) as u64;
    for row in &past.rows {
        if let Some(cell) = past.cells.get((row.run % count) as usize) {
            before.insert((cell, row.run / count), row);
        }
    }
    let mut changes = Vec::new();
    for cell in 0..campaign.cells() {
        let name = campaign.cell_name(cell);
        if !past.cells.iter().any(|known| known == name) {
            continue;
        }
        for (place, (figure, _)) in campaign.summarized().iter().enumerate() {
            let Some(old) = past.figures.iter().position(|known| known == figure) else { continue };
            let own = rows
                .iter()
                .filter(|row| row.run < campaign.runs() && campaign.cell_of(row.run) == cell);
            let differences = own.filter_map(|row| {
                let other = before.get(&(name, campaign.replicate_of(row.run) as u64))?;
                let difference = row.figure(place) - other.figure(old);
                (!difference.is_nan()).then_some(difference)
            });
            let differences: Vec<f64> = differences.collect();
            let difference = quantile(&differences, 0.5, 0.95);
            let [low, high] = difference.interval;
            let more = campaign.verdicts.iter().any(|t| t.figure == place && t.least.is_some());
            let meaning = match (low > 0.0, high < 0.0) {
                (false, false) => Meaning::Unclear,
                (grown, _) if grown == more => Meaning::Better,
                _ => Meaning::Worse,
            };
            changes.push(Change {
                cell: name.to_owned(),
                figure: figure.clone(),
                pairs: differences.len(),
                difference,
                meaning,
            });
        }
    }
    changes
}
