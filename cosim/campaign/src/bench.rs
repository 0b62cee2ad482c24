//! Makes the runs of a campaign: any of them, in any order.
#![allow(unsafe_code, reason = "system calls without a safe form")]

use std::collections::HashMap;
use std::path::Path;

use sha2::{Digest, Sha256};

use super::Campaign;
use super::design::Points;
use super::figure::Figure;
use super::file::{Cell, Source};
use super::row::{Number, Row, Status};
use cosim_base::error::{Code, Error, Result};
use cosim_base::names;
use cosim_base::sha256;
use cosim_base::time::Time;
use cosim_core::master::{Manipulator, Run};
use cosim_core::observe::{Observer, Recording, RunInfo, RunningDigest, Stop};
use cosim_core::scenario::Condition;
use cosim_core::scenario::Scenario;
use cosim_core::scenario::{Random, Window};
use cosim_core::system::{Overrides, Port, System};
use cosim_import::{Causality, Kind};
use cosim_report::Units;

/// The first components of the addresses of random streams, after the root seed.
const SEEDS: u64 = 0x0073_6565_6473;
const FAULTS: u64 = 0x6661_756c_7473;

/// A campaign with its systems: each is read once, and its FMUs are mapped once.
pub struct Bench {
    campaign: Campaign,
    points: Points,
    /// One for each system of the file.
    systems: Vec<Opened>,
    /// For each system and replacement: the parameters that get seeds.
    seeds: HashMap<(usize, usize), Vec<String>>,
    scenarios: Vec<Option<Scenario>>,
}

/// A system of the file, with the requests for its variables under their names in it.
struct Opened {
    system: System,
    figures: Vec<Figure>,
    stop_when: Vec<Condition>,
}

impl Opened {
    fn new(source: &Source, campaign: &Campaign) -> Result<Self> {
        let without = source.without.iter();
        let system = System::load(
            &source.file,
            &without.fold(Overrides::new(), |overrides, name| overrides.without(name)),
        )?;
        let components = || system.components().iter().map(|component| component.name.as_str());
        let mut problems = Vec::new();
        for (alias, meant) in source.names.pairs() {
            let owner = meant.split('.').next().unwrap_or_default();
            if !components().any(|name| meant == name || owner == name) {
                let what = format!("'{alias}' means '{meant}', and there is no such component");
                let help = names::did_you_mean(owner, components());
                let error = Error::new(Code::UnknownName, what).at(&source.file);
                problems.push(help.into_iter().fold(error, Error::help));
            }
        }
        Error::all(problems)?;
        let figures = campaign.figures.iter().map(|(_, figure)| figure.renamed(&source.names));
        let renamed = |condition: &Condition| {
            let mut condition = condition.clone();
            condition.variable = source.names.resolve(&condition.variable);
            condition
        };
        let stop_when = campaign.stop_when.iter().map(renamed).collect();
        Ok(Self { figures: figures.collect(), stop_when, system })
    }
}

impl Bench {
    /// Reads the systems and scenarios of a campaign.
    pub fn open(campaign: Campaign) -> Result<Self> {
        let (mut systems, mut scenarios, mut problems) = (Vec::new(), Vec::new(), Vec::new());
        for (_, source) in &campaign.systems {
            match Opened::new(source, &campaign) {
                Ok(opened) => systems.push(opened),
                Err(problem) => problems.push(problem),
            }
        }
        for (_, file) in &campaign.scenarios {
            match file.faults.as_ref().map(Scenario::read).transpose() {
                Ok(scenario) => scenarios.push(scenario),
                Err(problem) => problems.push(problem),
            }
        }
        Error::all(problems)?;
        let points =
            Points::new(campaign.design, campaign.seed, campaign.dispersions.len(), campaign.seeds);
        let mut bench = Self { campaign, points, systems, seeds: HashMap::new(), scenarios };
        let mut problems = Vec::new();
        for system in 0..bench.campaign.systems.len() {
            for replacement in 0..bench.campaign.replacements.len() {
                match bench.find_seeds(system, replacement) {
                    Ok(seeds) => drop(bench.seeds.insert((system, replacement), seeds)),
                    Err(problem) => problems.push(problem),
                }
            }
        }
        Error::all(problems)?;
        Ok(bench)
    }

