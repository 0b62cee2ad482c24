//! Which instance a message belongs to: the live instances, by any identification that an FMU may
//! pass.
//!
//! FMI requires an FMU to pass the `componentEnvironment` that it was given. Some pass their
//! component instead, or a number of their own; so the value is looked up here, and never
//! dereferenced.

use std::collections::BTreeMap;
use std::ffi::c_char;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::memory;
use crate::log::Log;

/// By the address of the log, which is the `componentEnvironment`.
static LIVE: Mutex<BTreeMap<usize, Living>> = Mutex::new(BTreeMap::new());

/// Names of instances are compared up to this length.
const LONGEST: usize = 4096;

struct Living {
    log: Arc<Log>,
    name: String,
    /// 0 until it is created.
    component: usize,
}

fn live() -> MutexGuard<'static, BTreeMap<usize, Living>> {
    LIVE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The log of an instance, which can be found until this is dropped.
pub(crate) struct Known {
    log: Arc<Log>,
    stays: bool,
}

impl Known {
    /// The log of the instance of that name.
    pub(crate) fn new(log: Log, name: &str) -> Self {
        let log = Arc::new(log);
        let living = Living { log: log.clone(), name: name.to_owned(), component: 0 };
        live().insert(Arc::as_ptr(&log).addr(), living);
        Self { log, stays: false }
    }

    /// The FMU's own handle of its instance.
    pub(crate) fn is_of(&self, component: usize) {
        if let Some(living) = live().get_mut(&Arc::as_ptr(&self.log).addr()) {
            living.component = component;
        }
    }

    /// Keeps it permanently: the FMU may still log.
    pub(crate) fn stay(&mut self) {
        self.stays = true;
    }
}

impl std::ops::Deref for Known {
    type Target = Log;
    fn deref(&self) -> &Log {
        &self.log
    }
}

impl Drop for Known {
    fn drop(&mut self) {
        if !self.stays {
            live().remove(&Arc::as_ptr(&self.log).addr());
        }
    }
}

/// The log that a message belongs to: that of the instance with this environment; for an FMU that
/// passes something else, that of the only instance with that name, or that component, or the only
/// instance.
pub(super) fn find(environment: usize, name: *const c_char) -> Option<Arc<Log>> {
    if let Some(living) = live().get(&environment) {
        return Some(living.log.clone());
    }
    let name = memory::string(name.addr(), LONGEST);
    let live = live();
    let only = |wanted: &dyn Fn(&Living) -> bool| {
        let mut found = live.values().filter(|living| wanted(living));
        found.next().filter(|_| found.next().is_none())
    };
    let named = |living: &Living| name.as_deref() == Some(living.name.as_bytes());
    let is_component = |living: &Living| environment != 0 && living.component == environment;
    let found = only(&|living| named(living) && is_component(living))
        .or_else(|| only(&named))
        .or_else(|| only(&is_component))
        .or_else(|| only(&|_| true));
    found.map(|living| living.log.clone())
}
