//! `--stop-when`: ends a run when a recorded variable fulfils a condition.

use cosim::observe::{RunInfo, Stop};
use cosim::scenario::Condition;
use cosim::{Code, Error, Observer, Result, Time, names};

/// An observer that ends the run at the first sample that fulfils one of the conditions.
pub(crate) struct StopWhen {
    conditions: Vec<Condition>,
    /// Positions of their variables among the columns.
    columns: Vec<usize>,
    /// Which condition held, and when.
    held: Option<String>,
}

impl StopWhen {
    pub(crate) fn new(conditions: &[Condition]) -> Self {
        Self { conditions: conditions.to_vec(), columns: Vec::new(), held: None }
    }

    /// Why the run was ended, if it was.
    pub(crate) fn held(&self) -> Option<&str> {
        self.held.as_deref()
    }
}

impl Observer for StopWhen {
    fn start(&mut self, info: &RunInfo<'_>) -> Result<()> {
        for Condition { variable, .. } in &self.conditions {
            let found = info.columns.iter().position(|column| column.name == *variable);
            let known = || info.columns.iter().map(|column| column.name.as_str());
            let place = found.ok_or_else(|| {
                Error::new(Code::UnknownName, format!("--stop-when: '{variable}' is not recorded"))
                    .why("conditions are checked when variables are recorded")
                    .help(names::did_you_mean(variable, known()).unwrap_or_else(|| {
                        format!("also record it: --output-variable '{variable}'")
                    }))
            })?;
            info.columns[place].is_number()?;
            self.columns.push(place);
        }
        Ok(())
    }

    fn sample(&mut self, time: Time, values: &[f64]) -> Result<()> {
        let mut all = self.conditions.iter().zip(&self.columns);
        let found = all.find(|(condition, column)| condition.holds(values[**column]));
        self.held = found.map(|(condition, column)| {
            format!("{condition} at t = {time}: it is {}", values[*column])
        });
        Ok(())
    }

    fn finish(&mut self) -> Result<()> {
        Ok(())
    }

    fn stop(&self) -> Option<Stop> {
        self.held.is_some().then_some(Stop::Enough)
    }
}
