//! The file of a campaign.

mod list;
mod parts;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use self::list::List;
pub(super) use self::parts::{Cell, Keep, OverTime, Replacement, Scene, Source, Threshold};
use super::design::{DESIGNS, Design, Distribution, Points};
use super::figure::Figure;
use cosim_base::error::{Code, Error, Result};
use cosim_base::names;
use cosim_core::scenario::Condition;
use cosim_core::table::{Document, Table};

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

/// The most runs of a campaign, and octets of what distinguishes its cells.
const MOST_RUNS: usize = 10_000_000;
const MOST_OF_CELLS: usize = 256 << 20;

/// A sequential campaign checks its thresholds for the first time after this many seeds.
const FIRST_LOOK: usize = 10;

const KEYS: [&str; 20] = [
    "description",
    "seed",
    "seeds",
    "sequential",
    "systems",
    "replacements",
    "scenarios",
    "factors",
    "list",
    "dispersions",
    "design",
    "start-values",
    "seed-parameters",
    "stop-time",
    "output-interval",
    "stop-when",
    "time-limit",
    "keep",
    "figures",
    "verdict",
];

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

    /// From the text of a file and, if it no longer exists, that of its list.
    pub(super) fn parse_with(text: &str, file: &Path, list_text: Option<&str>) -> Result<Self> {
        let document = Document::new(text, file, Code::Campaign);
        let parsed = document.parse()?;
        let root = document.root(&parsed);
        root.allow(&KEYS);
        let folder = file.parent().unwrap_or(Path::new("")).to_owned();
        let path = |text: &str| folder.join(text);
        let mut campaign = Self {
            file: file.to_owned(),
            text: text.to_owned(),
            list_text: None,
            description: root.text("description").unwrap_or_default().to_owned(),
            seed: root.count("seed").unwrap_or(0),
            seeds: root.count("seeds").unwrap_or(1) as usize,
            systems: named(&root, "systems", |entry| Source::read(entry, path)),
            replacements: named(&root, "replacements", |entry| {
                let table = entry.table()?;
                let parts = table.entries();
                let parts = parts.map(|(name, e)| Some((name.to_owned(), path(e.text()?))));
                parts.collect::<Option<Vec<_>>>()
            })
            .into_iter()
            .map(|(name, components)| Replacement { name, components })
            .collect(),
            scenarios: named(&root, "scenarios", |entry| {
                let file = |text: &str| (!text.is_empty()).then(|| path(text));
                if !entry.is_table() {
                    return Some(Scene { faults: file(entry.text()?), start_values: Vec::new() });
                }
                let table = entry.table()?;
                table.allow(&["faults", "start-values"]);
                let start_values = named(&table, "start-values", |entry| entry.start_value());
                Some(Scene { faults: table.text("faults").and_then(file), start_values })
            }),
            factors: named(&root, "factors", |entry| {
                if !entry.is_list() || entry.list().is_empty() {
                    entry.wrong("a list of values is expected");
                }
                entry.list().iter().map(|value| value.start_value()).collect()
            }),
            list: List::default(),
            dispersions: named(&root, "dispersions", |e| Distribution::read(&e.table()?)),
            design: design(&root),
            start_values: named(&root, "start-values", |entry| entry.start_value()),
            seed_parameters: match root.get("seed-parameters") {
                Some(entry) if !entry.is_table() => {
                    entry.texts().into_iter().map(str::to_owned).collect()
                }
                _ => vec!["*.seed".to_owned()],
            },
            counted_seeds: counted_seeds(&root),
            stop_time: root.number("stop-time"),
            output_interval: root.positive("output-interval"),
            stop_when: conditions(&root),
            time_limit: root.positive("time-limit").unwrap_or(300.0),
            figures: read_figures(&root),
            over_time: Vec::new(),
            keep: Keep::default(),
            sequential: root.number("sequential").is_some_and(|value| value != 0.0),
            verdicts: Vec::new(),
            cells: Vec::new(),
        };
        if campaign.seeds == 0 {
            document
                .wrong(root.get("seeds").map_or(1, |e| e.line), "'seeds' is 0: there is no run");
        }
        if campaign.systems.is_empty() {
            root.wrong("[systems] is missing: names and files of systems");
        }
        if let Some(list) = root.text("list") {
            let file = path(list);
            let text = match list_text {
                Some(text) => Ok(text.to_owned()),
                None => cosim_base::files::read_input_text(&file).map_err(|e| {
                    Error::new(Code::File, "the list cannot be read").at(&file).why(e)
                }),
            };
            match text.and_then(|text| Ok((List::read(&file, &text)?, text))) {
                Ok((read, text)) => (campaign.list, campaign.list_text) = (read, Some(text)),
                Err(problem) => document.note(problem),
            }
        }
        campaign.follow_over_time(&root);
        campaign.check_names(&root);
        if let Some(table) = root.table("keep") {
            campaign.keep = campaign.read_keep(&table);
        }
        campaign.verdicts =
            root.tables("verdict").iter().filter_map(|table| campaign.threshold(table)).collect();
        if campaign.is_too_large() {
            root.wrong(format!("there are more than {MOST_RUNS} runs, or too many cells"));
        }
        document.finish()?;
        campaign.fill();
        Ok(campaign)
    }

    /// Adds the figures at single instants of those with `every`.
    fn follow_over_time(&mut self, root: &Table<'_>) {
        let Some(tables) = root.table("figures") else { return };
        for (name, entry) in tables.entries() {
            let Some(table) = entry.table().filter(|table| table.get("every").is_some()) else {
                continue;
            };
            let Some((_, figure)) = self.figures.iter().find(|(known, _)| known == name) else {
                continue;
            };
            let (Some(every), Some(stop)) = (table.positive("every"), self.stop_time) else {
                table.wrong("'every' needs the campaign's stop-time");
                continue;
            };
            let axes = figure.axes().or(table.count("dimension").map(|count| count as usize));
            let axes = axes.filter(|axes| *axes > 0);
            if (axes.is_none() && !figure.is_error()) || stop / every > 1000.0 {
                table.wrong(
                    "'every' needs the 'dimension' of the innovation, and at most 1000 instants",
                );
                continue;
            }
            let (figure, mut instants) = (figure.clone(), Vec::new());
            for count in 1..=(stop / every + 1e-9) as u32 {
                let at = f64::from(count) * every;
                instants.push(self.figures.len());
                let named = |(more, figure)| (at_instant(name, more, at), figure);
                self.figures.extend(figure.at(at).into_iter().map(named));
            }
            self.over_time.push(OverTime { figure: name.to_owned(), every, axes, instants });
        }
    }

    /// Whether its runs would take too much memory: a few factors multiply to any number.
    fn is_too_large(&self) -> bool {
        let several = [self.systems.len(), self.replacements.len(), self.scenarios.len()];
        let levels = self.factors.iter().map(|(_, values)| values.len());
        let all = several.into_iter().chain([self.list.rows.len()]).chain(levels);
        let cells = all.fold(1_usize, |cells, count| cells.saturating_mul(count.max(1)));
        let longest = |lengths: &mut dyn Iterator<Item = usize>| lengths.max().unwrap_or(0);
        let names = longest(&mut self.systems.iter().map(|(name, _)| name.len()))
            + longest(&mut self.replacements.iter().map(|replacement| replacement.name.len()))
            + longest(&mut self.scenarios.iter().map(|(name, _)| name.len()));
        let factor = |(name, values): &(String, Vec<String>)| {
            name.len() + longest(&mut values.iter().map(String::len))
        };
        let each = size_of::<Cell>() + names + self.factors.iter().map(factor).sum::<usize>();
        let each = each.saturating_add(2 * size_of::<usize>() * self.factors.len());
        cells.saturating_mul(self.seeds) > MOST_RUNS || cells.saturating_mul(each) > MOST_OF_CELLS
    }

    /// No parameter may be set twice.
    fn check_names(&self, root: &Table<'_>) {
        let mut seen: HashMap<&str, &str> = HashMap::new();
        let factors = self.factors.iter().map(|(name, _)| (name.as_str(), "factors"));
        let dispersions = self.dispersions.iter().map(|(name, _)| (name.as_str(), "dispersions"));
        let list = self.list.parameters.iter().map(|name| (name.as_str(), "list"));
        for (name, by) in factors.chain(dispersions).chain(list) {
            if let Some(before) = seen.insert(name, by) {
                root.wrong(format!("'{name}' is set by {before} and by {by}"));
            }
        }
        let most = Points::most(self.design);
        if self.dispersions.len() > most {
            root.wrong(format!(
                "the design has at most {most} dispersions, and there are {}",
                self.dispersions.len()
            ));
        }
    }

    fn read_keep(&self, table: &Table<'_>) -> Keep {
        table.allow(&["worst", "figure", "sample", "failed"]);
        let count = |key: &str| table.count(key).unwrap_or(0) as usize;
        Keep {
            worst: count("worst"),
            figure: table.get("figure").and_then(|_| self.figure(table)).unwrap_or(0),
            sample: count("sample"),
            failed: table.number("failed").is_some_and(|value| value != 0.0),
        }
    }

    /// The position of the figure that a table names.
    fn figure(&self, table: &Table<'_>) -> Option<usize> {
        let name = table.needed_text("figure")?;
        let figure = self.figures.iter().position(|(known, _)| known == name);
        if figure.is_none() {
            let known = || self.figures.iter().map(|(name, _)| name.as_str());
            let help = names::did_you_mean(name, known()).unwrap_or_else(|| {
                format!("computed are {}", known().collect::<Vec<_>>().join(", "))
            });
            table.get("figure")?.wrong(format!("'{name}' is not computed; {help}"));
        }
        figure
    }

    fn threshold(&self, table: &Table<'_>) -> Option<Threshold> {
        table.allow(&["figure", "quantile", "at-most", "at-least", "confidence", "cells"]);
        let figure = self.figure(table);
        let within = |key: &str, usual: f64| {
            let value = table.number(key).unwrap_or(usual);
            if !(value > 0.0 && value < 1.0) {
                table.wrong(format!("'{key}' {value} is not between 0 and 1"));
            }
            value
        };
        let (quantile, confidence) = (within("quantile", 0.5), within("confidence", 0.95));
        let (least, most) = (table.number("at-least"), table.number("at-most"));
        if least.is_some() == most.is_some() {
            table.wrong("one of 'at-most' and 'at-least' must be the bound");
        }
        let cells = table.text("cells").unwrap_or("*").to_owned();
        Some(Threshold { figure: figure?, quantile, least, most, confidence, cells })
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

/// The figures of a file.
pub(super) fn read_figures(root: &Table<'_>) -> Vec<(String, Figure)> {
    named(root, "figures", |entry| Figure::read(&entry.table()?))
}

/// The name of a figure at an instant.
fn at_instant(name: &str, more: &str, instant: f64) -> String {
    format!("{name}{more}@{instant}")
}

fn counted_seeds(root: &Table<'_>) -> Vec<(String, [u64; 2])> {
    if !root.get("seed-parameters").is_some_and(|entry| entry.is_table()) {
        return Vec::new();
    }
    named(root, "seed-parameters", |entry| {
        let table = entry.table()?;
        table.allow(&["first", "step"]);
        Some([table.count("first").unwrap_or(1), table.count("step").unwrap_or(1)])
    })
}

/// The entries of a table of the file, each read by `read`.
fn named<T>(
    root: &Table<'_>,
    key: &str,
    read: impl Fn(&cosim_core::table::Entry<'_>) -> Option<T>,
) -> Vec<(String, T)> {
    let Some(table) = root.table(key) else { return Vec::new() };
    let entries = table.entries().filter_map(|(name, mut entry)| {
        entry.name = format!("{key}.{name}");
        Some((name.to_owned(), read(&entry)?))
    });
    entries.collect()
}

fn design(root: &Table<'_>) -> Design {
    let Some(name) = root.text("design") else { return Design::default() };
    let found = DESIGNS.iter().find(|(known, _)| *known == name);
    if found.is_none() {
        let names = DESIGNS.map(|(name, _)| name);
        let help = names::did_you_mean(name, names)
            .unwrap_or_else(|| format!("known are {}", names.join(", ")));
        root.wrong(format!("there is no design '{name}'; {help}"));
    }
    found.map_or(Design::default(), |(_, design)| *design)
}

fn conditions(root: &Table<'_>) -> Vec<Condition> {
    let texts = root.texts("stop-when").into_iter();
    let read = texts.filter_map(|text| text.parse().map_err(|e: String| root.wrong(e)).ok());
    read.collect()
}

#[cfg(test)]
mod tests;
