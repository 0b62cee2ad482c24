//! Instances of all components, used through their C interface as an importer uses them.
#![allow(unsafe_code, reason = "calls of the C interface as an importer makes them")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each is a call of the C interface with arrays of the lengths that are passed"
)]

use anyhow::{Context, Result, bail, ensure};
use fmu_kit::Start;
use fmu_kit::abi::types::*;
use fmu_kit::kernel::{Entry, Group, Status};
use rexrov_fmu::{REGISTRY, fmi2};
use std::{cell::Cell, ffi::CString, ptr};

/// An instance after its initialization.
pub(super) struct Component {
    pub(super) entry: &'static Entry,
    handle: fmi2Component,
    state: fmi2FMUstate,
    time_s: Cell<f64>,
    /// Whether every call was successful.
    fine: Cell<bool>,
}

impl Component {
    pub(super) fn new(name: &str, interface: fmi2Type) -> Result<Self> {
        let entry = REGISTRY.named(name).with_context(|| format!("there is no {name}"))?;
        let guid = CString::new(entry.guid())?;
        let functions = fmi2CallbackFunctions {
            logger: None,
            allocateMemory: None,
            freeMemory: None,
            stepFinished: None,
            componentEnvironment: ptr::null_mut(),
        };
        let (f, none) = (&raw const functions, ptr::null());
        let handle = unsafe {
            fmi2::fmi2Instantiate(c"bench".as_ptr(), interface, guid.as_ptr(), none, f, 0, 0)
        };
        ensure!(!handle.is_null(), "{name} cannot be instantiated");
        let (time_s, fine) = (Cell::new(0.0), Cell::new(true));
        let component = Self { entry, handle, state: ptr::null_mut(), time_s, fine };
        component.note(unsafe { fmi2::fmi2SetupExperiment(handle, 0, 0.0, 0.0, 0, 0.0) });
        component.note(unsafe { fmi2::fmi2EnterInitializationMode(handle) });
        component.note(unsafe { fmi2::fmi2ExitInitializationMode(handle) });
        Ok(component)
    }

    /// For co-simulation.
    pub(super) fn stepping(name: &str) -> Result<Self> {
        Self::new(name, 1)
    }

    /// For model exchange, in continuous-time mode.
    pub(super) fn continuous(name: &str) -> Result<Self> {
        let component = Self::new(name, 0)?;
        component.note(unsafe { fmi2::fmi2EnterContinuousTimeMode(component.handle) });
        Ok(component)
    }

    #[inline]
    fn note(&self, status: Status) {
        self.fine.set(self.fine.get() & (status == Status::Ok));
    }

    /// Fails if a call failed.
    pub(super) fn check(&self) -> Result<()> {
        ensure!(self.fine.get(), "a call of {} was not successful", self.entry.info().name);
        Ok(())
    }

    /// Value references of a group.
    pub(super) fn group(&self, group: Group) -> Vec<u32> {
        self.entry.table().group(group).map(|(_, variable)| variable.reference).collect()
    }

    /// Value reference of a variable.
    pub(super) fn reference(&self, name: &str) -> Result<u32> {
        let variable = self.entry.table().named(name);
        Ok(variable.with_context(|| format!("there is no {name}"))?.reference)
    }

    /// Time between two samples (s), 10 ms for the vehicle.
    pub(super) fn period_s(&self) -> f64 {
        match self.entry.table().named("rate_hz").map(|rate| &rate.start) {
            Some(Start::Real(rate_hz)) => 1.0 / rate_hz,
            _ => 0.01,
        }
    }

    /// Longest step of the integrator (s), unless it is set.
    pub(super) fn integrator_step_s(&self) -> Result<f64> {
        match self.entry.table().named("integrator.step").map(|step| &step.start) {
            Some(Start::Real(step_s)) => Ok(*step_s),
            _ => bail!("{} does not integrate", self.entry.info().name),
        }
    }

    #[inline]
    pub(super) fn set(&self, references: &[u32], values: &[f64]) {
        let (vr, n) = (references.as_ptr(), references.len().min(values.len()));
        self.note(unsafe { fmi2::fmi2SetReal(self.handle, vr, n, values.as_ptr()) });
    }

    #[inline]
    pub(super) fn get(&self, references: &[u32], values: &mut [f64]) {
        let (vr, n) = (references.as_ptr(), references.len().min(values.len()));
        self.note(unsafe { fmi2::fmi2GetReal(self.handle, vr, n, values.as_mut_ptr()) });
    }

    #[inline]
    pub(super) fn step(&self, h: f64) {
        let t = self.time_s.get();
        self.note(unsafe { fmi2::fmi2DoStep(self.handle, t, h, 1) });
        self.time_s.set(t + h);
    }

    #[inline]
    pub(super) fn save(&mut self) {
        let status = unsafe { fmi2::fmi2GetFMUstate(self.handle, &raw mut self.state) };
        self.note(status);
    }

    #[inline]
    pub(super) fn restore(&self) {
        self.note(unsafe { fmi2::fmi2SetFMUstate(self.handle, self.state) });
    }

    /// One column of the Jacobian.
    #[inline]
    pub(super) fn column(&self, unknowns: &[u32], known: u32, column: &mut [f64]) {
        let (z, n) = (unknowns.as_ptr(), unknowns.len().min(column.len()));
        let (known, one, into) = (&raw const known, &1.0, column.as_mut_ptr());
        self.note(unsafe {
            fmi2::fmi2GetDirectionalDerivative(self.handle, z, n, known, 1, one, into)
        });
    }

    #[inline]
    pub(super) fn continuous_states(&self, x: &mut [f64]) {
        self.note(unsafe { fmi2::fmi2GetContinuousStates(self.handle, x.as_mut_ptr(), x.len()) });
    }

    /// The right-hand side at some states.
    #[inline]
    pub(super) fn derivatives(&self, x: &[f64], into: &mut [f64]) {
        let (h, n) = (self.handle, x.len().min(into.len()));
        self.note(unsafe { fmi2::fmi2SetContinuousStates(h, x.as_ptr(), n) });
        self.note(unsafe { fmi2::fmi2GetDerivatives(h, into.as_mut_ptr(), n) });
    }
}

impl Drop for Component {
    fn drop(&mut self) {
        unsafe { fmi2::fmi2FreeInstance(self.handle) };
    }
}
