//! One instance: FMI's states around the inner implementation.

use std::ffi::{CStr, CString};
use std::path::Path;

use cosim_base::{Code, Error};
use cosim_import::Basic;
use cosim_import::calls::Values;
use fmu_kit::kernel::{
    Call, Category, Interface, Log, Phase, Request, SPREAD, Served, Status, Trouble, accepts,
    check_experiment, check_step, hand_out, is_instant, seal, spare, unseal,
};
use serde::{Deserialize, Serialize};

use crate::{Experiment, Inside};

/// Memory for each value that is read or set (bytes); texts are checked before.
const VALUE: usize = 64;

/// An instance.
pub struct Around<I> {
    inside: I,
    run: Run,
    log: Log,
    /// Texts that were returned to the importer and may still be read.
    texts: Vec<CString>,
}

/// The phase of a simulation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Run {
    phase: Phase,
    tolerance: Option<f64>,
    start_s: f64,
    stop_s: Option<f64>,
    time_s: f64,
    /// A component ended the run.
    ended: bool,
}

impl Run {
    const FRESH: Self = Self {
        phase: Phase::Instantiated,
        tolerance: None,
        start_s: 0.0,
        stop_s: None,
        time_s: 0.0,
        ended: false,
    };

    /// Whether its numbers are values that the importer could have passed.
    fn is_sound(&self) -> bool {
        let stop = self.stop_s.is_none_or(|stop| !stop.is_nan());
        is_instant(self.start_s) && is_instant(self.time_s) && stop && self.phase != Phase::Fatal
    }
}

/// A saved state.
#[derive(Clone, Serialize, Deserialize)]
pub struct State<K> {
    guid: String,
    run: Run,
    kept: K,
}

impl<I: Inside> Around<I> {
    /// Creates the inner implementation from the folder of the FMU's resources with `open`.
    ///
    /// # Errors
    /// As one line.
    pub fn new(
        request: Request<'_>,
        open: impl FnOnce(&Request<'_>, &Path) -> cosim_base::Result<I>,
    ) -> Result<Self, String> {
        if request.interface != Interface::CoSimulation {
            return Err("the FMU offers co-simulation only, not model exchange".to_owned());
        }
        let folder = request.resources.folder().ok_or(
            "fmuResourceLocation is missing or not a folder; the FMU needs the files in \
             its resources",
        )?;
        let inside = open(&request, folder).map_err(|error| error.line())?;
        if inside.guid() != request.guid {
            return Err(format!(
                "GUID \"{}\" is not that of the resources, {}; modelDescription.xml and resources \
                 belong to different FMUs",
                request.guid,
                inside.guid()
            ));
        }
        let log = Log::new(request.sink, request.logging_on);
        Ok(Self { inside, run: Run::FRESH, log, texts: Vec::new() })
    }

    /// Passes on the messages of the inner implementation.
    fn pass_on_messages(&mut self) {
        for message in self.inside.messages() {
            let text = || format!("{} ({}): {}", message.instance, message.category, message.text);
            match Status::from_number(message.status) {
                Some(Status::Ok) => self.log.event(text),
                None | Some(Status::Pending) => self.log.pass_on(Status::Error, &text()),
                Some(status) => self.log.pass_on(status, &text()),
            }
        }
    }

    /// The phase after an inner failure.
    fn fail(&mut self, error: &Error) -> Trouble {
        let trouble = trouble(error);
        self.run.phase = match trouble.status {
            Status::Discard => Phase::Failed,
            Status::Fatal => Phase::Fatal,
            _ => Phase::Error,
        };
        self.run.ended |= error.code() == Code::Ended;
        trouble
    }

    /// Reads variables and passes on the values.
    fn get(
        &mut self,
        call: Call,
        basic: Basic,
        references: &[u32],
        give: impl FnOnce(&mut Self, Values) -> Option<()>,
    ) -> Status {
        self.call(call, |me| {
            spare(VALUE * references.len())?;
            let values = me.inside.get(basic, references).map_err(|error| trouble(&error))?;
            let strange = || Trouble::error("the returned values have a different type or number");
            if values.len() != references.len() {
                return Err(strange());
            }
            give(me, values).ok_or_else(strange)
        })
    }

    fn set(&mut self, call: Call, references: &[u32], values: impl FnOnce() -> Values) -> Status {
        self.call(call, |me| {
            spare(VALUE * references.len())?;
            me.inside.set(references, values()).map_err(|error| trouble(&error))
        })
    }

    fn bytes(&self, state: &State<I::Kept>) -> Result<Vec<u8>, Trouble> {
        postcard::to_stdvec(state).map(seal).map_err(Trouble::error)
    }

    fn is_own(&self, state: &State<I::Kept>) -> Result<(), Trouble> {
        match state.guid == self.inside.guid() {
            true => Ok(()),
            false => Err(Trouble::error("the state belongs to another FMU")),
        }
    }

    fn saved(&mut self) -> Result<State<I::Kept>, Trouble> {
        let kept = self.inside.save().map_err(|error| trouble(&error))?;
        Ok(State { guid: self.inside.guid().to_owned(), run: self.run, kept })
    }
}

/// An inner error as one line, and the corresponding status.
fn trouble(error: &Error) -> Trouble {
    let status = match (error.status(), error.code()) {
        (None, Code::Step | Code::Ended) => Status::Discard,
        (status, _) => match status.and_then(Status::from_number) {
            Some(status @ (Status::Discard | Status::Fatal)) => status,
            _ => Status::Error,
        },
    };
    Trouble { status, text: error.line() }
}

impl<I: Inside> Served for Around<I> {
    type State = State<I::Kept>;

