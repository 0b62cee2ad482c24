//! An object of a Python class, inside an FMU.

use std::path::{Path, PathBuf};

use cosim_base::{Code, Error, Result};
use cosim_import::Basic;
use cosim_import::Message;
use cosim_import::calls::Values;
use cosim_import::scripted::Manifest;
use cosim_served::{Experiment, Inside};
use fmu_kit::{Sampler, Time};
use serde::{Deserialize, Serialize};

use crate::process::{Ask, Process};

/// An object of a class, and its variables. The Reals are inputs, outputs and parameters, one after
/// another.
pub struct Scripted {
    manifest: Manifest,
    resources: PathBuf,
    /// Until the instance is dropped.
    process: Option<Process>,
    run: Run,
}

/// Everything in a saved state besides the object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Run {
    stage: Stage,
    reals: Vec<f64>,
    integers: Vec<i32>,
    booleans: Vec<bool>,
    texts: Vec<String>,
    /// When the class is stepped.
    sampler: Sampler,
    /// The object exists, and the outputs are those of its last step.
    made: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Stage {
    Setting,
    Initializing,
    Stepping,
}

/// A saved state: variables, and the object if there is one.
#[derive(Clone, Serialize, Deserialize)]
pub struct Kept {
    run: Run,
    object: Option<Vec<u8>>,
}

impl Scripted {
    pub(crate) fn open(resources: &Path, guid: &str) -> Result<Self> {
        let manifest = Manifest::read(resources)?;
        // Python is not started if the request would be refused afterwards.
        let own = manifest.guid == guid;
        let process = own.then(|| Process::of(resources, &manifest)).transpose()?;
        let run = Run::fresh(&manifest);
        Ok(Self { manifest, resources: resources.to_owned(), process, run })
    }

    fn process(&mut self) -> Result<&mut Process> {
        self.process.as_mut().ok_or_else(|| Error::new(Code::Lost, "there is no Python process"))
    }

    /// Creates the object, and steps it at the start.
    fn begin(&mut self) -> Result<()> {
        let parameters = serde_json::Value::from_iter(self.parameters());
        self.process()?.ask(Ask::Make, &[parameters.to_string().as_bytes()])?;
        self.sample(self.run.sampler.last())?;
        self.run.made = true;
        Ok(())
    }

    /// The current parameters.
    fn parameters(&self) -> impl Iterator<Item = (String, serde_json::Value)> {
        let mut next = self.first_parameters();
        self.manifest.parameters.iter().map(move |parameter| {
            let place = next[parameter.basic as usize];
            next[parameter.basic as usize] += 1;
            let value = match parameter.basic {
                Basic::Real => self.run.reals[place].into(),
                Basic::Integer => self.run.integers[place].into(),
                Basic::Boolean => self.run.booleans[place].into(),
                Basic::String => self.run.texts[place].as_str().into(),
            };
            (parameter.name.clone(), value)
        })
    }

    /// For each type, the value reference of the first parameter.
    fn first_parameters(&self) -> [usize; Basic::ALL.len()] {
        [self.manifest.inputs.len() + self.manifest.outputs.len(), 0, 0, 0]
    }

    /// Steps the object.
    fn sample(&mut self, at: Time) -> Result<()> {
        let (inputs, outputs) = (self.manifest.inputs.len(), self.manifest.outputs.len());
        let numbers = std::iter::once(at.seconds()).chain(self.run.reals[..inputs].iter().copied());
        let octets: Vec<u8> = numbers.flat_map(f64::to_le_bytes).collect();
        let process = self.process.as_mut();
        let process =
            process.ok_or_else(|| Error::new(Code::Lost, "there is no Python process"))?;
        let given = process.ask(Ask::Step, &[&octets])?;
        let (given, rest) = given.as_chunks::<8>();
        if given.len() != outputs || !rest.is_empty() {
            return Err(Error::new(Code::Protocol, "the returned values do not match the outputs"));
        }
        let places = &mut self.run.reals[inputs..inputs + outputs];
        places
            .iter_mut()
            .zip(given)
            .for_each(|(place, octets)| *place = f64::from_le_bytes(*octets));
        Ok(())
    }

    /// Whether these may be set now: inputs always, parameters before the simulation.
    fn settable(&self, basic: Basic, reference: u32, finite: bool) -> Result<()> {
        let (inputs, first) = (self.manifest.inputs.len(), self.first_parameters()[basic as usize]);
        let is_input = basic == Basic::Real && (reference as usize) < inputs;
        let is_parameter = reference as usize >= first;
        let wrong = |why: &str| {
            let what = format!("{basic:?} {reference} cannot be set: {why}");
            Err(Error::new(Code::Parameter, what))
        };
        match (is_input, is_parameter, self.run.stage) {
            (true, ..) => Ok(()),
            (_, true, Stage::Stepping) => {
                wrong("a parameter is fixed once the simulation has started")
            }
            (_, true, _) if !finite => wrong("a parameter must be finite"),
            (_, true, _) => Ok(()),
            _ => wrong("it is an output"),
        }
    }
}

