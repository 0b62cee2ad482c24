//! A run: from one output instant or action to the next.

use super::drive::Drive;
use super::manipulate::{Controls, Manipulator};
use super::snapshot::Snapshot;
use super::summary::Summary;
use crate::observe::{Observer, RunInfo, Stop};
use crate::system::System;
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::{Step, Time};

/// Where snapshots go.
type Keep<'a> = dyn FnMut(Snapshot) -> Result<()> + 'a;

/// A run being prepared: observers, manipulators, and the state to continue from.
///
/// ```no_run
/// # use cosim_core::{Overrides, Recording, Run, Snapshot, System};
/// let system = System::load("vehicle.ssd", &Overrides::new())?;
/// let mut recording = Recording::new();
/// let snapshot = Snapshot::read("at_100_s.snapshot")?;
/// let summary = Run::new(&system).observe(&mut recording).resume(&snapshot).go()?;
/// println!("{} steps", summary.steps);
/// # Ok::<(), cosim_core::Error>(())
/// ```
pub struct Run<'a> {
    system: &'a System,
    observers: Vec<&'a mut dyn Observer>,
    manipulators: Vec<&'a mut dyn Manipulator>,
    resume: Option<&'a Snapshot>,
    snapshots: Option<Snapshots<'a>>,
    /// Warnings.
    warnings: Vec<String>,
}

/// When to take snapshots.
struct Snapshots<'a> {
    every: Option<Time>,
    at: Vec<Time>,
    keep: &'a mut Keep<'a>,
}

impl System {
    /// Runs from start to stop. Observers keep what they received if the run fails.
    pub fn run(&self, observers: &mut [&mut dyn Observer]) -> Result<Summary> {
        let observers = observers.iter_mut();
        observers.fold(Run::new(self), |run, observer| run.observe(*observer)).go()
    }
}

impl<'a> Run<'a> {
    /// A run of `system` from its start without observers.
    pub fn new(system: &'a System) -> Self {
        Self {
            system,
            observers: Vec::new(),
            manipulators: Vec::new(),
            resume: None,
            snapshots: None,
            warnings: Vec::new(),
        }
    }

    /// Adds an observer.
    #[must_use]
    pub fn observe(mut self, observer: &'a mut dyn Observer) -> Self {
        self.observers.push(observer);
        self
    }

    /// Adds a manipulator. Those that act at the same instant do so in the order they were added.
    #[must_use]
    pub fn manipulate(mut self, manipulator: &'a mut dyn Manipulator) -> Self {
        self.manipulators.push(manipulator);
        self
    }

    /// Continues from a snapshot. Observers see only what comes after it.
    #[must_use]
    pub fn resume(mut self, snapshot: &'a Snapshot) -> Self {
        self.resume = Some(snapshot);
        self
    }

    /// Takes snapshots: at the first output instant at or after each of `at`, and after each
    /// multiple of `every` since the start.
    #[must_use]
    pub fn snapshots(mut self, every: Option<Time>, at: &[Time], keep: &'a mut Keep<'a>) -> Self {
        let mut at = at.to_vec();
        at.sort();
        self.snapshots = Some(Snapshots { every, at, keep });
        self
    }

    /// Runs.
    pub fn go(self) -> Result<Summary> {
        let mut engine = self.system.engine()?;
        self.drive_all(&mut engine)
    }

    /// Runs the engine made from the system.
    pub fn drive_all(mut self, driven: &mut dyn Drive) -> Result<Summary> {
        let system = self.system;
        let resumed = self.resume.map(Snapshot::time);
        let begin = resumed.unwrap_or(system.start_time());
        let run = self.prepare(resumed).and_then(|()| self.drive(driven, begin));
        let mut finished = Ok(());
        for observer in &mut self.observers {
            finished = finished.and(observer.finish());
        }
        // The reason why a run ended takes precedence over problems while closing files.
        let (end, stopped) = run?;
        finished?;
        let mut report = driven.report()?;
        report.warnings.append(&mut self.warnings);
        Ok(system.summary(report, begin, end, stopped))
    }

    fn prepare(&mut self, resumed: Option<Time>) -> Result<()> {
        let system = self.system;
        system.ready()?;
        let info = RunInfo {
            name: system.name(),
            columns: system.columns(),
            start: system.start_time(),
            stop: system.stop_time(),
            output_interval: system.output_interval(),
            resumed,
        };
        if let Some(snapshot) = self.resume {
            snapshot.check(system)?;
            // At the stop time there is nothing left to do.
            if snapshot.time() > system.stop_time() {
                let what = format!("the snapshot is of t = {}", snapshot.time());
                return Err(Error::new(Code::Timing, what)
                    .why(format!("the run ends at {}", system.stop_time()))
                    .help("use a later --stop-time"));
            }
        }
        for manipulator in &mut self.manipulators {
            manipulator.start(system, resumed)?;
        }
        self.observers.iter_mut().try_for_each(|observer| observer.start(&info))
    }