    #[inline]
    fn call(&mut self, call: Call, work: impl FnOnce(&mut Self) -> Result<(), Trouble>) -> Status {
        if !(accepts(self.run.phase, call) && call.belongs_to(Interface::CoSimulation)) {
            return self.log.out_of_order(call, self.run.phase, Interface::CoSimulation);
        }
        let done = work(self);
        self.pass_on_messages();
        match done {
            Ok(()) => Status::Ok,
            Err(trouble) => self.log.failed(call, &trouble),
        }
    }

    fn poison(&mut self, call: Call, reason: &str) -> Status {
        self.run.phase = Phase::Fatal;
        self.log.panicked(call, reason)
    }

    fn set_debug_logging(&mut self, on: bool, categories: &[&str]) -> Status {
        self.call(Call::SetDebugLogging, |me| {
            me.inside.debug(on, categories).map_err(|error| trouble(&error))?;
            let ours = categories.iter().filter(|name| Category::is_known(name));
            let ours: Vec<&str> = ours.copied().collect();
            let events = on && (categories.is_empty() || !ours.is_empty());
            me.log.choose(events, &ours).map_err(Trouble::error)
        })
    }

    fn setup_experiment(
        &mut self,
        tolerance: Option<f64>,
        start_s: f64,
        stop_s: Option<f64>,
    ) -> Status {
        self.call(Call::SetupExperiment, |me| {
            check_experiment(tolerance, start_s, stop_s)?;
            (me.run.tolerance, me.run.stop_s) = (tolerance, stop_s);
            (me.run.start_s, me.run.time_s) = (start_s, start_s);
            Ok(())
        })
    }

    fn enter_initialization_mode(&mut self) -> Status {
        self.call(Call::EnterInitializationMode, |me| {
            let Run { tolerance, start_s, stop_s, .. } = me.run;
            let entered = me.inside.enter(&Experiment { tolerance, start_s, stop_s });
            entered.map_err(|error| me.fail(&error))?;
            me.run.phase = Phase::Initialization;
            Ok(())
        })
    }

    fn exit_initialization_mode(&mut self) -> Status {
        self.call(Call::ExitInitializationMode, |me| {
            let odd = me.inside.exit().map_err(|error| me.fail(&error))?;
            odd.iter().for_each(|text| me.log.pass_on(Status::Warning, text));
            me.run.phase = Phase::Step;
            me.log.event(|| format!("initialized at {} s", me.run.time_s));
            Ok(())
        })
    }

    fn terminate(&mut self) -> Status {
        self.call(Call::Terminate, |me| {
            me.inside.terminate().map_err(|error| me.fail(&error))?;
            me.run.phase = Phase::Terminated;
            Ok(())
        })
    }

    fn reset(&mut self) -> Status {
        self.call(Call::Reset, |me| {
            me.inside.reset().map_err(|error| me.fail(&error))?;
            me.run = Run::FRESH;
            Ok(())
        })
    }

    #[inline]
    fn get_fresh(&self, references: &[u32], into: &mut [f64]) -> Option<()> {
        if self.run.phase == Phase::Step { self.inside.at_hand(references, into) } else { None }
    }

    fn get_real(&mut self, references: &[u32], into: &mut [f64]) -> Status {
        self.get(Call::GetReal, Basic::Real, references, |_, values| match values {
            Values::Real(values) => put(into, values),
            _ => None,
        })
    }

    fn get_integer(&mut self, references: &[u32], into: &mut [i32]) -> Status {
        self.get(Call::GetInteger, Basic::Integer, references, |_, values| match values {
            Values::Integer(values) => put(into, values),
            _ => None,
        })
    }

    fn get_boolean(&mut self, references: &[u32], mut give: impl FnMut(usize, bool)) -> Status {
        self.get(Call::GetBoolean, Basic::Boolean, references, |_, values| match values {
            Values::Boolean(values) => {
                values.into_iter().enumerate().for_each(|(place, value)| give(place, value));
                Some(())
            }
            _ => None,
        })
    }

    fn get_string(&mut self, references: &[u32], mut give: impl FnMut(usize, &CStr)) -> Status {
        self.get(Call::GetString, Basic::String, references, |me, values| match values {
            Values::String(texts) => {
                let texts = texts.into_iter().map(|text| CString::new(text).unwrap_or_default());
                me.texts = texts.collect();
                me.texts.iter().enumerate().for_each(|(place, text)| give(place, text));
                Some(())
            }
            _ => None,
        })
    }

