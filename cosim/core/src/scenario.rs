//! Scenarios: timed events in a system, from a file.
//!
//! A file whose name ends in `.toml` lists faults (see [`Fault`]):
//!
//! ```toml
//! seed = 1
//!
//! [[fault]]
//! kind = "white-noise"
//! on = ["dvl.velocity.u", "dvl.velocity.v"]
//! sigma = 0.02
//! from = 60
//! for = 30
//! ```
//!
//! Any other is JSON of the Open Simulation Platform:
//!
//! ```json
//! { "description": "the DVL fails for half a minute",
//!   "defaults": { "model": "dvl", "action": "override" },
//!   "events": [
//!     { "time": 100, "variable": "off", "value": 1 },
//!     { "time": 130, "variable": "off", "action": "reset" } ],
//!   "end": 200 }
//! ```
//!
//! `override` sets the variable to that value from then on, `bias` adds the value to it, `reset`
//! ends either. `defaults` are used for keys that an event omits; `end` ends the run early. Events
//! at the same instant happen in the order of the file.

#[cfg(feature = "files")]
mod faults;
#[cfg(feature = "files")]
mod injected;
#[cfg(feature = "files")]
mod osp;
mod windows;

#[cfg(feature = "files")]
pub use injected::Injected;

pub use crate::condition::Condition;
pub use crate::fault::{
    Begin, End, Fault, KINDS, Kind, Meant, Meanwhile, Random, Spread, Window, Word,
    normal_quantile, schema,
};

#[cfg(feature = "files")]
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::master::{Controls, Manipulator};
use crate::observe::Stop;
use crate::system::{Column, System};
use cosim_base::error::{Code, Error, Result};
use cosim_base::names::{self, Aliases};
use cosim_base::time::{Step, Time};

/// A scenario as a manipulator.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(from = "Specification", into = "Specification")]
pub struct Scenario {
    events: Vec<Event>,
    /// How many of the events have happened.
    done: usize,
    faults: Vec<Fault>,
    seed: u64,
    /// For each fault: its variables by full name, or its components.
    targets: Vec<Vec<String>>,
    /// The pending resets with their faults, the next one last.
    resets: Vec<(Time, usize)>,
    /// The faults that are not yet installed, and when they will be, the next one last.
    installs: Vec<(Time, usize)>,
    /// Faults whose condition has not held yet, and when it is checked next.
    waiting: Vec<usize>,
    look: Time,
    start: Time,
    interval: Step,
}

/// What its file says.
#[derive(Serialize, Deserialize)]
struct Specification {
    events: Vec<Event>,
    faults: Vec<Fault>,
    seed: u64,
}

impl From<Specification> for Scenario {
    fn from(Specification { events, faults, seed }: Specification) -> Self {
        Self::new(events, faults, seed)
    }
}

