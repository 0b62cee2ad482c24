//! The frame around every exported function: find the instance, catch panics, compute in the
//! default environment.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::kernel::{Call, Served, Status};

use super::environment::Environment;
use super::handles::{Library, Live};
use super::types::{fmi2Component, fmi2Status};

/// Runs `work` on the instance behind a handle.
///
/// An invalid handle gives `fmi2Error`: without an instance there is no logger to report to.
#[inline]
pub(super) fn call<L: Library>(
    component: fmi2Component,
    call: Call,
    work: impl FnOnce(&mut L::Instance) -> Status,
) -> fmi2Status {
    call_live::<L>(component, call, |live| work(&mut live.instance))
}

/// The same for functions that also use saved states.
#[inline]
pub(super) fn call_live<L: Library>(
    component: fmi2Component,
    call: Call,
    work: impl FnOnce(&mut Live<L::Instance>) -> Status,
) -> fmi2Status {
    let _environment = Environment::enter();
    L::shelf().instances.with(component, |live| guarded(live, call, work)).unwrap_or(Status::Error)
}

/// Whether `simple` did all the work; it must neither be able to panic nor compute in floating
/// point. If it did not, [`call`] is used. The usual case is kept separate because it is so short.
#[inline(always)]
pub(super) fn done_simply<L: Library>(
    component: fmi2Component,
    simple: impl FnOnce(&mut L::Instance) -> Option<()>,
) -> bool {
    matches!(L::shelf().instances.with(component, |live| simple(&mut live.instance)), Ok(Some(())))
}

#[inline]
fn guarded<I: Served>(
    live: &mut Live<I>,
    call: Call,
    work: impl FnOnce(&mut Live<I>) -> Status,
) -> Status {
    match catch_unwind(AssertUnwindSafe(|| work(live))) {
        Ok(status) => status,
        Err(payload) => panicked(&mut live.instance, call, &*payload),
    }
}

#[cold]
fn panicked<I: Served>(instance: &mut I, call: Call, payload: &(dyn Any + Send)) -> Status {
    let text = panic_text(payload);
    // The importer's logger runs here; if it unwinds, only the status remains.
    catch_unwind(AssertUnwindSafe(|| instance.poison(call, text))).unwrap_or(Status::Fatal)
}

/// The message of a panic.
pub(super) fn panic_text(payload: &(dyn Any + Send)) -> &str {
    payload
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| payload.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no message")
}