    /// The campaign.
    pub fn campaign(&self) -> &Campaign {
        &self.campaign
    }

    /// Checks the first run of every cell without making it.
    pub fn check(&self) -> Result<()> {
        let problems = (0..self.campaign.cells.len()).filter_map(|cell| {
            let system = self.system(cell as u64, &[]).and_then(|system| {
                system.ready()?;
                self.scenario(cell as u64)
                    .map_or(Ok(()), |mut scenario| scenario.start(&system, None))
            });
            system.err()
        });
        let problems: Vec<Error> = problems.collect();
        // The same mistake is often in many cells.
        let mut reported: Vec<String> = Vec::new();
        let new = problems.into_iter().filter(|problem| {
            let text = problem.to_string();
            let new = !reported.contains(&text);
            reported.push(text);
            new
        });
        Error::all(new.collect())
    }

    /// Everything that determines the runs, as lines of text; files are represented by their
    /// hashes.
    pub fn identity(&self) -> Result<Vec<String>> {
        let mut lines = self.campaign.identity();
        let hash = |name: &str, file: &Path| -> Result<String> {
            let octets = cosim_base::files::read_input(file)
                .map_err(|e| Error::new(Code::File, "a file cannot be read").at(file).why(e))?;
            Ok(format!("{name} is {}", sha256(octets)))
        };
        for ((name, source), opened) in self.campaign.systems.iter().zip(&self.systems) {
            lines.push(hash(&format!("system {name}"), &source.file)?);
            for component in opened.system.components() {
                if let Some(fmu) = component.fmu() {
                    let digest = fmu.digest(component.interface)?;
                    lines.push(format!("component {name}.{} is {digest}", component.name));
                }
            }
        }
        for replacement in &self.campaign.replacements {
            for (component, file) in &replacement.components {
                lines.push(hash(&format!("{}.{component}", replacement.name), file)?);
            }
        }
        for (name, file) in &self.campaign.scenarios {
            if let Some(file) = &file.faults {
                lines.push(hash(&format!("scenario {name}"), file)?);
            }
        }
        lines.push(format!("cosim {}", env!("CARGO_PKG_VERSION")));
        Ok(lines)
    }

    /// What a replacement changes in a system.
    fn replaced(&self, system: usize, replacement: usize) -> Overrides {
        let names = &self.campaign.systems[system].1.names;
        let components = self.campaign.replacements[replacement].components.iter();
        components.fold(Overrides::new(), |overrides, (name, fmu)| {
            overrides.replace(names.resolve(name), fmu)
        })
    }

    /// The parameters that get their own seed in each run.
    fn find_seeds(&self, system: usize, replacement: usize) -> Result<Vec<String>> {
        let names = &self.campaign.systems[system].1.names;
        let system = self.systems[system].system.with(&self.replaced(system, replacement))?;
        let scenes = self.campaign.scenarios.iter().flat_map(|(_, s)| &s.start_values);
        let given = self.campaign.start_values.iter().chain(scenes).map(|(name, _)| name.as_str());
        let given = given.chain(self.campaign.counted_seeds.iter().map(|(name, _)| name.as_str()));
        let fixed: Vec<String> =
            self.campaign.inputs().chain(given).map(|name| names.resolve(name)).collect();
        let mut seeds = Vec::new();
        for (component, own) in system.components().iter().enumerate() {
            let variables = own.model.description().map_or(&[][..], |d| &d.variables);
            for (variable, described) in variables.iter().enumerate() {
                let name = system.port_name(Port { component, variable });
                let settable =
                    described.causality == Causality::Parameter && described.kind == Kind::Integer;
                let patterns = &self.campaign.seed_parameters;
                let wanted =
                    patterns.iter().any(|pattern| names::matches(&names.resolve(pattern), &name));
                if settable && wanted && !fixed.contains(&name) {
                    seeds.push(name);
                }
            }
        }
        Ok(seeds)
    }

