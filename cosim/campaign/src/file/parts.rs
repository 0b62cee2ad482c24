//! The parts of a campaign file.

use std::path::PathBuf;

use cosim_base::names::Aliases;
use cosim_core::table::Entry;

/// A system of the campaign.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Source {
    pub(crate) file: PathBuf,
    /// The names by which the campaign and its scenarios refer to its components and variables.
    pub(crate) names: Aliases,
    /// Components that are omitted.
    pub(crate) without: Vec<String>,
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
pub(crate) struct Replacement {
    pub(crate) name: String,
    pub(crate) components: Vec<(String, PathBuf)>,
}

/// Runs of each cell whose trajectories are kept.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Keep {
    /// How many with the worst value of a figure, given by its position.
    pub(crate) worst: usize,
    pub(crate) figure: usize,
    /// How many others, the first ones.
    pub(crate) sample: usize,
    /// Also those that failed.
    pub(crate) failed: bool,
}

/// A figure that is evaluated over time.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OverTime {
    pub(crate) figure: String,
    /// The interval between instants (s).
    pub(crate) every: f64,
    /// The number of axes of a normalised error squared; `None` for an error, whose claimed
    /// deviation follows it.
    pub(crate) axes: Option<usize>,
    /// The position of its value at each instant among all figures.
    pub(crate) instants: Vec<usize>,
}

/// A scenario.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Scene {
    /// The file with its faults.
    pub(crate) faults: Option<PathBuf>,
    pub(crate) start_values: Vec<(String, String)>,
}

/// A bound on a figure.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Threshold {
    pub(crate) figure: usize,
    pub(crate) quantile: f64,
    pub(crate) least: Option<f64>,
    pub(crate) most: Option<f64>,
    pub(crate) confidence: f64,
    /// A pattern for the cells to which it applies.
    pub(crate) cells: String,
}

/// A combination of everything that is not random: positions in the lists of the campaign.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cell {
    pub(crate) system: usize,
    pub(crate) replacement: usize,
    pub(crate) scenario: usize,
    pub(crate) levels: Vec<usize>,
    pub(crate) row: Option<usize>,
    pub(crate) name: String,
}
