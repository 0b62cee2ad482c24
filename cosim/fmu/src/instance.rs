//! One instance of an exported system: the states of FMI around a hosted system.

use std::ffi::{CStr, CString};

use cosim::fmi::Value;
use cosim::hosted::{Basic, Hosted, Kept};
use cosim::{Code, Error, Time};
use fmu_kit::kernel::{
    Call, Interface, Log, Phase, Request, Served, Status, Trouble, check_experiment, check_step,
    seal, unseal,
};
use serde::{Deserialize, Serialize};

/// `fmi2Discard` and `fmi2Fatal` as the FMUs inside return them.
const DISCARD: i32 = 2;
const FATAL: i32 = 4;

/// An instance.
pub struct System {
    hosted: Alone,
    run: Run,
    log: Log,
    /// Texts that the importer was given and may still read.
    texts: Vec<CString>,
}

/// A hosted system, which nobody else refers to.
struct Alone(Hosted);

// SAFETY: what is shared inside (patches by `Rc`, handles of FMUs) is shared among parts of this
// one value, which go from thread to thread together; FMI has its importers call an instance from
// one thread at a time, and so do we with the FMUs inside.
#[allow(unsafe_code)]
unsafe impl Send for Alone {}

/// Where a simulation is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Run {
    phase: Phase,
    start_s: f64,
    stop_s: Option<f64>,
    time_s: f64,
    /// A component ended the run.
    ended: bool,
}

impl Run {
    const FRESH: Self =
        Self { phase: Phase::Instantiated, start_s: 0.0, stop_s: None, time_s: 0.0, ended: false };
}

/// A saved state.
#[derive(Clone, Serialize, Deserialize)]
pub struct State {
    guid: String,
    run: Run,
    kept: Kept,
}

impl System {
    pub(crate) fn new(request: Request<'_>) -> Result<Self, String> {
        if request.interface != Interface::CoSimulation {
            return Err("the FMU offers co-simulation only, not model exchange".to_owned());
        }
        let folder = request.resources.folder().ok_or(
            "fmuResourceLocation is missing or names no folder; the system lies in the FMU's \
             resources",
        )?;
        let hosted = Hosted::open(folder, request.logging_on).map_err(|error| line(&error))?;
        if hosted.guid() != request.guid {
            return Err(format!(
                "GUID \"{}\" is not that of the resources, {}; modelDescription.xml and resources \
                 belong to different FMUs",
                request.guid,
                hosted.guid()
            ));
        }
        let log = Log::new(request.sink, request.logging_on);
        Ok(Self { hosted: Alone(hosted), run: Run::FRESH, log, texts: Vec::new() })
    }

    /// Hands on what the FMUs inside said.
    fn tell(&self) {
        for message in self.hosted.0.messages() {
            let text = || format!("{} ({}): {}", message.instance, message.category, message.text);
            match message.status {
                0 => self.log.event(text),
                1 => self.log.pass_on(Status::Warning, &text()),
                2 => self.log.pass_on(Status::Discard, &text()),
                FATAL => self.log.pass_on(Status::Fatal, &text()),
                _ => self.log.pass_on(Status::Error, &text()),
            }
        }
    }

    /// The phase after something inside failed.
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

    fn get<T>(
        &mut self,
        (call, basic): (Call, Basic),
        references: &[u32],
        mut give: impl FnMut(usize, T),
        of: impl Fn(f64) -> T,
    ) -> Status {
        self.call(call, |me| {
            for (place, reference) in references.iter().enumerate() {
                match me.hosted.0.number(basic, *reference) {
                    Ok(value) => give(place, of(value)),
                    Err(error) => return Err(trouble(&error)),
                }
            }
            Ok(())
        })
    }

    /// Sets all values or none.
    fn set(
        &mut self,
        (call, basic): (Call, Basic),
        references: &[u32],
        values: impl Iterator<Item = Value>,
    ) -> Status {
        self.call(call, |me| {
            let hosted = &mut me.hosted.0;
            for reference in references {
                hosted.settable(basic, *reference).map_err(|error| trouble(&error))?;
            }
            for (reference, value) in references.iter().zip(values) {
                hosted.set(basic, *reference, value).map_err(|error| trouble(&error))?;
            }
            Ok(())
        })
    }

    fn time(seconds: f64, name: &str) -> Result<Time, Trouble> {
        Time::from_seconds(seconds, name).map_err(|error| trouble(&error))
    }