    /// The values of the varied parameters of a run.
    fn inputs(&self, run: u64) -> Box<[Box<str>]> {
        let campaign = &self.campaign;
        let (cell, point) = (&campaign.cells[campaign.cell_of(run)], campaign.replicate_of(run));
        let factors = campaign.factors.iter().zip(&cell.levels);
        let factors = factors.map(|((_, values), level)| values[*level].clone());
        let list = cell.row.map(|row| campaign.list.rows[row].clone()).unwrap_or_default();
        let drawn =
            campaign.dispersions.iter().enumerate().map(|(coordinate, (_, spread))| {
                spread.quantile(self.points.at(point, coordinate))
            });
        factors.chain(list).chain(drawn).map(String::into_boxed_str).collect()
    }

    /// The seed of a stream of a run: the same in all cells, so that cells can be compared in
    /// pairs.
    fn seed(&self, run: u64, kind: u64, name: &str) -> Random {
        let hash = Sha256::digest(name);
        let name = u64::from_le_bytes(std::array::from_fn(|place| hash[place]));
        let replicate = self.campaign.replicate_of(run) as u64;
        Random::new(&[self.campaign.seed, kind, replicate, name])
    }

    fn cell(&self, run: u64) -> &Cell {
        &self.campaign.cells[self.campaign.cell_of(run)]
    }

    /// The start values of a run, by their names in its system: those in the file, and the seeds.
    pub fn start_values(&self, run: u64) -> Vec<(String, String)> {
        let (campaign, cell) = (&self.campaign, self.cell(run));
        let names = &campaign.systems[cell.system].1.names;
        let (_, scene) = &campaign.scenarios[cell.scenario];
        let given = campaign.start_values.iter().chain(&scene.start_values);
        let given = given.map(|(name, value)| (names.resolve(name), value.clone()));
        let inputs = campaign.inputs().zip(self.inputs(run));
        let inputs = inputs.map(|(name, value)| (names.resolve(name), value.into_string()));
        let replicate = campaign.replicate_of(run) as u64;
        let counted = campaign.counted_seeds.iter().map(|(name, [first, step])| {
            (names.resolve(name), (first + step * replicate).to_string())
        });
        let drawn = self.seeds[&(cell.system, cell.replacement)].iter().map(|name| {
            let seed = self.seed(run, SEEDS, name).below(i32::MAX as usize);
            (name.clone(), seed.to_string())
        });
        given.chain(inputs).chain(counted).chain(drawn).collect()
    }

    /// The system of a run; `more` is recorded in addition to what the figures need.
    fn system(&self, run: u64, more: &[String]) -> Result<System> {
        let (campaign, cell) = (&self.campaign, self.cell(run));
        let mut overrides = self.replaced(cell.system, cell.replacement);
        for (name, value) in self.start_values(run) {
            overrides = overrides.start_value(name, value);
        }
        if let Some(seconds) = campaign.stop_time {
            overrides = overrides.stop_time(seconds);
        }
        if let Some(seconds) = campaign.output_interval {
            overrides = overrides.output_interval(seconds);
        }
        let needed = self.columns(cell);
        overrides = overrides.output_variables(&needed).output_variables(more);
        let system = self.systems[cell.system].system.with(&overrides)?;
        let columns = system.columns().iter().filter(|column| needed.contains(&column.name));
        let strings: Vec<Error> = columns.filter_map(|column| column.is_number().err()).collect();
        Error::all(strings)?;
        Ok(system)
    }

    /// Variables that must be recorded in a cell, each once.
    fn columns(&self, cell: &Cell) -> Vec<String> {
        let Opened { figures, stop_when, .. } = &self.systems[cell.system];
        let names = &self.campaign.systems[cell.system].1.names;
        let figures = figures.iter().flat_map(Figure::columns);
        let stops = stop_when.iter().map(|condition| condition.variable.clone());
        let scenario = self.scenarios[cell.scenario].iter();
        let watched = scenario.flat_map(|s| s.watched().map(|name| names.resolve(name)));
        let mut columns: Vec<String> = figures.chain(stops).chain(watched).collect();
        columns.sort();
        columns.dedup();
        columns
    }

