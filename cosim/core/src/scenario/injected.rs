//! Faults that are injected into a running simulation, and the scenario that repeats them.

use std::path::Path;

use serde_json::{Map, Value};

use super::faults;
use crate::fault::Window;
use crate::master::Controls;
use crate::observe::Recording;
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::Time;

/// The faults injected so far.
#[derive(Debug, Default)]
pub struct Injected {
    text: String,
    count: usize,
}

/// Random numbers of injected faults differ from those of a scenario, whose seed is 0 by default.
const SEED: u64 = 0x6c69_7665;

/// Keys that define when a fault begins: an injected fault begins when it is injected.
const BEGINNINGS: [&str; 4] = ["installed", "from", "between", "when"];

impl Injected {
    /// Injects a fault, which begins now: keys and values as in a TOML file. Returns when it acts.
    /// If it is invalid, the error changes nothing.
    pub fn inject(
        &mut self,
        wanted: &Map<String, Value>,
        now: Time,
        controls: &mut Controls<'_>,
    ) -> Result<Window> {
        if let Some(key) = BEGINNINGS.iter().find(|key| wanted.contains_key(**key)) {
            return Err(Error::new(Code::Scenario, format!("'{key}' cannot be set here"))
                .why("an injected fault begins immediately"));
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

    /// The scenario that repeats the injected faults in another run; `None` if there are none.
    pub fn text(&self) -> Option<&str> {
        (self.count > 0).then_some(self.text.as_str())
    }
}

/// As TOML text.
fn quoted(text: &str) -> String {
    // TOML accepts the escapes of JSON; only DEL is forbidden unescaped.
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
            Err(Error::new(Code::Scenario, format!("'{key}' is not a number, text or list")))
        }
    }
}
