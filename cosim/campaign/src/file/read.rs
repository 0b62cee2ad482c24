//! Reads the file of a campaign.

use std::collections::HashMap;
use std::path::Path;

use super::list::List;
use super::{Campaign, Cell, Keep, OverTime, Replacement, Scene, Source, Threshold};
use crate::design::{DESIGNS, Design, Distribution, Points};
use crate::figure::Figure;
use cosim_base::error::{Code, Error, Result};
use cosim_base::names;
use cosim_core::scenario::Condition;
use cosim_core::table::{Document, Table};

/// The most runs of a campaign, and octets of what distinguishes its cells.
const MOST_RUNS: usize = 10_000_000;
const MOST_OF_CELLS: usize = 256 << 20;

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
    /// From the text of a file and, if it no longer exists, that of its list.
    pub(crate) fn parse_with(text: &str, file: &Path, list_text: Option<&str>) -> Result<Self> {
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
}

/// The figures of a file.
pub(crate) fn read_figures(root: &Table<'_>) -> Vec<(String, Figure)> {
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