    fn scenario(&self, run: u64) -> Option<Scenario> {
        let cell = self.cell(run);
        let scenario = self.scenarios[cell.scenario].clone()?;
        let names = &self.campaign.systems[cell.system].1.names;
        Some(scenario.renamed(names).seeded(self.fault_seed(run)))
    }

    /// The row of a run that failed in the process that made it.
    pub fn lost(&self, run: u64, status: Status, reason: impl Into<Box<str>>) -> Row {
        Row { inputs: self.inputs(run), ..Row::without_figures(run, status, reason) }
    }

    /// Makes a run and returns its row.
    pub fn run(&self, run: u64) -> Row {
        self.row(run, &[], &mut Recording::new())
    }

    /// Repeats a run and also records these variables (`*` and `?` match parts of names).
    pub fn replay(&self, run: u64, variables: &[String], results: &mut dyn Observer) -> Row {
        self.row(run, variables, results)
    }

    /// The units of everything that a run records with these variables, by all their names.
    pub(super) fn units(&self, run: u64, variables: &[String]) -> Result<Units> {
        let names = &self.campaign.systems[self.cell(run).system].1.names;
        self.system(run, variables).map(|system| Units::of(&system).with(names))
    }

    /// The figures of a run, with the names of variables in its system.
    pub(super) fn figures(&self, run: u64) -> &[Figure] {
        &self.systems[self.cell(run).system].figures
    }

    /// The time spans in which a fault is active in a recorded run.
    pub(super) fn windows(&self, run: u64, recording: &Recording) -> Vec<Window> {
        self.scenario(run).map_or_else(Vec::new, |scenario| scenario.windows(recording))
    }

    /// How long measurements are missing in a run (s): see [`Scenario::outage`].
    pub(super) fn outage(&self, run: u64) -> f64 {
        let cell = self.cell(run);
        let Some(scenario) = &self.scenarios[cell.scenario] else { return 0.0 };
        let system = &self.systems[cell.system].system;
        let stop = self.campaign.stop_time.unwrap_or(system.stop_time().seconds());
        scenario.outage(self.fault_seed(run), [system.start_time().seconds(), stop])
    }

    /// What the scenario of a cell does, without times; empty if it does nothing.
    pub(super) fn scenario_words(&self, cell: usize) -> String {
        let scenario = self.campaign.cells[cell].scenario;
        let set = self.campaign.scenarios[scenario].1.start_values.iter();
        let set = set.map(|(name, value)| format!("{name} = {value}"));
        let faults = self.scenarios[scenario].iter().flat_map(Scenario::words);
        set.chain(faults).collect::<Vec<_>>().join("; ")
    }

    fn fault_seed(&self, run: u64) -> u64 {
        self.seed(run, FAULTS, "").below(usize::MAX) as u64
    }

    fn row(&self, run: u64, more: &[String], results: &mut dyn Observer) -> Row {
        let begun = processor_time();
        let outcome = self.made(run, more, results);
        let mut row =
            outcome.unwrap_or_else(|problem| self.lost(run, Status::Failed, reason(&problem)));
        row.cpu_ms = Number(((processor_time() - begun) * 1e4).round() / 10.0);
        row
    }

