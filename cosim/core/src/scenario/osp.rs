//! Reads events from JSON of the Open Simulation Platform.

use std::path::Path;

use serde_json::{Map, Value};

use super::{Action, Event, Scenario};
use cosim_base::error::{Code, Error, Result};
use cosim_base::names;
use cosim_base::time::{self, Time};

const ACTIONS: [&str; 3] = ["override", "bias", "reset"];

pub(super) fn parse(text: &str, file: &Path) -> Result<Scenario> {
    let json: Value = serde_json::from_str(text).map_err(|e| {
        Error::new(Code::Scenario, "the scenario is not JSON").at_line(file, e.line()).why(e)
    })?;
    let wrong = |what: String| Error::new(Code::Scenario, what).at(file);
    let Value::Object(root) = &json else {
        return Err(wrong("the scenario is not a JSON object".to_owned()));
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
    Ok(Scenario::new(events, Vec::new(), 0))
}

fn read_event(event: &Value, defaults: &Map<String, Value>) -> Result<Event, String> {
    let event = event.as_object().ok_or("it is not a JSON object")?;
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
    let value = || value.ok_or("\"value\" is missing, or neither a number nor a Boolean");
    let what = match text("action")? {
        "override" => Action::Override(name, value()?),
        "bias" => Action::Bias(name, value()?),
        "reset" => Action::Reset(name),
        other => {
            let help =
                names::did_you_mean(other, ACTIONS).map_or(String::new(), |h| format!(", {h}"));
            return Err(format!("\"{other}\" is not one of {}{help}", ACTIONS.join(", ")));
        }
    };
    Ok(Event { time, what })
}

fn time(value: Option<&Value>) -> Result<Time, String> {
    let seconds = value.and_then(Value::as_f64).ok_or("\"time\" is missing or not a number")?;
    time::from_seconds(seconds, "the time").map_err(|e| e.what().to_owned())
}

fn unknown_key(object: &Map<String, Value>, known: &[&str]) -> Option<String> {
    let unknown = object.keys().find(|key| !known.contains(&key.as_str()))?;
    let help = names::did_you_mean(unknown, known.iter().copied());
    Some(format!("\"{unknown}\" is unknown; {}", help.unwrap_or_else(|| known.join(", "))))
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
        let at = |seconds, what| Event { time: Time::from_seconds(seconds), what };
        let wanted = [
            at(1.0, Action::Override("a.x".into(), 1.0)),
            at(2.0, Action::Reset("a.x".into())),
            at(2.0, Action::Bias("b.x".into(), -1.5)),
            at(9.0, Action::End),
        ];
        assert_eq!(scenario.events, wanted);
    }

    #[test]
    fn every_mistake_is_reported_with_its_event() {
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
