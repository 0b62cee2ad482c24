//! Where results go; runs with a recorder, a clock and snapshots.

use std::cell::RefCell;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use clap::Args;
use cosim::files;
use cosim::live::{Playing, Server, Watch};
use cosim::observe::{self, Continued, CsvRecorder, Digested, RunningDigest, Stop};
use cosim::roles::Declaration;
use cosim::scenario::Condition;
use cosim::scenario::Scenario;
use cosim::shown::{Terminal, one_line, visible};
use cosim::{Code, Error, Observer, Overrides, Recording, Result, Run, Snapshot, Summary, System};

use super::Format;
use super::distributed::Cluster;
use super::interrupt::Interrupt;
use super::isolate::Written;
use super::live::{Live, Watching};
use super::messages;
use super::progress::Progress;
use super::snapshots::Snapshots;
use super::standard;
use super::stop_when::StopWhen;
use super::summary::{self, RunResult};

#[derive(Args)]
pub(crate) struct Output {
    /// Record this variable; * and ? match parts of names (repeatable; default: all outputs)
    #[arg(long, value_name = "NAME")]
    output_variable: Vec<String>,
    /// Seconds between recorded samples (default: the smallest step)
    #[arg(long, value_name = "SECONDS", value_parser = super::values::seconds)]
    output_interval: Option<f64>,
    /// Output file for the results: CSV, MCAP or Parquet, by the extension .csv, .mcap or .parquet;
    /// - for CSV to stdout (default: NAME_out.csv)
    #[arg(long, short, value_name = "FILE")]
    output_file: Option<PathBuf>,
    /// Write the results to NAME_out.csv in this folder, which is created if missing
    #[arg(long, value_name = "FOLDER", conflicts_with = "output_file")]
    output_dir: Option<PathBuf>,
    /// For the ROS messages in MCAP: a file that assigns variables to the truth, its estimates and
    /// sensors (default: by the names of the variables)
    #[arg(long, value_name = "FILE")]
    roles: Option<PathBuf>,
    #[command(flatten)]
    snapshots: Snapshots,
    /// Apply this file: faults in TOML, or overrides, biases and resets in the JSON of OSP
    /// scenarios (repeatable)
    #[arg(long, value_name = "FILE")]
    scenario: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) watching: Watching,
    /// Run in real time, or FACTOR times as fast; overruns are counted
    #[arg(long, value_name = "FACTOR", value_parser = super::values::factor, num_args = 0..=1,
          default_missing_value = "1", require_equals = true)]
    real_time: Option<f64>,
    /// End the run at the first sample for which this holds, such as 'pursuit.finished = 1'
    /// (repeatable: the first that holds)
    #[arg(long, value_name = "CONDITION")]
    stop_when: Vec<Condition>,
    /// Write the running digest of the results after each sample to this file, for `cosim verify`
    #[arg(long, value_name = "FILE")]
    digest_file: Option<PathBuf>,
    /// Format of the summary: text on stderr, or JSON on stdout, including errors
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(crate) format: Format,
    /// Show no progress and no summary
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

/// What to run, where, and from which state.
struct Computed<'a> {
    system: &'a System,
    cluster: Option<&'a Cluster>,
    snapshot: Option<Snapshot>,
    /// Options for live viewers.
    watched: (Option<Server>, Playing),
}

/// The recorder, and access to its digest.
type Recorder = (Box<dyn Observer>, Rc<RefCell<RunningDigest>>);

impl Output {
    /// Refuses live viewers, because a confined process that runs FMUs cannot serve them.
    pub(crate) fn unwatched(&self) -> Result<()> {
        if !self.watching.wanted() {
            return Ok(());
        }
        Err(Error::new(Code::Usage, "--live cannot be given with --isolate")
            .why("an isolated run has no network")
            .help("workers of this run confine its FMUs as well: --workers 1"))
    }

    /// Options that take effect when the system is made.
    pub(crate) fn add_to(&self, overrides: Overrides) -> Overrides {
        let overrides = overrides.output_variables(&self.output_variable);
        match self.output_interval {
            Some(seconds) => overrides.output_interval(seconds),
            None => overrides,
        }
    }

