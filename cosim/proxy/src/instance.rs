//! An instance in another process, inside an FMU here.

use std::path::Path;

use cosim_base::{Code, Error, Result};
use cosim_import::Basic;
use cosim_import::Message;
use cosim_import::calls::{Ask, Given, Outcome, Trouble, Values};
use cosim_import::proxy::frames::{Reply, Request};
use cosim_import::proxy::link::Link;
use cosim_import::proxy::manifest::Manifest;
use cosim_served::{Experiment, Inside};

use crate::values::Known;

/// Category of warnings.
const WARNING: i32 = 1;

/// An instance in another process.
pub struct Remote {
    manifest: Manifest,
    name: String,
    link: Link,
    known: Known,
    /// Inputs that were set and are sent with the next step.
    held: Vec<Ask>,
    /// Steps are being made.
    stepping: bool,
    messages: Vec<Message>,
}

impl Remote {
    pub(crate) fn make(resources: &Path, name: &str, guid: &str, debug: bool) -> Result<Self> {
        let manifest = Manifest::read(resources)?;
        let mut link = Link::start(resources)?;
        // Nothing is requested that would be refused afterwards.
        if manifest.guid == guid {
            let (resources, name) = (resources.to_owned(), name.to_owned());
            if let Reply::Lost(why) = link.ask(&Request::Make { resources, name, debug })? {
                return Err(Error::new(Code::Lost, why));
            }
        }
        Ok(Self::over(link, manifest, name))
    }

    fn over(link: Link, manifest: Manifest, name: &str) -> Self {
        Self {
            known: Known::new(&manifest.outputs),
            manifest,
            name: name.to_owned(),
            link,
            held: Vec::new(),
            stepping: false,
            messages: Vec::new(),
        }
    }

    /// Makes calls, after those that were held back.
    fn ask(&mut self, asks: impl IntoIterator<Item = Ask>) -> Result<Outcome> {
        let mut all = std::mem::take(&mut self.held);
        let held = all.len();
        all.extend(asks);
        let mut outcome = match self.link.ask(&Request::Calls(all))? {
            Reply::Done(outcome, messages, notes) => {
                self.messages.extend(messages);
                let note = |text| {
                    let (instance, category) = (self.name.clone(), "recovered".to_owned());
                    Message { instance, status: WARNING, category, text }
                };
                self.messages.extend(notes.into_iter().map(note));
                outcome
            }
            Reply::Lost(why) => return Err(Error::new(Code::Lost, why)),
            Reply::Working => return Err(Error::new(Code::Protocol, "there is no answer")),
        };
        outcome.given.drain(..held.min(outcome.given.len()));
        Ok(outcome)
    }

    /// Makes calls that must all succeed.
    fn all(&mut self, asks: impl IntoIterator<Item = Ask>) -> Result<Vec<Given>> {
        let outcome = self.ask(asks)?;
        outcome.trouble.map_or(Ok(outcome.given), |trouble| Err(failed(trouble)))
    }

    fn done(&mut self, asks: impl IntoIterator<Item = Ask>) -> Result<()> {
        self.known.age();
        self.all(asks).map(drop)
    }

    fn is_input(&self, basic: Basic, reference: u32) -> bool {
        self.manifest.inputs[basic as usize].binary_search(&reference).is_ok()
    }
}

impl Inside for Remote {
    /// The state of the instance, and whether it has made steps.
    type Kept = (Vec<u8>, bool);

    fn guid(&self) -> &str {
        &self.manifest.guid
    }

    #[inline]
    fn messages(&mut self) -> Vec<Message> {
        if self.messages.is_empty() { Vec::new() } else { std::mem::take(&mut self.messages) }
    }

    fn debug(&mut self, on: bool, categories: &[&str]) -> Result<()> {
        let categories = categories.iter().map(|&name| name.to_owned()).collect();
        self.done([Ask::Debug(on, categories)])
    }

    fn reset(&mut self) -> Result<()> {
        self.held.clear();
        self.stepping = false;
        self.done([Ask::Reset])
    }

    fn enter(&mut self, experiment: &Experiment) -> Result<()> {
        let Experiment { tolerance, start_s, stop_s } = *experiment;
        self.done([Ask::SetUp(tolerance, start_s, stop_s), Ask::Enter])
    }

    fn exit(&mut self) -> Result<Vec<String>> {
        self.done([Ask::Exit])?;
        self.stepping = true;
        Ok(Vec::new())
    }

    /// The instance is terminated when it is freed: the caller does not wait.
    fn terminate(&mut self) -> Result<()> {
        self.held.clear();
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64) -> Result<()> {
        self.known.age();
        let reads: Vec<Ask> = self.known.asks().collect();
        let outcome = self.ask([Ask::Step(t, h)].into_iter().chain(reads))?;
        match outcome.trouble {
            Some(trouble) if outcome.given.is_empty() => Err(failed(trouble)),
            // The step was made. If a value cannot be read, reading it reports the error.
            Some(_) => {
                self.known.forget();
                Ok(())
            }
            None => {
                self.known.take(outcome.given.into_iter().skip(1));
                Ok(())
            }
        }
    }

    #[inline]
    fn at_hand(&self, references: &[u32], into: &mut [f64]) -> Option<()> {
        self.known.reals(references, into)
    }

    fn get(&mut self, basic: Basic, references: &[u32]) -> Result<Values> {
        if let Some(values) = self.known.values(basic, references) {
            return Ok(values);
        }
        let given = self.all([Ask::Get(basic, references.to_vec())])?;
        match given.into_iter().next() {
            Some(Given::Values(values)) => {
                if self.stepping {
                    self.known.expect(basic, references);
                }
                Ok(values)
            }
            _ => Err(Error::new(Code::Protocol, "no values were returned")),
        }
    }

    fn set(&mut self, references: &[u32], values: Values) -> Result<()> {
        let basic = values.basic();
        let inputs = references.iter().all(|&reference| self.is_input(basic, reference));
        let ask = Ask::Set(references.to_vec(), values);
        if self.stepping && inputs {
            self.known.age();
            self.held.push(ask);
            return Ok(());
        }
        self.done([ask])
    }

    fn slope(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        along: &[f64],
    ) -> Option<Result<Vec<f64>>> {
        if !self.manifest.derivative {
            return None;
        }
        let ask = Ask::Derivative(unknowns.to_vec(), knowns.to_vec(), along.to_vec());
        Some(self.all([ask]).and_then(|given| match given.into_iter().next() {
            Some(Given::Values(Values::Real(values))) => Ok(values),
            _ => Err(Error::new(Code::Protocol, "no derivatives were returned")),
        }))
    }

    fn save(&mut self) -> Result<Self::Kept> {
        match self.all([Ask::Save])?.pop() {
            Some(Given::State(state)) => Ok((state, self.stepping)),
            _ => Err(Error::new(Code::Protocol, "no state was returned")),
        }
    }

    fn restore(&mut self, (state, stepping): &Self::Kept) -> Result<()> {
        self.held.clear();
        self.done([Ask::Restore(state.clone())])?;
        self.stepping = *stepping;
        Ok(())
    }
}

fn failed(trouble: Trouble) -> Error {
    let code = if trouble.ended { Code::Ended } else { Code::Fmu };
    Error::new(code, trouble.text).returned(trouble.status)
}

#[cfg(test)]
mod tests;