    /// Where the run ended, and why if that was before the stop time.
    fn drive(&mut self, driven: &mut dyn Drive, begin: Time) -> Result<(Time, Option<Stop>)> {
        let (stop, interval) = (self.system.stop_time(), self.system.output_interval());
        let start = self.system.start_time();
        // The last steps of such a run are shorter, and made before the last row is recorded.
        let shortened = self.system.ends_by_shorter_steps();
        let mut output = start;
        let mut acted = None;
        if let Some(snapshot) = self.resume {
            driven.resume(snapshot.state(), begin, stop)?;
            output = start + interval.after(begin - start);
            acted = Some(begin);
        } else {
            driven.initialize(stop)?;
        }
        let mut row = vec![0.0; self.system.columns().len()];
        let (mut taken, mut before) = (acted, begin);
        loop {
            let action = self
                .action(acted)
                .map(|at| at.max(begin))
                .filter(|at| *at < stop || (*at == stop && !shortened));
            // There are no actions until then: only rows.
            while (output < stop || output == stop && !shortened)
                && action.is_none_or(|action| output < action)
            {
                if let Some(reason) = self.advance(driven, output)? {
                    return Ok((before, Some(reason)));
                }
                before = output;
                self.record(driven, output, &mut row)?;
                self.take_snapshots(driven, output, &mut taken)?;
                if output == stop {
                    return Ok((stop, None));
                }
                if let Some(reason) = self.stop_request() {
                    return Ok((output, Some(reason)));
                }
                output = start + interval.after(output - start);
            }
            let Some(now) = action else { break };
            if let Some(reason) = self.advance(driven, now)? {
                return Ok((before, Some(reason)));
            }
            before = now;
            if now == output {
                self.record(driven, output, &mut row)?;
            }
            let mut ended = self.act(driven, now, acted, &row)?;
            acted = Some(now);
            if now == output {
                self.take_snapshots(driven, now, &mut taken)?;
                output = start + interval.after(output - start);
                ended = ended.or_else(|| self.stop_request());
            }
            if now == stop {
                return Ok((stop, None));
            }
            if let Some(reason) = ended {
                return Ok((now, Some(reason)));
            }
        }
        // The part after the last output instant, if the interval does not divide the run; what
        // ends at the stop time is stepped together with what is shortened.
        let concluded = shortened && self.system.step_control().is_none();
        let goal = if concluded { stop - Time::from_ns(1) } else { stop };
        let ended = self.advance(driven, goal)?;
        if ended.is_some() || !shortened {
            return Ok((ended.map_or(stop, |_| before), ended));
        }
        if let Some(reason) = self.until_ended(driven.conclude(stop))? {
            return Ok((before, Some(reason)));
        }
        self.record(driven, stop, &mut row)?;
        Ok((stop, None))
    }

    /// Shows the observers the values of the current instant.
    fn record(&mut self, driven: &mut dyn Drive, now: Time, row: &mut [f64]) -> Result<()> {
        driven.sample(now, row)?;
        self.observers.iter_mut().try_for_each(|observer| observer.sample(now, row))
    }

    fn stop_request(&self) -> Option<Stop> {
        self.observers.iter().find_map(|observer| observer.stop())
    }

    /// The next instant at which a manipulator acts, after the last one.
    fn action(&self, acted: Option<Time>) -> Option<Time> {
        let requested = self.manipulators.iter().filter_map(|manipulator| manipulator.next());
        requested.filter(|at| acted.is_none_or(|acted| *at > acted)).min()
    }

    /// Makes the steps until `goal`. A component that ends the run is not an error; its step is not
    /// made, so the state of the system is known up to the previous instant.
    fn advance(&mut self, driven: &mut dyn Drive, goal: Time) -> Result<Option<Stop>> {
        let outcome = driven.run_until(goal);
        self.until_ended(outcome)
    }

    fn until_ended(&mut self, outcome: Result<()>) -> Result<Option<Stop>> {
        match outcome {
            Err(ended) if ended.code() == Code::Ended => {
                let why = ended.reason().unwrap_or_default();
                self.warnings.push(format!("{}: {why}", ended.what()));
                Ok(Some(Stop::Component))
            }
            outcome => outcome.map(|()| None),
        }
    }

    fn act(
        &mut self,
        driven: &mut dyn Drive,
        now: Time,
        acted: Option<Time>,
        row: &[f64],
    ) -> Result<Option<Stop>> {
        let mut controls = Controls { system: self.system, driven, now, row, stop: None };
        for manipulator in &mut self.manipulators {
            let due = |at: Time| at <= now && acted.is_none_or(|acted| at > acted);
            if manipulator.next().is_some_and(due) {
                manipulator.act(now, &mut controls)?;
            }
        }
        Ok(controls.stop)
    }

    #[inline]
    fn take_snapshots(
        &mut self,
        driven: &mut dyn Drive,
        now: Time,
        taken: &mut Option<Time>,
    ) -> Result<()> {
        if self.snapshots.is_none() { Ok(()) } else { self.take_due(driven, now, taken) }
    }

    #[cold]
    fn take_due(
        &mut self,
        driven: &mut dyn Drive,
        now: Time,
        taken: &mut Option<Time>,
    ) -> Result<()> {
        let Some(snapshots) = &mut self.snapshots else {
            return Ok(());
        };
        let start = self.system.start_time();
        let since = |at: Time| at <= now && taken.is_none_or(|taken| at > taken);
        let periodic = snapshots.every.is_some_and(|every| {
            let last = taken.unwrap_or(start);
            start + Step::whole(every).after(last - start) <= now
        });
        if periodic || snapshots.at.iter().any(|&at| since(at)) {
            self.observers.iter_mut().try_for_each(|observer| observer.flush())?;
            (snapshots.keep)(Snapshot::new(self.system, now, driven.save(now)?)?)?;
        }
        *taken = Some(now);
        Ok(())
    }
}