    /// Runs `system` and writes its results; `shut` is called before FMUs are loaded.
    pub(crate) fn run(
        &self,
        system: &System,
        cluster: Option<&Cluster>,
        shut: &dyn Fn() -> Result<()>,
    ) -> Result<()> {
        messages::findings(system, self.quiet);
        let target = self.checked_target(system)?;
        let snapshot = self.snapshots.resumed(system)?;
        let is_over = |s: &&Snapshot| s.time() == system.stop_time() && !self.quiet;
        if let Some(done) = snapshot.as_ref().filter(is_over) {
            let when = done.time();
            messages::note(&format!(
                "the snapshot is of t = {when}, where the run ends: nothing is left to run"
            ));
        }
        let is_terminal = io::stdout().is_terminal();
        if self.format == Format::Json || target == Path::new("-") {
            standard::keep_apart()?;
        }
        // Before anything is written: the port may be taken.
        let watched = self.watching.open(self.real_time)?;
        let computed = Computed { system, cluster, snapshot, watched };
        if target != Path::new("-") {
            let recorder = self.recorder(&target, system, computed.snapshot.as_ref())?;
            return self.observe(computed, recorder, &target, shut);
        }
        if self.format == Format::Json {
            return Err(Error::new(Code::Usage, "results and summary cannot both go to stdout")
                .help("set --output-file to a file"));
        }
        let stdout: Box<dyn Write> = match is_terminal {
            true => Box::new(Terminal::new(standard::out())),
            false => standard::out(),
        };
        let recorder = CsvRecorder::new(io::BufWriter::new(stdout), "stdout");
        let recorder = self.digested(Box::new(recorder))?;
        self.observe(computed, recorder, &target, shut)
    }

    /// Where the results go; refuses names that belong to inputs or to two of the outputs.
    fn checked_target(&self, system: &System) -> Result<PathBuf> {
        let target = self.target(system.name())?;
        observe::check_ending(&target)?;
        let named = self.scenario.iter().chain(&self.roles).map(PathBuf::as_path);
        named.chain(system.files()).for_each(files::note_input);
        let record = self.watching.wanted().then(|| self.record(system, &target));
        let snapshot = self.snapshots.wanted()?.map(|_| self.snapshots.target(system));
        let replaced = [record, snapshot].into_iter().flatten();
        let created = [Some(target.clone()), self.digest_file.clone()].into_iter().flatten();
        let incomplete = target.extension().is_some_and(|end| end.eq_ignore_ascii_case("parquet"));
        if incomplete && self.snapshots.wanted()?.is_some() {
            return Err(Error::new(Code::Usage, "results in Parquet cannot be continued")
                .why("a Parquet file can be read only once it is complete")
                .help("write .csv or .mcap, and convert it afterwards (cosim convert)"));
        }
        let mut written: Vec<PathBuf> = Vec::new();
        for file in created.chain(replaced) {
            let resumed = self.snapshots.file().filter(|_| file == target);
            files::refuse_inputs(&file, resumed)?;
            if written.contains(&file) && file != Path::new("-") {
                return Err(Error::new(Code::Usage, "two outputs have the same name").at(file));
            }
            written.push(file);
        }
        Ok(target)
    }

    /// The file for injected faults.
    fn record(&self, system: &System, target: &Path) -> PathBuf {
        const ENDING: &str = "injected.toml";
        match target.to_str() {
            Some("-") => PathBuf::from(format!("{}.{ENDING}", file_name(system.name()))),
            _ => target.with_extension(ENDING),
        }
    }

    /// The files that a run writes, including a log if there is one.
    pub(crate) fn written(&self, system: &System, log: Option<&Path>) -> Result<Written> {
        let target = self.checked_target(system)?;
        let to_file = target != Path::new("-");
        let continued = to_file && self.snapshots.file().is_some() && target.exists();
        let created = [(to_file && !continued).then_some(target.as_path())];
        let created = created.into_iter().chain([self.digest_file.as_deref(), log]).flatten();
        Ok(Written {
            created: created.map(Path::to_owned).collect(),
            snapshot: self.snapshots.wanted()?.map(|_| self.snapshots.target(system)),
            continued: continued.then_some(target),
        })
    }

    /// A new results file; a resumed run continues the existing one.
    fn recorder(
        &self,
        target: &Path,
        system: &System,
        snapshot: Option<&Snapshot>,
    ) -> Result<Recorder> {
        if snapshot.is_none() || !target.exists() {
            return self.digested(observe::create_with(target, self.roles()?)?);
        }
        let old = observe::read_unfinished(target)?;
        files::note_continued(target);
        if !old.names().iter().eq(system.columns().iter().map(|column| &column.name)) {
            return Err(Error::new(Code::Results, "the results cannot be continued")
                .at(target)
                .why("their columns are not those of this run")
                .help("set --output-file to another file"));
        }
        let (recorder, unfinished) = observe::create_unfinished(target, self.roles()?)?;
        let (recorder, digest) = self.digested(recorder)?;
        let continued = Continued::new(recorder, old).replacing(unfinished);
        Ok((Box::new(continued), digest))
    }

    fn roles(&self) -> Result<Option<Declaration>> {
        self.roles.as_ref().map(Declaration::read).transpose()
    }

    fn digested(&self, recorder: Box<dyn Observer>) -> Result<Recorder> {
        let (digested, digest) = Digested::new(recorder);
        let digested = match &self.digest_file {
            Some(file) => digested.list(file)?,
            None => digested,
        };
        Ok((Box::new(digested), digest))
    }