impl From<Scenario> for Specification {
    fn from(Scenario { events, faults, seed, .. }: Scenario) -> Self {
        Self { events, faults, seed }
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Event {
    time: Time,
    what: Action,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
enum Action {
    Override(String, f64),
    Bias(String, f64),
    Reset(String),
    End,
}

impl Scenario {
    /// Reads a file.
    #[cfg(feature = "files")]
    pub fn read(file: impl AsRef<Path>) -> Result<Self> {
        let file = file.as_ref();
        let text = cosim_base::files::read_input_text(file)
            .map_err(|e| Error::new(Code::File, "the scenario cannot be read").at(file).why(e))?;
        if file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml")) {
            return faults::parse(&text, file);
        }
        osp::parse(&text, file)
    }

    /// Draws all random numbers of the faults from another root seed than that of the file.
    #[must_use]
    pub fn seeded(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Resolves other names of variables and components.
    #[must_use]
    pub fn renamed(mut self, aliases: &Aliases) -> Self {
        let of_events = self.events.iter_mut().filter_map(|event| match &mut event.what {
            Action::Override(name, _) | Action::Bias(name, _) | Action::Reset(name) => Some(name),
            Action::End => None,
        });
        let of_faults = self.faults.iter_mut().flat_map(|fault| {
            let watched = match &mut fault.begin {
                Begin::When(condition) => Some(&mut condition.variable),
                _ => None,
            };
            fault.variables.iter_mut().chain(watched)
        });
        of_events.chain(of_faults).for_each(|name| *name = aliases.resolve(name));
        self
    }

    /// Whether it can act where nothing is recorded and the importer decides the end; the error
    /// says why not.
    pub fn runs_without_records(&self) -> Result<()> {
        let wrong = |what: &str, help: &str| Err(Error::new(Code::Scenario, what).help(help));
        if self.watched().next().is_some() {
            return wrong(
                "a fault that waits for a condition cannot be exported",
                "start it at an instant: `from` or `between`",
            );
        }
        if self.events.iter().any(|event| event.what == Action::End) {
            return wrong("an end cannot be exported", "remove it: the importer ends the run");
        }
        Ok(())
    }

    /// The variables used in conditions of faults: they must be recorded.
    pub fn watched(&self) -> impl Iterator<Item = &str> {
        self.faults.iter().filter_map(|fault| match &fault.begin {
            Begin::When(condition) => Some(condition.variable.as_str()),
            _ => None,
        })
    }

    fn new(mut events: Vec<Event>, faults: Vec<Fault>, seed: u64) -> Self {
        // Stable: events at the same instant stay in the order of the file.
        events.sort_by_key(|event| event.time);
        Self {
            events,
            done: 0,
            faults,
            seed,
            targets: Vec::new(),
            resets: Vec::new(),
            installs: Vec::new(),
            waiting: Vec::new(),
            look: Time::NEVER,
            start: Time::ZERO,
            interval: Step::whole(Time::from_ns(1)),
        }
    }

    /// The variables of the faults, and problems with their times.
    fn aim(&mut self, system: &System) -> Vec<Error> {
        let mut problems = Vec::new();
        self.targets.clear();
        for (position, fault) in self.faults.iter().enumerate() {
            let wrong = |what: String| {
                Error::new(Code::Scenario, format!("fault {}: {what}", position + 1))
            };
            let mut targets = Vec::new();
            for name in &fault.variables {
                let found = match fault.kind {
                    Kind::Reset => system.resettable(name).map(|_| vec![name.clone()]),
                    _ => system.manipulables(name),
                };
                match found {
                    Ok(found) => targets.extend(found),
                    Err(problem) => problems.push(problem),
                }
            }
            self.targets.push(targets);
            let stop = system.stop_time();
            let first = match &fault.begin {
                Begin::Start => system.start_time(),
                Begin::At(time) | Begin::Between(time, _) => *time,
                Begin::When(condition) => {
                    let columns = || system.columns().iter();
                    let name = condition.variable.as_str();
                    let found = columns().find(|column| column.name == name);
                    let found = found.map_or_else(
                        || {
                            let names = columns().map(|column| column.name.as_str());
                            let help = names::did_you_mean(name, names).unwrap_or_else(|| {
                                format!("also record it: --output-variable '{name}'")
                            });
                            Err(Error::new(Code::UnknownName, format!("'{name}' is not recorded"))
                                .why(format!("fault {} begins when {condition}", position + 1))
                                .help(help))
                        },
                        Column::is_number,
                    );
                    problems.extend(found.err());
                    continue;
                }
            };
            if first >= stop {
                let what = format!("it begins at {first}, and the run ends at {stop}");
                problems.push(wrong(what).help("use an earlier start, or a later stop time"));
            }
            if matches!(fault.end, End::At(end) if end <= system.start_time()) {
                problems.push(wrong("it ends before the run begins".to_owned()));
            }
        }
        problems
    }
}

impl Manipulator for Scenario {
    fn start(&mut self, system: &System, resumed: Option<Time>) -> Result<()> {
        let names = self.events.iter().filter_map(|event| match &event.what {
            Action::Override(name, _) | Action::Bias(name, _) | Action::Reset(name) => Some(name),
            Action::End => None,
        });
        let mut problems: Vec<Error> =
            names.filter_map(|name| system.manipulable(name).err()).collect();
        problems.extend(self.aim(system));
        Error::all(problems)?;
        let happened = |event: &&Event| resumed.is_some_and(|resumed| event.time <= resumed);
        self.done = self.events.iter().take_while(happened).count();
        (self.start, self.interval) = (system.start_time(), system.output_interval());
        // In a snapshot they are already installed.
        let install = |(number, fault): (usize, &Fault)| {
            (fault.installed.map_or(self.start, |at| at.max(self.start)), number)
        };
        self.installs = self.faults.iter().enumerate().map(install).collect();
        self.installs.retain(|(time, _)| resumed.is_none_or(|resumed| *time > resumed));
        self.installs.sort_by(|one, other| other.cmp(one));
        let reset = |(number, fault): (usize, &Fault)| {
            let begins = fault.begins(self.seed, number as u32, self.start);
            let own = fault.kind == Kind::Reset && !at_once(fault);
            begins.filter(|_| own).map(|time| (time, number))
        };
        self.resets = self.faults.iter().enumerate().filter_map(reset).collect();
        self.resets.retain(|(time, _)| resumed.is_none_or(|resumed| *time > resumed));
        self.resets.sort_by(|one, other| other.cmp(one));
        let waits = |fault: &usize| matches!(self.faults[*fault].begin, Begin::When(_));
        self.waiting = (0..self.faults.len()).filter(waits).collect();
        self.look = match (self.waiting.is_empty(), resumed) {
            (true, _) => Time::NEVER,
            (false, None) => self.start,
            (false, Some(resumed)) => self.start + self.interval.after(resumed - self.start),
        };
        Ok(())
    }

    fn next(&self) -> Option<Time> {
        let event = self.events.get(self.done).map(|event| event.time);
        let look = (self.look != Time::NEVER).then_some(self.look);
        let reset = self.resets.last().map(|(time, _)| *time);
        let install = self.installs.last().map(|(time, _)| *time);
        event.into_iter().chain(install).chain(look).chain(reset).min()
    }

    fn act(&mut self, now: Time, controls: &mut Controls<'_>) -> Result<()> {
        while let Some((_, number)) = self.installs.pop_if(|(time, _)| *time <= now) {
            self.install(number, controls)?;
        }
        while let Some(event) = self.events.get(self.done).filter(|event| event.time <= now) {
            match &event.what {
                Action::Override(name, value) => controls.set(name, *value)?,
                Action::Bias(name, value) => controls.bias(name, *value)?,
                Action::Reset(name) => controls.release(name)?,
                Action::End => controls.end(Stop::Enough),
            }
            self.done += 1;
        }
        while let Some((_, fault)) = self.resets.pop_if(|(time, _)| *time <= now) {
            self.targets[fault].iter().try_for_each(|name| controls.reset(name))?;
        }
        if self.look <= now {
            self.check_conditions(controls)?;
            let next = self.start + self.interval.after(now - self.start);
            self.look = if self.waiting.is_empty() { Time::NEVER } else { next };
        }
        Ok(())
    }
}

impl Scenario {
    /// Installs a fault on its variables.
    fn install(&self, number: usize, controls: &mut Controls<'_>) -> Result<()> {
        let fault = &self.faults[number];
        let is_reset = fault.kind == Kind::Reset;
        if is_reset && !matches!(fault.begin, Begin::When(_)) {
            let names = self.targets[number].iter().filter(|_| at_once(fault));
            return names.into_iter().try_for_each(|name| controls.reset(name));
        }
        self.targets[number].iter().zip(0..).try_for_each(|(target, place)| {
            let acting = fault.acting(self.seed, number as u32, place, self.start);
            if is_reset {
                controls.install_reset(target, acting)
            } else {
                controls.install(target, acting)
            }
        })
    }

    /// Starts the faults whose condition holds. After a resumption, faults that have already
    /// started are notified again; they ignore it.
    fn check_conditions(&mut self, controls: &mut Controls<'_>) -> Result<()> {
        let mut waiting = std::mem::take(&mut self.waiting);
        let mut outcome = Ok(());
        waiting.retain(|&fault| {
            let Begin::When(condition) = &self.faults[fault].begin else { return false };
            let value = controls.recorded(&condition.variable);
            if !value.is_some_and(|value| condition.holds(value)) {
                return true;
            }
            for target in &self.targets[fault] {
                let triggered = match self.faults[fault].kind {
                    Kind::Reset => controls.trigger_reset(target, fault as u32),
                    _ => controls.trigger(target, fault as u32),
                };
                if outcome.is_ok() {
                    outcome = triggered;
                }
            }
            false
        });
        self.waiting = waiting;
        outcome
    }
}

/// Whether a fault begins when it is installed: then a reset happens between the faults installed
/// before and after it.
fn at_once(fault: &Fault) -> bool {
    matches!((&fault.begin, fault.installed), (Begin::At(from), Some(at)) if *from == at)
}
