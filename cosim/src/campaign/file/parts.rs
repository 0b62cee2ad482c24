//! The parts of a campaign file.

use std::path::PathBuf;

use crate::names::Aliases;
use crate::table::Entry;

/// A system of the campaign.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::campaign) struct Source {
    pub(in crate::campaign) file: PathBuf,
    /// The names by which the campaign and its scenarios refer to its components and variables.
    pub(in crate::campaign) names: Aliases,
    /// Components that are omitted.
    pub(in crate::campaign) without: Vec<String>,
}

impl Source {
    /// From a file name, or a table with it; the file is relative to `path`.
    pub(super) fn read(entry: &Entry<'_>, path: impl Fn(&str) -> PathBuf) -> Option<Self> {
        if !entry.is_table() {
            let file = path(entry.text()?);
            return Some(Self { file, names: Aliases::default(), without: Vec::new() });
        }
        let table = entry.table()?;
        table.allow(&["file", "names", "without"]);
        let names = table.table("names").map(|names| {
            let pairs = names.entries();
            pairs.filter_map(|(alias, meant)| Some((alias.to_owned(), meant.text()?.to_owned())))
        });
        let names = Aliases::new(names.into_iter().flatten().collect());
        let without = table.texts("without").into_iter().map(str::to_owned).collect();
        Some(Self { file: path(table.needed_text("file")?), names, without })
    }
}

/// The replacements of components.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::campaign) struct Replacement {
    pub(in crate::campaign) name: String,
    pub(in crate::campaign) components: Vec<(String, PathBuf)>,
}

/// Runs of each cell whose trajectories are kept.
#[derive(Debug, Clone, Default, PartialEq)]
pub(in crate::campaign) struct Keep {
    /// How many with the worst value of a figure, given by its position.
    pub(in crate::campaign) worst: usize,
    pub(in crate::campaign) figure: usize,
    /// How many others, the first ones.
    pub(in crate::campaign) sample: usize,
    /// Also those that failed.
    pub(in crate::campaign) failed: bool,
}

/// A figure that is evaluated over time.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::campaign) struct OverTime {
    pub(in crate::campaign) figure: String,
    /// The interval between instants (s).
    pub(in crate::campaign) every: f64,
    /// The number of axes of a normalised error squared; `None` for an error, whose claimed
    /// deviation follows it.
    pub(in crate::campaign) axes: Option<usize>,
    /// The position of its value at each instant among all figures.
    pub(in crate::campaign) instants: Vec<usize>,
}

/// A scenario.
#[derive(Debug, Clone, Default, PartialEq)]
pub(in crate::campaign) struct Scene {
    /// The file with its faults.
    pub(in crate::campaign) faults: Option<PathBuf>,
    pub(in crate::campaign) start_values: Vec<(String, String)>,
}

/// A bound on a figure.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::campaign) struct Threshold {
    pub(in crate::campaign) figure: usize,
    pub(in crate::campaign) quantile: f64,
    pub(in crate::campaign) least: Option<f64>,
    pub(in crate::campaign) most: Option<f64>,
    pub(in crate::campaign) confidence: f64,
    /// A pattern for the cells to which it applies.
    pub(in crate::campaign) cells: String,
}

/// A combination of everything that is not random: positions in the lists of the campaign.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::campaign) struct Cell {
    pub(in crate::campaign) system: usize,
    pub(in crate::campaign) replacement: usize,
    pub(in crate::campaign) scenario: usize,
    pub(in crate::campaign) levels: Vec<usize>,
    pub(in crate::campaign) row: Option<usize>,
    pub(in crate::campaign) name: String,
}