    fn set_real(&mut self, references: &[u32], values: &[f64]) -> Status {
        let bad = values.iter().find(|value| !(I::TAKES_ANY_REAL || value.is_finite()));
        if let Some(bad) = bad {
            return self.refuse(Call::SetReal, &format!("the value {bad} is not finite"));
        }
        self.set(Call::SetReal, references, || Values::Real(values.to_vec()))
    }

    fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Status {
        self.set(Call::SetInteger, references, || Values::Integer(values.to_vec()))
    }

    fn set_boolean(&mut self, references: &[u32], values: &[bool]) -> Status {
        self.set(Call::SetBoolean, references, || Values::Boolean(values.to_vec()))
    }

    fn set_string(&mut self, references: &[u32], values: &[Option<CString>]) -> Status {
        let text = |value: &Option<CString>| value.as_ref()?.to_str().ok().map(str::to_owned);
        match values.iter().map(text).collect::<Option<Vec<String>>>() {
            Some(texts) => self.set(Call::SetString, references, || Values::String(texts)),
            None => self.refuse(Call::SetString, "a text is NULL or not UTF-8"),
        }
    }

    fn get_state(&mut self, state: &mut Option<Box<State<I::Kept>>>) -> Status {
        self.call(Call::GetFmuState, |me| {
            *state = Some(Box::new(me.saved()?));
            Ok(())
        })
    }

    fn get_state_again(&mut self, state: &mut State<I::Kept>) -> Status {
        self.call(Call::GetFmuState, |me| {
            me.is_own(state)?;
            *state = me.saved()?;
            Ok(())
        })
    }

    fn set_state(&mut self, state: &State<I::Kept>) -> Status {
        self.call(Call::SetFmuState, |me| {
            me.is_own(state)?;
            me.inside.restore(&state.kept).map_err(|error| me.fail(&error))?;
            me.run = state.run;
            Ok(())
        })
    }

    fn serialized_size(&mut self, state: &State<I::Kept>, size: &mut usize) -> Status {
        self.call(Call::SerializedFmuStateSize, |me| {
            *size = me.bytes(state)?.len();
            Ok(())
        })
    }

    fn serialize_state(&mut self, state: &State<I::Kept>, into: &mut [u8]) -> Status {
        self.call(Call::SerializeFmuState, |me| hand_out(&me.bytes(state)?, into))
    }

    fn deserialize_state(
        &mut self,
        bytes: &[u8],
        state: &mut Option<Box<State<I::Kept>>>,
    ) -> Status {
        self.call(Call::DeSerializeFmuState, |me| {
            spare(SPREAD * bytes.len())?;
            let unread =
                |why: String| Trouble::error(format_args!("these {} bytes {why}", bytes.len()));
            let body = unseal(bytes).map_err(unread)?;
            let read: State<I::Kept> = postcard::from_bytes(body)
                .map_err(|cause| unread(format!("cannot be read as a state: {cause}")))?;
            me.is_own(&read)?;
            if !read.run.is_sound() {
                return Err(unread("are a state with an invalid time".to_owned()));
            }
            *state = Some(Box::new(read));
            Ok(())
        })
    }

    fn do_step(&mut self, t: f64, h: f64) -> Status {
        self.call(Call::DoStep, |me| {
            check_step(t, h, me.run.time_s, me.run.stop_s)?;
            me.inside.step(t, h).map_err(|error| me.fail(&error))?;
            me.run.time_s = t + h;
            Ok(())
        })
    }

    fn last_successful_time(&mut self, into: &mut f64) -> Status {
        self.call(Call::GetRealStatus, |me| {
            *into = me.run.time_s;
            Ok(())
        })
    }

    fn wants_to_end(&mut self, into: &mut bool) -> Status {
        self.call(Call::GetBooleanStatus, |me| {
            *into = me.run.ended;
            Ok(())
        })
    }

    fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        along: &[f64],
        into: &mut [f64],
    ) -> Status {
        let call = Call::GetDirectionalDerivative;
        let mut known = true;
        let status = self.call(call, |me| match me.inside.slope(unknowns, knowns, along) {
            None => {
                known = false;
                Ok(())
            }
            Some(slopes) => {
                let slopes = slopes.map_err(|error| trouble(&error))?;
                put(into, slopes).ok_or_else(|| Trouble::error("the returned values are truncated"))
            }
        });
        match known {
            true => status,
            false => self.unsupported(call, "providesDirectionalDerivative = false"),
        }
    }
}

/// Stores values, if their number is right.
fn put<T>(into: &mut [T], values: Vec<T>) -> Option<()> {
    if into.len() != values.len() {
        return None;
    }
    into.iter_mut().zip(values).for_each(|(place, value)| *place = value);
    Some(())
}
