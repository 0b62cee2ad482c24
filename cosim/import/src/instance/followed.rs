//! Followers of the calls of an instance: value references become names again.

use std::collections::HashMap;
use std::fmt::Debug;
use std::sync::Arc;

use crate::status::{self, RawStatus};
use crate::trace::Trace;
use crate::{Description, Kind, LastCall, Logging};
use cosim_base::time::Time;

/// Followers, and the names they use.
pub(super) struct Followed {
    trace: Option<Arc<Trace>>,
    last: Option<Arc<LastCall>>,
    instance: String,
    /// Names of variables by FMI's base type and value reference; the first of several aliases.
    names: HashMap<(&'static str, u32), String>,
}

/// The arguments of a function that takes only the instance.
pub(super) fn nothing(_: &Followed) -> String {
    String::new()
}

/// Enumerations are read and set as Integers.
fn base(kind: &Kind) -> &'static str {
    match kind {
        Kind::Enumeration(_) => Kind::Integer.name(),
        kind => kind.name(),
    }
}

impl Followed {
    /// `None` if there are no followers.
    pub(super) fn of(logging: &Logging, instance: &str, description: &Description) -> Option<Self> {
        let (trace, last) = (logging.calls_of(instance), logging.last.clone());
        if trace.is_none() && last.is_none() {
            return None;
        }
        let mut names = HashMap::new();
        for variable in &description.variables {
            let key = (base(&variable.kind), variable.value_reference);
            names.entry(key).or_insert_with(|| variable.name.clone());
        }
        Some(Self { trace, last, instance: instance.to_owned(), names })
    }

    /// Before a call at the instance's time `now`. Arguments are formatted only for a trace.
    pub(super) fn begin(
        &self,
        function: &'static str,
        now: Time,
        arguments: impl FnOnce(&Self) -> String,
    ) {
        if let Some(last) = &self.last {
            last.begin(&self.instance, function, now);
        }
        if let Some(trace) = &self.trace {
            trace.begin(&self.instance, function, &arguments(self));
        }
    }

    /// After a call; `more`: its results follow.
    pub(super) fn end(&self, function: &'static str, status: RawStatus, more: bool) {
        if let Some(last) = &self.last {
            last.end();
        }
        if let Some(trace) = &self.trace {
            trace.end(&self.instance, function, status::name(status), more);
        }
    }

    pub(super) fn results(&self, results: impl FnOnce(&Self) -> String) {
        if let Some(trace) = &self.trace {
            trace.results(&results(self));
        }
    }

    /// `u, y`
    pub(super) fn names(&self, kind: &Kind, references: &[u32]) -> String {
        let names: Vec<String> = references.iter().map(|&r| self.name(kind, r)).collect();
        names.join(", ")
    }

    /// `u = 0.5, k = 2.0`
    pub(super) fn pairs<T: Debug>(&self, kind: &Kind, references: &[u32], values: &[T]) -> String {
        let pairs = references.iter().zip(values);
        let shown: Vec<String> =
            pairs.map(|(&r, value)| format!("{} = {value:?}", self.name(kind, r))).collect();
        shown.join(", ")
    }

    fn name(&self, kind: &Kind, reference: u32) -> String {
        let known = self.names.get(&(base(kind), reference));
        known.cloned().unwrap_or_else(|| format!("#{reference}"))
    }
}

/// `0.5, 2.0`
pub(super) fn values<T: Debug>(values: &[T]) -> String {
    let shown: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
    shown.join(", ")
}
