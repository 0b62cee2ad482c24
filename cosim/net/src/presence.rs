//! The workers that are connected.

use std::any::Any;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use zenoh::sample::SampleKind;
use zenoh::{Session, Wait};

use super::inbox::Slot;
use super::keys;
use super::net::{Notification, refused};
use super::wire::VERSION;
use cosim_base::error::{Code, Error, Result};
use cosim_base::names::did_you_mean;

/// The workers that are connected, known by their liveliness tokens.
#[derive(Clone, Default)]
pub(super) struct Presence(Arc<Mutex<Workers>>);

#[derive(Default)]
struct Workers {
    names: BTreeSet<String>,
    /// Workers that speak another version of the protocol.
    incompatible: BTreeMap<String, String>,
}

impl Presence {
    /// Tracks which workers connect and disconnect until the second value is dropped; also reports
    /// it to `notifications`.
    pub(super) fn follow(
        session: &Session,
        notifications: Slot<Notification>,
    ) -> Result<(Self, Box<dyn Any>)> {
        let present = Self::default();
        let followed = present.clone();
        let subscriber = session
            .liveliness()
            .declare_subscriber(keys::workers())
            .history(true)
            .callback(move |sample| {
                let Some((version, name)) = keys::parse_worker(sample.key_expr().as_str()) else {
                    return;
                };
                let here = sample.kind() == SampleKind::Put;
                if followed.note(version, name, here) {
                    let name = name.to_owned();
                    notifications.put_urgent(if here {
                        Notification::Joined(name)
                    } else {
                        Notification::Left(name)
                    });
                }
            })
            .wait();
        Ok((present, Box::new(subscriber.map_err(refused)?)))
    }

    /// A worker connects or disconnects; whether it speaks our version.
    fn note(&self, version: &str, name: &str, here: bool) -> bool {
        let mut workers = self.lock();
        let ours = version == VERSION.to_string();
        match (ours, here) {
            (true, true) => drop(workers.names.insert(name.to_owned())),
            (true, false) => drop(workers.names.remove(name)),
            (false, true) => drop(workers.incompatible.insert(name.to_owned(), version.to_owned())),
            (false, false) => drop(workers.incompatible.remove(name)),
        }
        ours
    }

    /// Their names.
    pub(super) fn names(&self) -> BTreeSet<String> {
        self.lock().names.clone()
    }

    fn lock(&self) -> MutexGuard<'_, Workers> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until `count` workers, and those named, are connected.
    pub(super) fn gather(
        &self,
        count: usize,
        named: &[String],
        patience: Duration,
    ) -> Result<Vec<String>> {
        let begun = Instant::now();
        loop {
            if let Some((name, version)) = self.lock().incompatible.first_key_value() {
                return Err(Error::new(
                    Code::Protocol,
                    format!("the worker '{name}' speaks version {version} of the protocol"),
                )
                .why(format!("this cosim speaks version {VERSION}"))
                .help("use the same version of cosim everywhere"));
            }
            let present = self.names();
            let missing: Vec<&String> = named.iter().filter(|n| !present.contains(*n)).collect();
            if missing.is_empty() && present.len() >= count {
                return Ok(present.into_iter().collect());
            }
            if begun.elapsed() > patience {
                return Err(absent(&present, &missing, count, patience));
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

fn absent(
    present: &BTreeSet<String>,
    missing: &[&String],
    count: usize,
    patience: Duration,
) -> Error {
    let what = match missing.first() {
        Some(name) => format!("the worker '{name}' is not connected"),
        None => format!("{} of {count} workers are connected", present.len()),
    };
    let there: Vec<&str> = present.iter().map(String::as_str).collect();
    let list = if there.is_empty() { "none".to_owned() } else { there.join(", ") };
    let near = missing.first().and_then(|name| did_you_mean(name, there.iter().copied()));
    Error::new(Code::Placement, what)
        .why(format!("connected after {:.0} s: {list}", patience.as_secs_f64()))
        .maybe_help(near)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHORT: Duration = Duration::from_millis(1);

    #[test]
    fn workers_of_another_version_are_named() {
        let present = Presence::default();
        assert!(present.note(&VERSION.to_string(), "left", true));
        assert_eq!(present.gather(1, &[], SHORT).unwrap(), ["left"]);
        assert!(!present.note("9", "right", true));
        let error = present.gather(1, &[], SHORT).unwrap_err().to_string();
        assert!(
            error.contains("'right' speaks version 9") && error.contains("version 1"),
            "{error}"
        );
        assert!(!present.note("9", "right", false));
        assert!(present.gather(1, &[], SHORT).is_ok());
    }

    #[test]
    fn a_missing_worker_is_reported_with_the_nearest_name() {
        let present = Presence::default();
        present.note(&VERSION.to_string(), "left", true);
        let error = present.gather(1, &["lefd".to_owned()], SHORT).unwrap_err();
        assert_eq!(error.remedy(), Some("did you mean 'left'?"));
        let error = present.gather(2, &[], SHORT).unwrap_err();
        assert_eq!(error.what(), "1 of 2 workers are connected");
    }
}