    fn made(&self, run: u64, more: &[String], results: &mut dyn Observer) -> Result<Row> {
        let system = self.system(run, more)?;
        let mut scenario = self.scenario(run);
        let cell = self.cell(run);
        let mut kept = Kept::new(self.columns(cell), &self.systems[cell.system].stop_when);
        let mut making = Run::new(&system).observe(&mut kept).observe(results);
        if let Some(scenario) = &mut scenario {
            making = making.manipulate(scenario);
        }
        let summary = making.go()?;
        let faults = scenario.as_ref().and_then(|scenario| span(scenario, &kept.recording));
        let figures = self.figures(run).iter();
        let figures = figures.map(|figure| figure.compute(&kept.recording, faults));
        let figures: Result<Vec<f64>> = figures.collect();
        let ended = kept.held.map(|held| format!("ended when {held}"));
        let mut reason: Vec<String> = ended.into_iter().collect();
        if summary.stopped == Some(Stop::Component) {
            reason.extend(summary.warnings.iter().cloned());
        }
        Ok(Row {
            run,
            status: Status::Ok,
            reason: reason.join("; ").into(),
            inputs: self.inputs(run),
            simulated: Number(summary.simulated),
            figures: figures?.into_iter().map(Number).collect(),
            digest: kept.digest.octets().into(),
            cpu_ms: Number(f64::NAN),
        })
    }
}

/// What went wrong, and what the FMU logged about it.
fn reason(problem: &Error) -> String {
    let said = problem.logged().last().map(String::as_str);
    std::iter::once(problem.line().as_str()).chain(said).collect::<Vec<_>>().join("; ")
}

/// When the first fault of a run began and the last one ended (s); infinite if one did not end.
fn span(scenario: &Scenario, recording: &Recording) -> Option<[f64; 2]> {
    let windows = scenario.windows(recording).into_iter();
    let spans = windows.map(|w| [w.from, w.until.unwrap_or(f64::INFINITY)]);
    spans.reduce(|one, other| [one[0].min(other[0]), one[1].max(other[1])])
}

/// The processor time of this process (s).
fn processor_time() -> f64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the pointer is to a structure of this type, which is written.
    unsafe { libc::clock_gettime(libc::CLOCK_PROCESS_CPUTIME_ID, &mut time) };
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Keeps what the figures need, whatever else is recorded, with its digest; ends the run.
struct Kept<'a> {
    recording: Recording,
    digest: RunningDigest,
    names: Vec<String>,
    /// Their positions among all columns.
    places: Vec<usize>,
    row: Vec<f64>,
    stop_when: &'a [Condition],
    /// For each condition: the position of its variable among all columns.
    looked_at: Vec<usize>,
    held: Option<String>,
}

impl<'a> Kept<'a> {
    fn new(names: Vec<String>, stop_when: &'a [Condition]) -> Self {
        let digest = RunningDigest::new(names.iter().map(String::as_str));
        Self {
            recording: Recording::new(),
            digest,
            names,
            places: Vec::new(),
            row: Vec::new(),
            stop_when,
            looked_at: Vec::new(),
            held: None,
        }
    }
}

impl Observer for Kept<'_> {
    fn start(&mut self, info: &RunInfo<'_>) -> Result<()> {
        let place = |name: &str| {
            info.columns
                .iter()
                .position(|column| column.name == name)
                .ok_or_else(|| Error::new(Code::UnknownName, format!("'{name}' is not recorded")))
        };
        self.places = self.names.iter().map(|name| place(name)).collect::<Result<_>>()?;
        self.looked_at =
            self.stop_when.iter().map(|c| place(&c.variable)).collect::<Result<_>>()?;
        let columns: Vec<_> = self.places.iter().map(|&p| info.columns[p].clone()).collect();
        self.recording.start(&RunInfo { columns: &columns, ..*info })
    }

    fn sample(&mut self, time: Time, values: &[f64]) -> Result<()> {
        self.row.clear();
        self.row.extend(self.places.iter().map(|&place| values[place]));
        self.digest.add(time, self.row.iter().copied());
        let mut all = self.stop_when.iter().zip(&self.looked_at);
        let held = all.find(|(condition, place)| condition.holds(values[**place]));
        self.held = held.map(|(condition, _)| format!("{condition} at t = {time}"));
        self.recording.sample(time, &self.row)
    }

    fn finish(&mut self) -> Result<()> {
        self.recording.finish()
    }

    fn stop(&self) -> Option<Stop> {
        self.held.is_some().then_some(Stop::Enough)
    }
}
