//! Scenarios: what happens to a system when, from a file.
//!
//! The format is the JSON of the Open Simulation Platform:
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
//! `override` gives the variable that value from then on, `bias` adds the value to it, `reset`
//! ends either. `defaults` stand in for what an event leaves out; `end` ends the run early.
//! Events at one instant happen in the order of the file.

use std::path::Path;

use serde_json::{Map, Value};

use crate::error::{Code, Error, Result};
use crate::master::{Controls, Manipulator};
use crate::names;
use crate::observe::Stop;
use crate::system::System;
use crate::time::Time;

/// A scenario as a manipulator.
#[derive(Debug, Clone)]
pub struct Scenario {
    events: Vec<Event>,
    /// How many of the events have happened.
    done: usize,
}

#[derive(Debug, Clone, PartialEq)]
struct Event {
    time: Time,
    what: Action,
}

#[derive(Debug, Clone, PartialEq)]
enum Action {
    Override(String, f64),
    Bias(String, f64),
    Reset(String),
    End,
}

const ACTIONS: [&str; 3] = ["override", "bias", "reset"];

impl Scenario {
    /// Reads a file.
    pub fn read(file: impl AsRef<Path>) -> Result<Self> {
        let file = file.as_ref();
        let text = std::fs::read_to_string(file)
            .map_err(|e| Error::new(Code::File, "the scenario cannot be read").at(file).why(e))?;
        parse(&text, file)
    }
}

fn parse(text: &str, file: &Path) -> Result<Scenario> {
    let json: Value = serde_json::from_str(text).map_err(|e| {
        Error::new(Code::Scenario, "the scenario is no JSON").at_line(file, e.line()).why(e)
    })?;
    let wrong = |what: String| Error::new(Code::Scenario, what).at(file);
    let Value::Object(root) = &json else {
        return Err(wrong("the scenario is no JSON object".to_owned()));
    };
    let mut problems = Vec::new();
    problems.extend(unknown_key(root, &["description", "defaults", "events", "end"]).map(wrong));
    let empty = Map::new();
    let defaults = root.get("defaults").and_then(Value::as_object).unwrap_or(&empty);
    problems.extend(unknown_key(defaults, &["model", "variable", "action"]).map(wrong));
    let Some(list) = root.get("events").and_then(Value::as_array) else {
        return Err(wrong("the scenario has no list \"events\"".to_owned()));
    };
    let mut events = Vec::new();
    for (position, event) in list.iter().enumerate() {
        match read_event(event, defaults) {
            Ok(event) => events.push(event),
            Err(what) => problems.push(wrong(format!("event {}: {what}", position + 1))),
        }
    }
    if let Some(end) = root.get("end") {
        match time(Some(end)) {
            Ok(time) => events.push(Event { time, what: Action::End }),
            Err(what) => problems.push(wrong(format!("\"end\": {what}"))),
        }
    }
    Error::all(problems)?;
    // Stable: events of one instant stay in the order of the file.
    events.sort_by_key(|event| event.time);
    Ok(Scenario { events, done: 0 })
}

fn read_event(event: &Value, defaults: &Map<String, Value>) -> Result<Event, String> {
    let event = event.as_object().ok_or("it is no JSON object")?;
    let known = ["time", "model", "variable", "action", "value"];
    if let Some(what) = unknown_key(event, &known) {
        return Err(what);
    }
    let text = |name: &str| {
        let found = event.get(name).or_else(|| defaults.get(name));
        let text = found.and_then(Value::as_str);
        text.ok_or_else(|| format!("\"{name}\" is missing, here and in \"defaults\""))
    };
    let time = time(event.get("time"))?;
    let name = format!("{}.{}", text("model")?, text("variable")?);
    let value = match event.get("value") {
        Some(Value::Bool(value)) => Some(f64::from(u8::from(*value))),
        value => value.and_then(Value::as_f64),
    };
    let value = || value.ok_or("\"value\" is missing, or neither number nor Boolean");
    let what = match text("action")? {
        "override" => Action::Override(name, value()?),
        "bias" => Action::Bias(name, value()?),
        "reset" => Action::Reset(name),
        other => {
            let help =
                names::did_you_mean(other, ACTIONS).map_or(String::new(), |h| format!(", {h}"));
            return Err(format!("\"{other}\" is none of {}{help}", ACTIONS.join(", ")));
        }
    };
    Ok(Event { time, what })
}

fn time(value: Option<&Value>) -> Result<Time, String> {
    let seconds = value.and_then(Value::as_f64).ok_or("\"time\" is missing or no number")?;
    Time::from_seconds(seconds, "the time").map_err(|e| e.what().to_owned())
}

fn unknown_key(object: &Map<String, Value>, known: &[&str]) -> Option<String> {
    let unknown = object.keys().find(|key| !known.contains(&key.as_str()))?;
    let help = names::did_you_mean(unknown, known.iter().copied());
    Some(format!("\"{unknown}\" is unknown; {}", help.unwrap_or_else(|| known.join(", "))))
}

impl Manipulator for Scenario {
    fn start(&mut self, system: &System, resumed: Option<Time>) -> Result<()> {
        let names = self.events.iter().filter_map(|event| match &event.what {
            Action::Override(name, _) | Action::Bias(name, _) | Action::Reset(name) => Some(name),
            Action::End => None,
        });
        let problems = names.filter_map(|name| system.manipulable(name).err());
        Error::all(problems.collect())?;
        let happened = |event: &&Event| resumed.is_some_and(|resumed| event.time <= resumed);
        self.done = self.events.iter().take_while(happened).count();
        Ok(())
    }

    fn next(&self) -> Option<Time> {
        self.events.get(self.done).map(|event| event.time)
    }

    fn act(&mut self, now: Time, controls: &mut Controls<'_>) -> Result<()> {
        while let Some(event) = self.events.get(self.done).filter(|event| event.time <= now) {
            match &event.what {
                Action::Override(name, value) => controls.set(name, *value)?,
                Action::Bias(name, value) => controls.bias(name, *value)?,
                Action::Reset(name) => controls.release(name)?,
                Action::End => controls.end(Stop::Enough),
            }
            self.done += 1;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_fill_in_and_the_order_is_that_of_time() {
        let text = r#"{"defaults": {"model": "a", "variable": "x", "action": "override"}, "end": 9,
            "events": [{"time": 2, "action": "reset"}, {"time": 1, "value": true},
                       {"time": 2, "model": "b", "action": "bias", "value": -1.5}]}"#;
        let scenario = parse(text, Path::new("s.json")).unwrap();
        let at = |seconds, what| Event { time: Time::from_seconds(seconds, "t").unwrap(), what };
        let wanted = [
            at(1.0, Action::Override("a.x".into(), 1.0)),
            at(2.0, Action::Reset("a.x".into())),
            at(2.0, Action::Bias("b.x".into(), -1.5)),
            at(9.0, Action::End),
        ];
        assert_eq!(scenario.events, wanted);
    }

    #[test]
    fn every_mistake_is_told_with_its_event() {
        let text = r#"{"event": [], "events": [{"time": "x"}, {"time": 1, "model": "a"},
            {"time": 1, "model": "a", "variable": "x", "action": "overide", "value": 1}]}"#;
        let error = parse(text, Path::new("s.json")).unwrap_err().to_string();
        for part in ["did you mean 'events'", "event 1: \"time\"", "event 2: \"variable\""] {
            assert!(error.contains(part), "{part}: {error}");
        }
        assert!(error.contains("did you mean 'override'") && error.contains("4 problems"));
        assert!(parse("{\n,", Path::new("s.json")).unwrap_err().to_string().contains("s.json:2"));
    }
}
