//! One instance of a component: its life from instantiation to termination, by the rules of FMI 2.0
//! and without its C.
//!
//! Every function checks that it is legal now and does its work; if it fails, it logs exactly one
//! line `function: what, why, what to do` and returns a status. Values are computed when they are
//! read, if something they depend on has changed since.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use fmu_standard::{Call, InterfaceType, Phase, Status};
use serde::{Deserialize, Serialize};

use crate::author::Time;

use super::call::accepts;
use super::clock::{check_experiment, is_instant};
use super::log::{Log, Sink};
use super::memory::spare;
use super::model::Model;
use super::signal::Slopes;
use super::status::Trouble;
use super::table::Table;
use super::values::{Explicit, Values, all_finite};

/// What must be computed again before it can be read.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Stale {
    /// The component: a parameter changed.
    pub(super) component: bool,
    /// The initial states: a parameter, an input or the start time changed before the start.
    pub(super) initial: bool,
    pub(super) outputs: bool,
    pub(super) derivatives: bool,
}

impl Stale {
    const ALL: Self = Self { component: true, initial: true, outputs: true, derivatives: true };

    #[inline]
    pub(super) const fn any(self) -> bool {
        self.component | self.initial | self.outputs | self.derivatives
    }
}

/// The present point of a simulation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Run {
    pub(super) phase: Phase,
    pub(super) stale: Stale,
    pub(super) time_s: f64,
    pub(super) stop_s: Option<f64>,
    pub(super) tolerance: Option<f64>,
}

impl Run {
    const FRESH: Self = Self {
        phase: Phase::Instantiated,
        stale: Stale::ALL,
        time_s: 0.0,
        stop_s: None,
        tolerance: None,
    };

    /// Whether its values are numbers.
    pub(super) fn is_sound(&self) -> bool {
        is_instant(self.time_s)
            && self.stop_s.is_none_or(|stop| !stop.is_nan())
            && self.tolerance.is_none_or(|tolerance| (0.0..=1.0).contains(&tolerance))
            && self.phase != Phase::Fatal
    }
}

/// Maximum allocation of a component for its constants and its memory (bytes), excluding files.
const CONFIGURATION: usize = 1 << 20;

/// Numbers the sets of parameters of all instances, so that equal numbers mean equal parameters.
static EDITIONS: AtomicU64 = AtomicU64::new(1);

/// One instance.
pub struct Instance {
    pub(super) table: Arc<Table>,
    pub(super) guid: Arc<str>,
    pub(super) model: Box<dyn Model>,
    pub(super) interface: InterfaceType,
    pub(super) run: Run,
    pub(super) values: Values,
    pub(super) explicit: Explicit,
    /// Changes with every change of a parameter.
    pub(super) edition: u64,
    pub(super) slopes: Slopes,
    /// Changes of Reals along a direction, for directional derivatives; allocated when first
    /// needed.
    pub(super) changes: Box<[f64]>,
    pub(super) log: Log,
}

impl Instance {
    /// A new instance of a model over its table; `guid` is that of its component.
    #[must_use]
    pub fn new(
        table: Arc<Table>,
        guid: Arc<str>,
        model: Box<dyn Model>,
        interface: InterfaceType,
        sink: Box<dyn Sink>,
        logging_on: bool,
    ) -> Self {
        let mut instance = Self {
            guid,
            model,
            interface,
            run: Run::FRESH,
            values: table.start_values(),
            explicit: Explicit::none(table.layout().parameters),
            edition: new_edition(),
            slopes: Slopes::held(table.layout().inputs.len()),
            changes: Box::default(),
            log: Log::new(sink, logging_on),
            table,
        };
        // Dependent values are readable from here on; if the defaults do not suffice for that (a
        // required parameter is empty), the start values remain until initialization.
        let _ = instance.refresh();
        instance
    }