    fn bytes(&self, state: &State) -> Result<Vec<u8>, Trouble> {
        postcard::to_stdvec(state).map(seal).map_err(Trouble::error)
    }

    fn is_own(&self, state: &State) -> Result<(), Trouble> {
        match state.guid == self.hosted.0.guid() {
            true => Ok(()),
            false => Err(Trouble::error("the state is another FMU's")),
        }
    }

    fn saved(&mut self) -> Result<State, Trouble> {
        let kept = self.hosted.0.save().map_err(|error| trouble(&error))?;
        Ok(State { guid: self.hosted.0.guid().to_owned(), run: self.run, kept })
    }
}

/// What happened inside as one line and the status that it means.
fn trouble(error: &Error) -> Trouble {
    let status = match (error.status(), error.code()) {
        (Some(DISCARD), _) | (None, Code::Step | Code::Ended) => Status::Discard,
        (Some(FATAL), _) => Status::Fatal,
        _ => Status::Error,
    };
    Trouble { status, text: line(error) }
}

/// An error in one line: what, where, why, what to do.
fn line(error: &Error) -> String {
    let one = |error: &Error| {
        let mut text = error.what().to_owned();
        if let Some((file, place)) = error.place() {
            let place = place.map_or(String::new(), |line| format!(":{line}"));
            text.push_str(&format!(" [{}{place}]", file.display()));
        }
        let parts = [(": ", error.reason()), ("; ", error.remedy())];
        for (before, part) in parts {
            text.extend(part.map(|part| format!("{before}{part}")));
        }
        text
    };
    let all: Vec<String> = error.problems().map(one).collect();
    all.join("; ")
}

impl Served for System {
    type State = State;

