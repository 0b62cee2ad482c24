//! The file of a campaign.

mod list;
mod parts;
mod read;

use std::path::{Path, PathBuf};

use self::list::List;
pub(super) use self::parts::{Cell, Keep, OverTime, Replacement, Scene, Source, Threshold};
pub(super) use self::read::read_figures;
use super::design::{Design, Distribution};
use super::figure::Figure;
use cosim_base::error::{Code, Error, Result};
use cosim_core::scenario::Condition;

/// Which runs to make, and what to evaluate.
#[derive(Debug)]
pub struct Campaign {
    /// The file.
    pub file: PathBuf,
    /// Its text, and that of the list: kept with the results.
    pub(super) text: String,
    pub(super) list_text: Option<String>,
    /// The question that it answers; may be empty.
    pub description: String,
    /// The number from which all random numbers are derived.
    pub seed: u64,
    /// The number of runs of each cell.
    pub seeds: usize,
    pub(super) systems: Vec<(String, Source)>,
    pub(super) replacements: Vec<Replacement>,
    pub(super) scenarios: Vec<(String, Scene)>,
    pub(super) factors: Vec<(String, Vec<String>)>,
    pub(super) list: List,
    pub(super) dispersions: Vec<(String, Distribution)>,
    pub(super) design: Design,
    pub(super) start_values: Vec<(String, String)>,
    pub(super) seed_parameters: Vec<String>,
    /// Seeds that are counted: those of the first replicate, and the distance between them.
    pub(super) counted_seeds: Vec<(String, [u64; 2])>,
    pub(super) stop_time: Option<f64>,
    pub(super) output_interval: Option<f64>,
    pub(super) stop_when: Vec<Condition>,
    /// Time limit of a run (s); a run that takes longer has failed.
    pub time_limit: f64,
    pub(super) figures: Vec<(String, Figure)>,
    /// Figures that are evaluated over time.
    pub(super) over_time: Vec<OverTime>,
    /// Which runs are repeated and kept in full.
    pub(super) keep: Keep,
    /// No further runs are made of cells whose thresholds are decided.
    pub(super) sequential: bool,
    pub(super) verdicts: Vec<Threshold>,
    pub(super) cells: Vec<Cell>,
}

/// A sequential campaign checks its thresholds for the first time after this many seeds.
const FIRST_LOOK: usize = 10;

impl Campaign {
    /// Reads a file; paths in it are relative to its folder.
    pub fn read(file: impl AsRef<Path>) -> Result<Self> {
        let file = file.as_ref();
        let unread = |e| Error::new(Code::File, "the campaign cannot be read").at(file).why(e);
        let file = std::path::absolute(file).map_err(unread)?;
        let text = cosim_base::files::read_input_text(&file).map_err(unread)?;
        Self::parse(&text, &file)
    }

    pub(super) fn parse(text: &str, file: &Path) -> Result<Self> {
        Self::parse_with(text, file, None)
    }

    /// The cells, and what a file omits.
    fn fill(&mut self) {
        if self.replacements.is_empty() {
            self.replacements.push(Replacement { name: String::new(), components: Vec::new() });
        }
        if self.scenarios.is_empty() {
            self.scenarios.push((String::new(), Scene::default()));
        }
        let rows: Vec<Option<usize>> = match self.list.rows.len() {
            0 => vec![None],
            count => (0..count).map(Some).collect(),
        };
        let mut levels = vec![Vec::new()];
        for (_, values) in &self.factors {
            let longer = levels.iter().flat_map(|before: &Vec<usize>| {
                (0..values.len()).map(move |level| [&before[..], &[level]].concat())
            });
            levels = longer.collect();
        }
        for system in 0..self.systems.len() {
            for replacement in 0..self.replacements.len() {
                for scenario in 0..self.scenarios.len() {
                    for levels in &levels {
                        for row in &rows {
                            let (levels, row) = (levels.clone(), *row);
                            let mut cell = Cell {
                                system,
                                replacement,
                                scenario,
                                levels,
                                row,
                                name: String::new(),
                            };
                            cell.name = self.name_of(&cell);
                            self.cells.push(cell);
                        }
                    }
                }
            }
        }
    }

    /// What distinguishes a cell from others.
    fn name_of(&self, cell: &Cell) -> String {
        let mut parts = vec![self.systems[cell.system].0.clone()];
        parts.push(self.replacements[cell.replacement].name.clone());
        parts.extend(self.conditions(cell));
        parts.retain(|part| !part.is_empty());
        parts.join("/")
    }