    /// The variables.
    #[must_use]
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// The state of the state machine.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.run.phase
    }

    /// `SetDebugLogging`
    pub fn set_debug_logging(&mut self, on: bool, categories: &[&str]) -> Status {
        self.call(Call::SetDebugLogging, |me| me.log.choose(on, categories).map_err(Trouble::error))
    }

    /// `SetupExperiment`; the tolerance is that of the adaptive integrator.
    pub fn setup_experiment(
        &mut self,
        tolerance: Option<f64>,
        start_s: f64,
        stop_s: Option<f64>,
    ) -> Status {
        self.call(Call::SetupExperiment, |me| {
            check_experiment(tolerance, start_s, stop_s)?;
            me.set_clock(start_s);
            me.run.stop_s = stop_s;
            if me.run.tolerance != tolerance {
                me.run.tolerance = tolerance;
                me.run.stale.component = true;
                me.edition = new_edition();
            }
            me.run.stale.initial = true;
            Ok(())
        })
    }

    /// `EnterInitializationMode`
    pub fn enter_initialization_mode(&mut self) -> Status {
        self.call(Call::EnterInitializationMode, |me| {
            me.run.phase = Phase::Initialization;
            Ok(())
        })
    }

    /// `ExitInitializationMode`
    pub fn exit_initialization_mode(&mut self) -> Status {
        self.call(Call::ExitInitializationMode, |me| {
            if let Err(trouble) = me.refresh() {
                me.run.phase = Phase::Error;
                return Err(Trouble { status: Status::Error, ..trouble });
            }
            me.run.phase = match me.interface {
                InterfaceType::ModelExchange => Phase::Event,
                InterfaceType::CoSimulation => Phase::Step,
            };
            me.log.event(|| format!("initialized at {} s", me.run.time_s));
            me.log_notice();
            Ok(())
        })
    }

    /// `Terminate`
    pub fn terminate(&mut self) -> Status {
        self.call(Call::Terminate, |me| {
            me.run.phase = Phase::Terminated;
            Ok(())
        })
    }

    /// `Reset`: as just instantiated.
    pub fn reset(&mut self) -> Status {
        self.call(Call::Reset, |me| {
            me.run = Run::FRESH;
            me.values = me.table.start_values();
            me.explicit = Explicit::none(me.table.layout().parameters);
            me.edition = new_edition();
            me.slopes = Slopes::held(me.table.layout().inputs.len());
            me.set_clock(0.0);
            let _ = me.refresh();
            Ok(())
        })
    }

    /// Marks the instance as corrupt after a panic in `call`.
    pub fn poison(&mut self, call: Call, reason: &str) -> Status {
        self.run.phase = Phase::Fatal;
        self.log.panicked(call, reason)
    }

    /// The frame of every function: legality check, work, one line on failure.
    #[inline]
    pub(super) fn call(
        &mut self,
        call: Call,
        work: impl FnOnce(&mut Self) -> Result<(), Trouble>,
    ) -> Status {
        if !(accepts(self.run.phase, call) && call.belongs_to(self.interface)) {
            return self.log.out_of_order(call, self.run.phase, self.interface);
        }
        match work(self) {
            Ok(()) => Status::Ok,
            Err(trouble) => self.log.failed(call, &trouble),
        }
    }

    pub(super) fn set_clock(&mut self, time_s: f64) {
        self.run.time_s = time_s;
        if let Some(time) = self.values.reals.last_mut() {
            *time = time_s;
        }
    }

    /// Forwards the component's messages.
    #[inline]
    pub(super) fn log_notice(&mut self) {
        if let Some(text) = self.model.notice() {
            self.log.pass_on(Status::Warning, &format!("at {} s: {text}", self.run.time_s));
        }
    }

    /// Derives the component's constants from its parameters.
    pub(super) fn configure(&mut self, tolerance: Option<f64>) -> Result<(), Trouble> {
        spare(CONFIGURATION)?;
        self.model.configure(&mut self.values, &self.explicit, tolerance).map_err(Trouble::error)
    }

    /// Computes stale values, except derivatives, and checks that they are finite.
    #[cold]
    pub(super) fn refresh(&mut self) -> Result<(), Trouble> {
        if self.run.stale.component {
            self.configure(self.run.tolerance)?;
            self.edition = new_edition();
            self.run.stale.component = false;
            self.run.stale.initial |=
                matches!(self.run.phase, Phase::Instantiated | Phase::Initialization);
        }
        if self.run.stale.initial {
            let start = Time::from_seconds(self.run.time_s);
            self.model.initialize(start, &mut self.values).map_err(Trouble::error)?;
            self.run.stale = Stale { component: false, initial: false, ..Stale::ALL };
        }
        if self.run.stale.outputs {
            self.model.outputs(self.run.time_s, &mut self.values);
            self.run.stale.outputs = false;
            self.check_outputs()?;
        }
        Ok(())
    }

    /// Computes the derivatives if they are stale, and checks that they are finite.
    pub(super) fn refresh_derivatives(&mut self) -> Result<(), Trouble> {
        if self.run.stale.derivatives {
            self.model.derivatives(self.run.time_s, &mut self.values);
            self.run.stale.derivatives = false;
            self.check_finite(self.table.layout().derivatives.clone())?;
        }
        Ok(())
    }

    /// Checks that outputs and states, which are adjacent, are finite.
    #[inline]
    pub(super) fn check_outputs(&self) -> Result<(), Trouble> {
        let layout = self.table.layout();
        self.check_finite(layout.outputs.start..layout.states.end)
    }

    #[inline]
    fn check_finite(&self, place: std::ops::Range<usize>) -> Result<(), Trouble> {
        match self.values.reals.get(place.clone()) {
            Some(values) if !all_finite(values) => Err(self.not_finite(place)),
            _ => Ok(()),
        }
    }

    #[cold]
    pub(super) fn not_finite(&self, place: std::ops::Range<usize>) -> Trouble {
        let bad = |variable: &&super::table::Variable| {
            let reference = variable.reference as usize;
            matches!(variable.start, crate::author::Start::Real(_))
                && place.contains(&reference)
                && self.values.reals.get(reference).is_some_and(|value| !value.is_finite())
        };
        let name = self.table.variables().iter().find(bad).map_or("?", |v| v.name.as_str());
        self.doubtful(format_args!(
            "{name} is not finite at t = {} s; look at the inputs and start values that lead there",
            self.run.time_s
        ))
    }

    /// A value that no computation can continue with: a solver may try a shorter step, a master
    /// cannot.
    pub(super) fn doubtful(&self, text: impl std::fmt::Display) -> Trouble {
        match self.interface {
            InterfaceType::ModelExchange => Trouble::discard(text),
            InterfaceType::CoSimulation => Trouble::error(text),
        }
    }
}

/// A number that no other set of parameters has had.
pub(super) fn new_edition() -> u64 {
    EDITIONS.fetch_add(1, Ordering::Relaxed)
}
