//! Faults that are put into a run while it goes on, and the scenario that puts them in again.

use std::path::Path;

use serde_json::{Map, Value};

use super::faults;
use crate::error::{Code, Error, Result};
use crate::fault::Window;
use crate::master::Controls;
use crate::observe::Recording;
use crate::time::Time;

/// What was put in so far.
#[derive(Debug, Default)]
pub struct Injected {
    text: String,
    count: usize,
}

/// Random numbers of injected faults are not those of a scenario's, whose seed is 0 by default.
const SEED: u64 = 0x6c69_7665;

/// What says when a fault begins: an injected one begins when it is injected.
const BEGINNINGS: [&str; 4] = ["installed", "from", "between", "when"];

impl Injected {
    /// Puts a fault in, which begins now: keys and values as in a file of TOML. Gives when it acts.
    /// What is wrong with it is an error, and changes nothing.
    pub fn inject(
        &mut self,
        wanted: &Map<String, Value>,
        now: Time,
        controls: &mut Controls<'_>,
    ) -> Result<Window> {
        if let Some(key) = BEGINNINGS.iter().find(|key| wanted.contains_key(**key)) {
            return Err(Error::new(Code::Scenario, format!("'{key}' cannot be said here"))
                .why("a fault that is injected begins at once"));
        }
        let mut text = String::from("[[fault]]\n");
        for (key, value) in wanted {
            text += &format!("{} = {}\n", quoted(key), toml(key, value)?);
        }
        let instant = format!("{:?}", now.seconds());
        text += &format!("installed = {instant}\nfrom = {instant}\n\n");
        let before = if self.count == 0 { format!("seed = {SEED}\n\n") } else { self.text.clone() };
        let whole = before + &text;
        let mut scenario = faults::parse(&whole, Path::new("the injected fault"))?;
        let system = controls.system();
        Error::all(scenario.aim(system))?;
        scenario.start = system.start_time();
        let number = self.count;
        let instant = Recording::from_columns(Vec::new(), vec![now.seconds()], Vec::new());
        let window = scenario.faults[number].window(SEED, number as u32, &instant);
        let window = window
            .ok_or_else(|| Error::new(Code::Scenario, "the fault does not begin in this run"))?;
        scenario.install(number, controls)?;
        (self.text, self.count) = (whole, number + 1);
        Ok(window)
    }

    /// The scenario that does to another run what was done to this one; nothing if that was nothing.
    pub fn text(&self) -> Option<&str> {
        (self.count > 0).then_some(self.text.as_str())
    }
}

/// As a text of TOML.
fn quoted(text: &str) -> String {
    // What JSON escapes, TOML reads alike; DEL alone it forbids.
    Value::from(text).to_string().replace('\u{7f}', "\\u007f")
}

fn toml(key: &str, value: &Value) -> Result<String> {
    match value {
        Value::Number(number) => Ok(number.to_string()),
        Value::Bool(value) => Ok(value.to_string()),
        Value::String(text) => Ok(quoted(text)),
        Value::Array(parts) => {
            let parts = parts.iter().map(|part| toml(key, part)).collect::<Result<Vec<_>>>()?;
            Ok(format!("[{}]", parts.join(", ")))
        }
        Value::Null | Value::Object(_) => {
            Err(Error::new(Code::Scenario, format!("'{key}' is no number, text or list")))
        }
    }
}
