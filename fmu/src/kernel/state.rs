//! Saved states: everything an instance needs to continue bit for bit (FMI 2.0.4, section 2.1.8).
//!
//! A state contains everything that changes during a simulation: the phase, inputs to derivatives,
//! input slopes, the model's memory with random numbers, held samples and step-size control.
//! Parameters are included, but only copied if they differ: each set of parameters has its own
//! number (its edition), so in the usual case saving and restoring are a few copies without
//! allocation.
//!
//! As bytes it is in Postcard's format within an envelope (`envelope.rs`). The state contains the
//! GUID of its component, so that other components' states are rejected, and the shape of its
//! memory (`shape.rs`), so that those of other versions are.

use std::sync::Arc;

use fmu_standard::{Call, InterfaceType, Phase, Status};
use serde::{Deserialize, Serialize};

use super::envelope::{hand_out, seal, unseal};
use super::instance::{Instance, Run, new_edition};
use super::memory::{SPREAD, spare};
use super::model::Memory;
use super::signal::Slopes;
use super::status::Trouble;
use super::values::{Discrete, Explicit, Values, all_finite};

/// Memory that does not depend on what is saved, such as names in errors (bytes).
const FEW: usize = 16 << 10;

/// A saved state of an instance.
pub struct State {
    guid: Arc<str>,
    interface: InterfaceType,
    run: Run,
    edition: u64,
    /// Of the Reals only the parameters.
    parameters: Values,
    explicit: Explicit,
    /// Inputs, outputs, states, derivatives, time.
    ports: Box<[f64]>,
    discrete: Discrete,
    slopes: Slopes,
    memory: Option<Memory>,
}

/// A state as it is serialized.
#[derive(Serialize, Deserialize)]
struct Packed<'a> {
    guid: &'a str,
    interface: InterfaceType,
    run: Run,
    parameters: std::borrow::Cow<'a, Values>,
    explicit: std::borrow::Cow<'a, Explicit>,
    ports: std::borrow::Cow<'a, [f64]>,
    discrete: std::borrow::Cow<'a, Discrete>,
    slopes: Slopes,
    memory: Vec<u8>,
}

impl Instance {
    /// `GetFMUstate` into a new state.
    pub fn get_state(&mut self, state: &mut Option<Box<State>>) -> Status {
        self.call(Call::GetFmuState, |me| {
            spare(me.size())?;
            *state = Some(Box::new(me.saved()));
            Ok(())
        })
    }

    /// `GetFMUstate` into an existing state.
    pub fn get_state_again(&mut self, state: &mut State) -> Status {
        self.call(Call::GetFmuState, |me| {
            if !me.is_of(&state.guid) {
                return Err(Trouble::error("the state to overwrite is another component's"));
            }
            me.save_into(state);
            Ok(())
        })
    }

    /// Whether this belongs to the component with that GUID, which is usually the same text in
    /// memory.
    #[inline]
    fn is_of(&self, guid: &Arc<str>) -> bool {
        Arc::ptr_eq(&self.guid, guid) || self.guid == *guid
    }

    fn ports(&self) -> &[f64] {
        let first = self.table.layout().inputs.start;
        self.values.reals.get(first..).unwrap_or_default()
    }

    /// Maximum memory for a saved state, or for its bytes.
    fn size(&self) -> usize {
        let strings = self.values.strings.iter().map(|text| text.count_bytes());
        let values = size_of_val(&*self.values.reals) + strings.sum::<usize>();
        FEW + self.model.size() + SPREAD * values
    }

    fn saved(&self) -> State {
        let mut state = State {
            guid: Arc::clone(&self.guid),
            interface: self.interface,
            run: self.run,
            edition: 0,
            parameters: Values::default(),
            explicit: Explicit::default(),
            ports: self.ports().into(),
            discrete: Discrete::of(&self.values, self.table.layout().parameters),
            slopes: Slopes::held(self.table.layout().inputs.len()),
            memory: None,
        };
        self.save_into(&mut state);
        state
    }

    fn save_into(&self, state: &mut State) {
        state.interface = self.interface;
        state.run = self.run;
        if state.edition != self.edition {
            let first = self.table.layout().inputs.start;
            state.edition = self.edition;
            state.parameters = Values {
                reals: self.values.reals.get(..first).unwrap_or_default().into(),
                ..self.values.clone()
            };
            state.explicit = self.explicit.clone();
        }
        state.ports.copy_from_slice(self.ports());
        state.discrete.copy_from(&self.values, self.table.layout().parameters);
        state.slopes.copy_from(&self.slopes);
        self.model.save(&mut state.memory);
    }

    /// `SetFMUstate`: continues from a state of this or another instance.
    pub fn set_state(&mut self, state: &State) -> Status {
        self.call(Call::SetFmuState, |me| {
            if !me.is_of(&state.guid) || state.interface != me.interface {
                return Err(Trouble::error(format_args!(
                    "the state is of a component with GUID {} for {:?}, this is {} for {:?}",
                    state.guid, state.interface, me.guid, me.interface
                )));
            }
            me.run = state.run;
            if state.edition != me.edition {
                me.take_parameters(state)?;
            }
            let first = me.table.layout().inputs.start;
            if let Some(ports) = me.values.reals.get_mut(first..) {
                ports.copy_from_slice(&state.ports);
            }
            state.discrete.copy_to(&mut me.values, me.table.layout().parameters);
            me.slopes.copy_from(&state.slopes);
            match &state.memory {
                Some(memory) if me.model.restore(memory) => Ok(()),
                _ => Err(Trouble::error("the state is another component's")),
            }
        })
    }