    /// Under which conditions the alternatives of a cell are compared: its scenario, the levels of
    /// its factors, its row of the list.
    pub(super) fn conditions(&self, cell: &Cell) -> Vec<String> {
        let mut parts = vec![self.scenarios[cell.scenario].0.clone()];
        for ((name, values), level) in self.factors.iter().zip(&cell.levels) {
            parts.push(format!("{name}={}", values[*level]));
        }
        parts.extend(cell.row.map(|row| self.list.labels[row].clone()));
        parts.retain(|part| !part.is_empty());
        parts
    }

    /// The total number of runs.
    pub fn runs(&self) -> u64 {
        (self.cells.len() * self.seeds) as u64
    }

    /// After how many seeds of each cell the thresholds are checked: once at the end, or, in a
    /// sequential campaign, whenever their number has doubled.
    pub fn looks(&self) -> Vec<usize> {
        let first = if self.sequential { FIRST_LOOK } else { self.seeds };
        let doubled = std::iter::successors(Some(first), |looked| looked.checked_mul(2));
        doubled.take_while(|looked| *looked < self.seeds).chain([self.seeds]).collect()
    }

    /// The number of cells: combinations of everything that is not random.
    pub fn cells(&self) -> usize {
        self.cells.len()
    }

    /// The name of a cell.
    pub fn cell_name(&self, cell: usize) -> &str {
        &self.cells[cell].name
    }

    /// The cell of a run: all cells have their first run before any has its second.
    pub fn cell_of(&self, run: u64) -> usize {
        (run % self.cells.len() as u64) as usize
    }

    /// The position of a run among the runs of its cell.
    pub fn replicate_of(&self, run: u64) -> usize {
        (run / self.cells.len() as u64) as usize
    }

    /// Names of the figures.
    pub fn figures(&self) -> impl Iterator<Item = &str> {
        self.figures.iter().map(|(name, _)| name.as_str())
    }

    /// The figures that summaries cover: all except those at single instants, which come after
    /// them.
    pub(super) fn summarized(&self) -> &[(String, Figure)] {
        let count = self.figures.iter().filter(|(_, figure)| figure.instant().is_none()).count();
        &self.figures[..count]
    }

    /// Names of the parameters that differ from run to run or from cell to cell, without seeds.
    pub(super) fn inputs(&self) -> impl Iterator<Item = &str> {
        let factors = self.factors.iter().map(|(name, _)| name.as_str());
        let list = self.list.parameters.iter().map(String::as_str);
        factors.chain(list).chain(self.dispersions.iter().map(|(name, _)| name.as_str()))
    }

    /// Everything in the file that determines a run, as lines of text. The rest may change between
    /// two parts of a campaign: thresholds, time limits, and the number of seeds if that moves no
    /// point.
    pub(super) fn identity(&self) -> Vec<String> {
        let mut lines = vec![format!("seed = {}, design = {:?}", self.seed, self.design)];
        if self.design == Design::LatinHypercube {
            lines.push(format!("seeds = {}", self.seeds));
        }
        lines.extend(self.cells.iter().map(|cell| format!("cell {}", cell.name)));
        let List { parameters, rows, .. } = &self.list;
        lines.extend(rows.iter().map(|row| format!("list {parameters:?} = {row:?}")));
        lines.extend(self.dispersions.iter().map(|(n, d)| format!("dispersion {n} = {d:?}")));
        lines.extend(self.start_values.iter().map(|(n, v)| format!("start value {n} = {v}")));
        let scenes = self.scenarios.iter().filter(|(_, scene)| !scene.start_values.is_empty());
        lines.extend(scenes.map(|(name, scene)| format!("{name}: {:?}", scene.start_values)));
        for (name, Source { names, without, .. }) in &self.systems {
            lines.extend(names.pairs().iter().map(|(a, meant)| format!("{name}: {a} is {meant}")));
            lines.extend(without.iter().map(|component| format!("{name} is without {component}")));
        }
        lines.push(format!("sequential = {}", self.sequential));
        lines.push(format!("seed-parameters = {:?}", self.seed_parameters));
        lines.extend(self.counted_seeds.iter().map(|(name, by)| format!("seed {name}: {by:?}")));
        lines.push(format!("stop-time = {:?}", self.stop_time));
        lines.push(format!("output-interval = {:?}", self.output_interval));
        let conditions: Vec<String> = self.stop_when.iter().map(Condition::to_string).collect();
        lines.push(format!("stop-when = {conditions:?}"));
        lines.extend(
            self.summarized().iter().map(|(name, figure)| format!("figure {name} = {figure:?}")),
        );
        let axes = |over: &OverTime| (over.figure.clone(), over.axes.unwrap_or(0));
        let over_time: Vec<(String, usize)> = self.over_time.iter().map(axes).collect();
        lines.push(format!("over time = {over_time:?}"));
        let every = |over: &OverTime| format!("figure {} every {} s", over.figure, over.every);
        lines.extend(self.over_time.iter().map(every));
        lines
    }
}

#[cfg(test)]
mod tests;
