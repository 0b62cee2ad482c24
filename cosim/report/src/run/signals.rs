//! All recorded variables: plots by component and group, and a table.

use serde::Serialize;

use super::columns::Columns;
use super::plots::{Role, Whole};
use crate::grouping::{self, Signal};
use crate::numbers::rounded;
use crate::statistics::mean;
use crate::units::Units;

/// A row of the table of variables.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Row {
    name: String,
    unit: String,
    /// First, last, minimum, mean, maximum; null if there is none.
    values: [Option<f64>; 5],
    not_finite: usize,
}

/// How many variables are listed in the table, and how many are plotted.
const LISTED: usize = 5_000;
const PLOTTED: usize = 2_000;

/// The table, and a note if it is incomplete.
pub(super) fn table(columns: &Columns<'_>, units: &Units) -> (Vec<Row>, Option<String>) {
    let row = |name: &&str| {
        let values = columns.get(name)?;
        let finite: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        let known = |value: Option<f64>| value.map(|v| rounded(v, 5)).filter(|v| v.is_finite());
        Some(Row {
            name: (*name).to_owned(),
            unit: units.unit(name).unwrap_or_default().to_owned(),
            values: [
                known(values.first().copied()),
                known(values.last().copied()),
                known(finite.iter().copied().reduce(f64::min)),
                known(Some(mean(&finite))),
                known(finite.iter().copied().reduce(f64::max)),
            ],
            not_finite: values.len() - finite.len(),
        })
    };
    let all = columns.names.len();
    let note = (all > LISTED).then(|| {
        format!("the table has {LISTED} of {all} variables: the others are in the results")
    });
    (columns.names.iter().take(LISTED).filter_map(row).collect(), note)
}

/// Plots of variables that change; a note on the rest.
pub(super) fn plots(columns: &Columns<'_>, units: &Units) -> (Vec<Whole>, Option<String>) {
    let changes = |values: &[f64]| {
        let mut finite = values.iter().filter(|value| value.is_finite());
        let first = finite.next();
        first.is_some_and(|first| finite.any(|value| value != first))
    };
    let changing = columns.names.iter().filter_map(|name| {
        let values = columns.get(name).filter(|values| changes(values))?;
        Some(Signal { name: (*name).to_owned(), unit: units.unit(name), values })
    });
    let mut signals: Vec<Signal<'_>> = changing.collect();
    let note = (signals.len() > PLOTTED).then(|| {
        format!(
            "{PLOTTED} of {} variables that change are plotted: select others with --plot",
            signals.len()
        )
    });
    signals.truncate(PLOTTED);
    let plots = grouping::components(signals).into_iter().flat_map(|component| {
        let section =
            if component.name.is_empty() { "variables".to_owned() } else { component.name };
        component.groups.into_iter().map(move |group| Whole {
            section: section.clone(),
            title: group.name,
            unit: group.unit.unwrap_or_default(),
            lines: group.signals.into_iter().map(|(n, v)| (n, Role::Signal, v)).collect(),
            ..Whole::default()
        })
    });
    (plots.collect(), note)
}

/// Signals of actuators: arrays of forces, and everything about health.
pub(super) fn system(columns: &Columns<'_>, units: &Units) -> Vec<Whole> {
    const HEALTH: [&str; 5] = ["health", "status", "mode", "alarm", "fault"];
    let (mut forces, mut plots) = (Vec::new(), Vec::new());
    for name in &columns.names {
        let leaf = name.rsplit('.').next().unwrap_or(name);
        if name.contains('[') && units.unit(name) == Some("N") {
            let Some(values) = columns.get(name) else { continue };
            forces.push(Signal { name: (*name).to_owned(), unit: Some("N"), values });
        } else if HEALTH.contains(&leaf.split('[').next().unwrap_or(leaf)) {
            plots.push(Whole {
                section: "Health".into(),
                title: (*name).into(),
                unit: units.unit(name).unwrap_or_default().into(),
                lines: vec![(leaf.into(), Role::Signal, columns.get(name).unwrap_or_default())],
                steps: true,
                ..Whole::default()
            });
        }
    }
    let mut all = Vec::new();
    for component in grouping::components(forces) {
        let name = component.name;
        all.extend(component.groups.into_iter().map(|group| Whole {
            section: "Thrust".into(),
            title: format!("{name}.{}", group.name),
            unit: "N".into(),
            lines: group.signals.into_iter().map(|(n, v)| (n, Role::Signal, v)).collect(),
            ..Whole::default()
        }));
    }
    all.extend(plots);
    all
}