    /// Copies another set of parameters and derives the constants from them again.
    #[cold]
    fn take_parameters(&mut self, state: &State) -> Result<(), Trouble> {
        let reals = self.values.reals.iter_mut().zip(&state.parameters.reals);
        reals.for_each(|(own, saved)| *own = *saved);
        self.values.integers.clone_from(&state.parameters.integers);
        self.values.booleans.clone_from(&state.parameters.booleans);
        self.values.strings.clone_from(&state.parameters.strings);
        self.explicit.clone_from(&state.explicit);
        if !state.run.stale.component {
            self.configure(state.run.tolerance).inspect_err(|_| {
                self.run.phase = Phase::Error;
                self.run.stale.component = true;
                self.edition = new_edition();
            })?;
        }
        self.edition = state.edition;
        Ok(())
    }

    /// `SerializedFMUstateSize`
    pub fn serialized_size(&mut self, state: &State, size: &mut usize) -> Status {
        self.call(Call::SerializedFmuStateSize, |me| {
            *size = me.bytes(state)?.len();
            Ok(())
        })
    }

    /// `SerializeFMUstate`
    pub fn serialize_state(&mut self, state: &State, into: &mut [u8]) -> Status {
        self.call(Call::SerializeFmuState, |me| hand_out(&me.bytes(state)?, into))
    }

    fn bytes(&self, state: &State) -> Result<Vec<u8>, Trouble> {
        use std::borrow::Cow::Borrowed;
        if !self.is_of(&state.guid) {
            return Err(Trouble::error("the state is another component's"));
        }
        spare(self.size())?;
        let memory = state.memory.as_ref().map_or(Ok(Vec::new()), |memory| self.model.pack(memory));
        let mut slopes = Slopes::held(self.table.layout().inputs.len());
        slopes.copy_from(&state.slopes);
        let packed = Packed {
            guid: &state.guid,
            interface: state.interface,
            run: state.run,
            parameters: Borrowed(&state.parameters),
            explicit: Borrowed(&state.explicit),
            ports: Borrowed(&state.ports),
            discrete: Borrowed(&state.discrete),
            slopes,
            memory: memory.map_err(Trouble::error)?,
        };
        Ok(seal(postcard::to_stdvec(&packed).map_err(Trouble::error)?))
    }

    /// `DeSerializeFMUstate`
    pub fn deserialize_state(&mut self, bytes: &[u8], state: &mut Option<Box<State>>) -> Status {
        self.call(Call::DeSerializeFmuState, |me| {
            // Its own, for comparison; and the one that is read.
            spare(2 * me.size() + SPREAD * bytes.len())?;
            let read = me.read_state(bytes).map_err(|reason| {
                Trouble::error(format_args!("these {} bytes {reason}", bytes.len()))
            })?;
            *state = Some(Box::new(read));
            Ok(())
        })
    }

    fn read_state(&self, bytes: &[u8]) -> Result<State, String> {
        let packed: Packed<'_> = postcard::from_bytes(unseal(bytes)?)
            .map_err(|cause| format!("cannot be read as a state: {cause}"))?;
        if packed.guid != &*self.guid {
            return Err(format!(
                "are a state of the component with GUID {}, not of this one, {}",
                packed.guid, self.guid
            ));
        }
        if packed.interface != self.interface {
            return Err(format!("are a state for {:?}", packed.interface));
        }
        let own = self.saved();
        let (theirs, ours) = (&packed.parameters, &own.parameters);
        let as_many = theirs.reals.len() == ours.reals.len()
            && theirs.integers.len() == ours.integers.len()
            && theirs.booleans.len() == ours.booleans.len()
            && theirs.strings.len() == ours.strings.len()
            && packed.ports.len() == own.ports.len()
            && packed.discrete.is_like(&own.discrete)
            && packed.explicit.is_like(&own.explicit)
            && packed.slopes.is_like(&own.slopes);
        if !as_many {
            return Err("are a state with other variables".to_owned());
        }
        let sound = self.table.takes_any_input() || all_finite(&packed.ports);
        if !(sound && all_finite(&theirs.reals) && packed.run.is_sound()) {
            return Err("are a state with values that are not finite".to_owned());
        }
        let memory = self
            .model
            .unpack(&packed.memory)
            .map_err(|cause| format!("hold no memory of this component: {cause}"))?;
        Ok(State {
            run: packed.run,
            edition: new_edition(),
            parameters: packed.parameters.into_owned(),
            explicit: packed.explicit.into_owned(),
            ports: packed.ports.into_owned().into(),
            discrete: packed.discrete.into_owned(),
            slopes: packed.slopes,
            memory: Some(memory),
            ..own
        })
    }
}