    fn observe(
        &self,
        what: Computed<'_>,
        (mut recorder, digest): Recorder,
        file: &Path,
        shut: &dyn Fn() -> Result<()>,
    ) -> Result<()> {
        let target =
            &if file == Path::new("-") { "stdout".into() } else { file.display().to_string() };
        let Computed { system, cluster, snapshot, watched: (server, playing) } = what;
        let begun = std::time::Instant::now();
        let mut progress = Progress::new();
        let mut interrupt = Interrupt::new();
        let mut live = Live::new(server, playing, self.record(system, file));
        let mut scenarios = self.scenario.iter().map(Scenario::read).collect::<Result<Vec<_>>>()?;
        let mut watch = self.watch(system, &live, &scenarios)?;
        let mut keep = |snapshot: Snapshot| self.snapshots.write(system, &snapshot);
        let mut stop_when = StopWhen::new(&self.stop_when);
        let mut run = Run::new(system).observe(&mut *recorder).observe(&mut interrupt);
        run = run.observe(&mut stop_when);
        if !self.quiet {
            run = run.observe(&mut progress);
        }
        if let Some(watch) = &mut watch {
            run = run.observe(watch);
        }
        for scenario in &mut scenarios {
            run = run.manipulate(scenario);
        }
        if live.wanted() {
            run = run.manipulate(&mut live);
        }
        if let Some(snapshot) = &snapshot {
            run = run.resume(snapshot);
        }
        if let Some((every, at)) = self.snapshots.wanted()? {
            run = run.snapshots(every, &at, &mut keep);
        }
        // From here on, FMUs run.
        shut()?;
        let outcome = match cluster {
            Some(cluster) => cluster.go(system, run),
            None => run.go(),
        };
        match &outcome {
            Ok(_) => live.end("the run has ended"),
            Err(e) => live.end(&format!("the run has failed: {}", e.line())),
        }
        let mut summary = outcome.map_err(|e| match e.code() {
            Code::Fmu | Code::Loop | Code::Step => {
                e.maybe_help(Some(format!("the results until then are in {target}")))
            }
            _ => e,
        })?;
        summary.notes.extend(live.record().map(|file| {
            format!("faults were injected: --scenario {} repeats them", file.display())
        }));
        summary.notes.extend(stop_when.held().map(|held| format!("ended by --stop-when: {held}")));
        let (spent, overruns) = (begun.elapsed().as_secs_f64(), live.overruns());
        let digest = digest.borrow().text();
        self.print_result(&RunResult {
            system,
            summary: &summary,
            spent,
            target,
            overruns,
            digest,
        })?;
        match summary.stopped {
            Some(Stop::Interrupted) => {
                Err(Error::new(Code::Interrupted, "the run was interrupted")
                    .why(format!("at {} s after its start", summary.simulated))
                    .help(format!("the results until then are in {target}")))
            }
            _ => Ok(()),
        }
    }

    /// What shows the run to clients, if clients are allowed.
    fn watch(&self, system: &System, live: &Live, scenarios: &[Scenario]) -> Result<Option<Watch>> {
        let Some(server) = live.server() else { return Ok(None) };
        let start = vec![system.start_time().seconds()];
        let start = Recording::from_columns(Vec::new(), start, Vec::new());
        let faults = scenarios.iter().flat_map(|scenario| scenario.windows(&start)).collect();
        Ok(Some(server.watch(self.roles()?, faults)))
    }

    fn print_result(&self, result: &RunResult) -> Result<()> {
        let summary: &Summary = result.summary;
        for warning in &summary.warnings {
            messages::warning(warning);
        }
        if self.format == Format::Json {
            return print(&summary::json(result).to_string());
        }
        if !self.quiet && summary.stopped != Some(Stop::ReaderGone) {
            summary.notes.iter().for_each(|note| messages::note(note));
            summary.messages.iter().for_each(|message| messages::said(message));
            messages::info(&summary::text(result));
        }
        Ok(())
    }

    fn target(&self, name: &str) -> Result<PathBuf> {
        let file = format!("{}_out.csv", file_name(name));
        match (&self.output_file, &self.output_dir) {
            (Some(file), _) => Ok(file.clone()),
            (None, None) => Ok(PathBuf::from(file)),
            (None, Some(folder)) => {
                std::fs::create_dir_all(folder).map_err(|e| {
                    Error::new(Code::Output, "the folder cannot be made").at(folder).why(e)
                })?;
                Ok(folder.join(file))
            }
        }
    }
}

/// The name of a system as part of a file name that is shown in terminals.
pub(crate) fn file_name(name: &str) -> String {
    let shown = one_line(name);
    shown.replace(['/', '\\'], "_")
}

/// Prints these lines to stdout; a line break in a name does not start a new line.
pub(crate) fn print_lines(lines: &[String]) -> Result<()> {
    let lines: Vec<_> = lines.iter().map(|line| one_line(line)).collect();
    print(&lines.join("\n"))
}

/// Prints to stdout; ends quietly if the pipe is closed (`| head`).
pub(crate) fn print(text: &str) -> Result<()> {
    match writeln!(standard::out(), "{}", visible(text)) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::new(Code::Output, "stdout cannot be written").why(e))
        }
        _ => Ok(()),
    }
}