impl Run {
    fn fresh(manifest: &Manifest) -> Self {
        let ports = manifest.inputs.len() + manifest.outputs.len();
        let mut run = Self {
            stage: Stage::Setting,
            reals: vec![0.0; ports],
            integers: Vec::new(),
            booleans: Vec::new(),
            texts: Vec::new(),
            sampler: Sampler::new(Time::default(), 1.0 / manifest.rate),
            made: false,
        };
        for parameter in &manifest.parameters {
            let start = &parameter.start;
            match parameter.basic {
                Basic::Real => run.reals.push(start.as_f64().unwrap_or_default()),
                Basic::Integer => {
                    let start = start.as_i64().and_then(|start| i32::try_from(start).ok());
                    run.integers.push(start.unwrap_or_default());
                }
                Basic::Boolean => run.booleans.push(start.as_bool().unwrap_or_default()),
                Basic::String => run.texts.push(start.as_str().unwrap_or_default().to_owned()),
            }
        }
        run
    }

    fn counts(&self) -> [usize; Basic::ALL.len()] {
        [self.reals.len(), self.integers.len(), self.booleans.len(), self.texts.len()]
    }
}

/// The values with these references.
fn chosen<T: Clone>(all: &[T], references: &[u32]) -> Result<Vec<T>> {
    references
        .iter()
        .map(|reference| all.get(*reference as usize).cloned().ok_or_else(|| unknown(*reference)))
        .collect()
}

fn unknown(reference: u32) -> Error {
    Error::new(Code::UnknownName, format!("there is no variable {reference} of this type"))
}

/// Sets values, all of which exist.
fn assign<T>(all: &mut [T], references: &[u32], values: Vec<T>) {
    for (reference, value) in references.iter().zip(values) {
        if let Some(place) = all.get_mut(*reference as usize) {
            *place = value;
        }
    }
}

impl Inside for Scripted {
    type Kept = Kept;
    /// A class gets the measurements of sensors as they are, finite or not, and has to handle them.
    const TAKES_ANY_REAL: bool = true;

    fn guid(&self) -> &str {
        &self.manifest.guid
    }

    #[inline]
    fn messages(&mut self) -> Vec<Message> {
        Vec::new()
    }

    fn debug(&mut self, _: bool, _: &[&str]) -> Result<()> {
        Ok(())
    }

    fn reset(&mut self) -> Result<()> {
        self.run = Run::fresh(&self.manifest);
        Ok(())
    }

    fn enter(&mut self, experiment: &Experiment) -> Result<()> {
        let start = Time::from_seconds(experiment.start_s);
        self.run.sampler = Sampler::new(start, 1.0 / self.manifest.rate);
        self.run.stage = Stage::Initializing;
        Ok(())
    }

    fn exit(&mut self) -> Result<Vec<String>> {
        if !self.run.made {
            self.begin()?;
        }
        self.run.stage = Stage::Stepping;
        Ok(Vec::new())
    }

    fn terminate(&mut self) -> Result<()> {
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64) -> Result<()> {
        let end = Time::from_seconds(t + h);
        while self.run.sampler.next() <= end {
            self.sample(self.run.sampler.next())?;
            self.run.sampler.advance();
        }
        Ok(())
    }

    #[inline]
    fn at_hand(&self, references: &[u32], into: &mut [f64]) -> Option<()> {
        for (reference, place) in references.iter().zip(into) {
            *place = *self.run.reals.get(*reference as usize)?;
        }
        Some(())
    }

    fn get(&mut self, basic: Basic, references: &[u32]) -> Result<Values> {
        // Outputs at the start depend on the inputs at that time.
        if basic == Basic::Real && self.run.stage == Stage::Initializing && !self.run.made {
            self.begin()?;
        }
        Ok(match basic {
            Basic::Real => Values::Real(chosen(&self.run.reals, references)?),
            Basic::Integer => Values::Integer(chosen(&self.run.integers, references)?),
            Basic::Boolean => Values::Boolean(chosen(&self.run.booleans, references)?),
            Basic::String => Values::String(chosen(&self.run.texts, references)?),
        })
    }

    fn set(&mut self, references: &[u32], values: Values) -> Result<()> {
        let basic = values.basic();
        let count = self.run.counts()[basic as usize];
        for (place, &reference) in references.iter().enumerate() {
            let finite = match &values {
                Values::Real(values) => values.get(place).is_some_and(|value| value.is_finite()),
                _ => true,
            };
            if reference as usize >= count {
                return Err(unknown(reference));
            }
            self.settable(basic, reference, finite)?;
        }
        match values {
            Values::Real(values) => assign(&mut self.run.reals, references, values),
            Values::Integer(values) => assign(&mut self.run.integers, references, values),
            Values::Boolean(values) => assign(&mut self.run.booleans, references, values),
            Values::String(values) => assign(&mut self.run.texts, references, values),
        }
        if self.run.stage != Stage::Stepping {
            self.run.made = false;
        }
        Ok(())
    }

    fn slope(&mut self, _: &[u32], _: &[u32], _: &[f64]) -> Option<Result<Vec<f64>>> {
        None
    }

    fn save(&mut self) -> Result<Kept> {
        let object = match self.run.made {
            true => Some(self.process()?.ask(Ask::Save, &[])?.to_vec()),
            false => None,
        };
        Ok(Kept { run: self.run.clone(), object })
    }

    fn restore(&mut self, kept: &Kept) -> Result<()> {
        if kept.run.counts() != self.run.counts() || kept.run.made != kept.object.is_some() {
            return Err(Error::new(Code::State, "the state does not belong to this class"));
        }
        if let Some(object) = &kept.object {
            self.process()?.ask(Ask::Restore, &[object])?;
        }
        self.run = kept.run.clone();
        Ok(())
    }
}

impl Drop for Scripted {
    fn drop(&mut self) {
        if let Some(process) = self.process.take() {
            process.release(&self.resources);
        }
    }
}
