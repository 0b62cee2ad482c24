//! A system inside an FMU.

use std::path::Path;

use cosim_base::texts::Scope;
use cosim_base::{Code, Error, Result, Time, time};
use cosim_core::hosted::{Basic, Hosted, Kept};
use cosim_import::calls::Values;
use cosim_import::{Category, Message, Value};
use cosim_served::{Experiment, Inside};

/// A hosted system with no other references to it, and the lifetime of its Strings.
pub struct System(Hosted, Scope);

// SAFETY: shared data inside (patches in `Rc`, handles of FMUs) are shared only among parts of this
// value, which move between threads together; FMI requires importers to call an instance from one
// thread at a time, and the same holds for our calls of the inner FMUs.
#[allow(unsafe_code)]
unsafe impl Send for System {}

impl System {
    pub(crate) fn open(folder: &Path, debug: bool) -> Result<Self> {
        let texts = Scope::begin();
        Ok(Self(Hosted::open(folder, debug)?, texts))
    }

    fn numbers<T>(
        &mut self,
        basic: Basic,
        references: &[u32],
        of: impl Fn(f64) -> T,
    ) -> Result<Vec<T>> {
        references.iter().map(|reference| self.0.number(basic, *reference).map(&of)).collect()
    }
}

impl Inside for System {
    type Kept = Kept;

    fn guid(&self) -> &str {
        self.0.guid()
    }

    #[inline]
    fn messages(&mut self) -> Vec<Message> {
        self.0.messages()
    }

    fn debug(&mut self, on: bool, categories: &[&str]) -> Result<()> {
        if let Some(unknown) = categories.iter().find(|name| !Category::is_known(name)) {
            let what = format!("unknown log category \"{unknown}\"");
            let all = Category::ALL.map(Category::name).join(", ");
            return Err(Error::new(Code::UnknownName, what).why(format!("there are {all}")));
        }
        self.0.debug(on)
    }

    fn reset(&mut self) -> Result<()> {
        self.0.reset();
        Ok(())
    }

    fn enter(&mut self, experiment: &Experiment) -> Result<()> {
        let start = time::from_seconds(experiment.start_s, "the start time")?;
        let stop = experiment.stop_s.map(|stop| time::from_seconds(stop, "the stop time"));
        self.0.enter(start, stop.transpose()?.unwrap_or(Time::NEVER), experiment.tolerance)
    }

    fn exit(&mut self) -> Result<Vec<String>> {
        self.0.exit()
    }

    fn terminate(&mut self) -> Result<()> {
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64) -> Result<()> {
        self.0.advance(time::from_seconds(t + h, "the end of the step")?)
    }

    #[inline]
    fn at_hand(&self, references: &[u32], into: &mut [f64]) -> Option<()> {
        self.0.at_hand(references, into)
    }

    fn get(&mut self, basic: Basic, references: &[u32]) -> Result<Values> {
        Ok(match basic {
            Basic::Real => Values::Real(self.numbers(basic, references, |value| value)?),
            Basic::Integer => {
                Values::Integer(self.numbers(basic, references, |value| value as i32)?)
            }
            Basic::Boolean => {
                Values::Boolean(self.numbers(basic, references, |value| value != 0.0)?)
            }
            Basic::String => {
                let texts = references.iter().map(|reference| self.0.text(*reference));
                Values::String(texts.collect::<Result<_>>()?)
            }
        })
    }

    fn set(&mut self, references: &[u32], values: Values) -> Result<()> {
        let basic = values.basic();
        for reference in references {
            self.0.settable(basic, *reference)?;
        }
        let values: Vec<Value> = match values {
            Values::Real(values) => values.into_iter().map(Value::Real).collect(),
            Values::Integer(values) => values.into_iter().map(Value::Integer).collect(),
            Values::Boolean(values) => values.into_iter().map(Value::Boolean).collect(),
            Values::String(values) => values.into_iter().map(Value::String).collect(),
        };
        let mut pairs = references.iter().zip(values);
        pairs.try_for_each(|(reference, value)| self.0.set(basic, *reference, value))
    }

    fn slope(&mut self, _: &[u32], _: &[u32], _: &[f64]) -> Option<Result<Vec<f64>>> {
        None
    }

    fn save(&mut self) -> Result<Kept> {
        self.0.save()
    }

    fn restore(&mut self, kept: &Kept) -> Result<()> {
        self.0.restore(kept)
    }
}