    #[inline]
    fn call(&mut self, call: Call, work: impl FnOnce(&mut Self) -> Result<(), Trouble>) -> Status {
        if !(self.run.phase.allows(call) && call.belongs_to(Interface::CoSimulation)) {
            return self.log.out_of_order(call, self.run.phase, Interface::CoSimulation);
        }
        let done = work(self);
        self.tell();
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
            me.log.choose(on, categories).map_err(Trouble::error)?;
            me.hosted.0.debug(on).map_err(|error| trouble(&error))
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
            (me.run.start_s, me.run.stop_s, me.run.time_s) = (start_s, stop_s, start_s);
            Ok(())
        })
    }

    fn enter_initialization_mode(&mut self) -> Status {
        self.call(Call::EnterInitializationMode, |me| {
            let start = Self::time(me.run.start_s, "the start time")?;
            let stop = me.run.stop_s.map(|stop| Self::time(stop, "the stop time")).transpose()?;
            let entered = me.hosted.0.enter(start, stop.unwrap_or(Time::NEVER));
            entered.map_err(|error| me.fail(&error))?;
            me.run.phase = Phase::Initialization;
            Ok(())
        })
    }

    fn exit_initialization_mode(&mut self) -> Status {
        self.call(Call::ExitInitializationMode, |me| {
            let odd = me.hosted.0.exit().map_err(|error| me.fail(&error))?;
            odd.iter().for_each(|text| me.log.pass_on(Status::Warning, text));
            me.run.phase = Phase::Step;
            me.log.event(|| format!("initialized at {} s", me.run.time_s));
            Ok(())
        })
    }

    fn terminate(&mut self) -> Status {
        self.call(Call::Terminate, |me| {
            me.run.phase = Phase::Terminated;
            Ok(())
        })
    }

    fn reset(&mut self) -> Status {
        self.call(Call::Reset, |me| {
            me.hosted.0.reset();
            me.run = Run::FRESH;
            Ok(())
        })
    }

    #[inline]
    fn get_fresh(&self, references: &[u32], into: &mut [f64]) -> Option<()> {
        if self.run.phase == Phase::Step { self.hosted.0.at_hand(references, into) } else { None }
    }

    fn get_real(&mut self, references: &[u32], into: &mut [f64]) -> Status {
        self.get((Call::GetReal, Basic::Real), references, put(into), |value| value)
    }

    fn get_integer(&mut self, references: &[u32], into: &mut [i32]) -> Status {
        self.get((Call::GetInteger, Basic::Integer), references, put(into), |value| value as i32)
    }

    fn get_boolean(&mut self, references: &[u32], give: impl FnMut(usize, bool)) -> Status {
        self.get((Call::GetBoolean, Basic::Boolean), references, give, |value| value != 0.0)
    }

    fn get_string(&mut self, references: &[u32], mut give: impl FnMut(usize, &CStr)) -> Status {
        self.call(Call::GetString, |me| {
            me.texts.clear();
            for reference in references {
                let text = me.hosted.0.text(*reference).map_err(|error| trouble(&error))?;
                me.texts.push(CString::new(text).unwrap_or_default());
            }
            me.texts.iter().enumerate().for_each(|(place, text)| give(place, text));
            Ok(())
        })
    }

    fn set_real(&mut self, references: &[u32], values: &[f64]) -> Status {
        if let Some(bad) = values.iter().find(|value| !value.is_finite()) {
            return self.refuse(Call::SetReal, &format!("the value {bad} is not finite"));
        }
        let values = values.iter().copied().map(Value::Real);
        self.set((Call::SetReal, Basic::Real), references, values)
    }

    fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Status {
        let values = values.iter().copied().map(Value::Integer);
        self.set((Call::SetInteger, Basic::Integer), references, values)
    }

    fn set_boolean(&mut self, references: &[u32], values: &[bool]) -> Status {
        let values = values.iter().copied().map(Value::Boolean);
        self.set((Call::SetBoolean, Basic::Boolean), references, values)
    }

    fn set_string(&mut self, references: &[u32], values: &[Option<CString>]) -> Status {
        let text = |value: &Option<CString>| value.as_ref()?.to_str().ok().map(str::to_owned);
        let Some(texts) = values.iter().map(text).collect::<Option<Vec<String>>>() else {
            return self.refuse(Call::SetString, "a text is NULL or not UTF-8");
        };
        let values = texts.into_iter().map(Value::String);
        self.set((Call::SetString, Basic::String), references, values)
    }

    fn get_state(&mut self, state: &mut Option<Box<State>>) -> Status {
        self.call(Call::GetFmuState, |me| {
            *state = Some(Box::new(me.saved()?));
            Ok(())
        })
    }

    fn get_state_again(&mut self, state: &mut State) -> Status {
        self.call(Call::GetFmuState, |me| {
            me.is_own(state)?;
            *state = me.saved()?;
            Ok(())
        })
    }

    fn set_state(&mut self, state: &State) -> Status {
        self.call(Call::SetFmuState, |me| {
            me.is_own(state)?;
            me.hosted.0.restore(&state.kept).map_err(|error| me.fail(&error))?;
            me.run = state.run;
            Ok(())
        })
    }

    fn serialized_size(&mut self, state: &State, size: &mut usize) -> Status {
        self.call(Call::SerializedFmuStateSize, |me| {
            *size = me.bytes(state)?.len();
            Ok(())
        })
    }

    fn serialize_state(&mut self, state: &State, into: &mut [u8]) -> Status {
        self.call(Call::SerializeFmuState, |me| {
            let bytes = me.bytes(state)?;
            if bytes.len() != into.len() {
                return Err(Trouble::error(format_args!(
                    "size = {}, but fmi2SerializedFMUstateSize said {}",
                    into.len(),
                    bytes.len()
                )));
            }
            into.copy_from_slice(&bytes);
            Ok(())
        })
    }

    fn deserialize_state(&mut self, bytes: &[u8], state: &mut Option<Box<State>>) -> Status {
        self.call(Call::DeSerializeFmuState, |me| {
            let unread =
                |why: String| Trouble::error(format_args!("these {} bytes {why}", bytes.len()));
            let body = unseal(bytes).map_err(unread)?;
            let read: State = postcard::from_bytes(body)
                .map_err(|cause| unread(format!("cannot be read as a state: {cause}")))?;
            me.is_own(&read)?;
            *state = Some(Box::new(read));
            Ok(())
        })
    }

    fn do_step(&mut self, t: f64, h: f64) -> Status {
        self.call(Call::DoStep, |me| {
            check_step(t, h, me.run.time_s, me.run.stop_s)?;
            let end = Self::time(t + h, "the end of the step")?;
            me.hosted.0.advance(end).map_err(|error| me.fail(&error))?;
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
}

/// Puts values into their places.
fn put<T>(into: &mut [T]) -> impl FnMut(usize, T) + '_ {
    |place, value| {
        if let Some(place) = into.get_mut(place) {
            *place = value;
        }
    }
}
