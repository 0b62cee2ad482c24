//! Data shared by the run and the threads of clients.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use serde_json::{Map, Value, json};

use super::batch::{Batch, Thinned};
use cosim_base::time::Time;
use cosim_core::system::Column;
use cosim_results::roles::{Declaration, Roles};

/// A request of a client.
#[derive(Debug, Clone, PartialEq)]
pub enum Request {
    /// Stop before the next step.
    Pause,
    /// Continue.
    Play,
    /// Make one output interval, and pause.
    Step,
    /// Simulated seconds per second; `None`: as fast as possible.
    Speed(Option<f64>),
    /// Inject this fault.
    Inject(Map<String, Value>),
}

/// The minimum and maximum speed that can be requested: a slower run would not react for a long
/// time.
pub(super) const SPEEDS: (f64, f64) = (0.1, 1e6);

/// The playback state of a run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Playing {
    /// It is paused.
    pub paused: bool,
    /// Requested simulated seconds per second; `None`: as fast as possible.
    pub speed: Option<f64>,
}

/// Properties of a run.
pub(super) struct About {
    pub(super) name: String,
    pub(super) columns: Vec<Column>,
    pub(super) start: Time,
    pub(super) stop: Time,
    pub(super) roles: Roles,
    pub(super) declared: Option<Declaration>,
    /// When faults of scenarios act, as far as that is known in advance.
    pub(super) faults: Value,
}

/// The latest status.
#[derive(Debug, Clone, Default)]
pub(super) struct Newest {
    /// Changes with every change of the other fields.
    pub(super) version: u64,
    pub(super) playing: Playing,
    pub(super) time: Time,
    /// Simulated seconds per second, measured.
    pub(super) factor: f64,
    pub(super) ended: bool,
}

/// Batches for one client.
pub(super) struct Mailbox {
    waiting: Mutex<VecDeque<Arc<Batch>>>,
    /// Rows that the client did not take in time.
    dropped: AtomicU64,
}

/// Maximum number of batches that wait for a client: new ones replace the oldest.
const WAITING: usize = 8;
/// Maximum number of events kept for clients that connect later.
const EVENTS: usize = 1000;

pub(super) struct Hub {
    about: OnceLock<About>,
    pub(super) newest: Mutex<Newest>,
    /// The events so far, and the number of earlier ones that are no longer kept.
    events: Mutex<(VecDeque<String>, usize)>,
    pub(super) history: Mutex<Thinned>,
    /// Samples since the last batch; only the run uses them.
    pub(super) fresh: Mutex<Thinned>,
    clients: Mutex<Vec<Arc<Mailbox>>>,
    pub(super) requests: Mutex<Sender<Request>>,
}

/// The data of a thread that panicked are consistent: each change is one assignment.
pub(super) fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Mailbox {
    pub(super) fn take(&self) -> Option<Arc<Batch>> {
        locked(&self.waiting).pop_front()
    }

    pub(super) fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    fn put(&self, batch: &Arc<Batch>) {
        let mut waiting = locked(&self.waiting);
        if waiting.len() == WAITING
            && let Some(oldest) = waiting.pop_front()
        {
            self.dropped.fetch_add(oldest.times.len() as u64, Ordering::Relaxed);
        }
        waiting.push_back(batch.clone());
    }
}

impl Hub {
    pub(super) fn new(requests: Sender<Request>, playing: Playing) -> Self {
        Self {
            about: OnceLock::new(),
            newest: Mutex::new(Newest { version: 1, playing, ..Newest::default() }),
            events: Mutex::default(),
            history: Mutex::new(Thinned::new(0, 2)),
            fresh: Mutex::new(Thinned::new(0, 2)),
            clients: Mutex::default(),
            requests: Mutex::new(requests),
        }
    }

    /// The run starts; `history` and `batch` are the most rows to keep and to send at once.
    pub(super) fn begin(&self, about: About, history: usize, batch: usize) {
        *locked(&self.history) = Thinned::new(about.columns.len(), history);
        *locked(&self.fresh) = Thinned::new(about.columns.len(), batch);
        self.update(|newest| newest.time = about.start);
        // A server serves one run.
        let _ = self.about.set(about);
    }

    /// Properties of the run, once it has started.
    pub(super) fn about(&self) -> Option<&About> {
        self.about.get()
    }

    pub(super) fn update(&self, change: impl FnOnce(&mut Newest)) {
        let mut newest = locked(&self.newest);
        change(&mut newest);
        newest.version += 1;
    }

    pub(super) fn newest(&self) -> Newest {
        locked(&self.newest).clone()
    }

    /// Adds an event at an instant: `kind` is `note`, `fault` or `error`.
    pub(super) fn event(&self, time: Time, kind: &str, text: &str, more: Value) {
        let event = json!({
            "op": "event", "time": time.seconds(), "kind": kind, "text": text, "more": more,
        });
        let mut events = locked(&self.events);
        events.0.push_back(event.to_string());
        if events.0.len() > EVENTS {
            events.0.pop_front();
            events.1 += 1;
        }
    }

    /// The events from number `from` on, and the number of the next one.
    pub(super) fn events(&self, from: usize) -> (Vec<String>, usize) {
        let events = locked(&self.events);
        let skip = from.saturating_sub(events.1);
        (events.0.iter().skip(skip).cloned().collect(), events.1 + events.0.len())
    }

    pub(super) fn join(&self) -> Arc<Mailbox> {
        let mailbox = Mailbox { waiting: Mutex::default(), dropped: AtomicU64::new(0) };
        let mailbox = Arc::new(mailbox);
        locked(&self.clients).push(mailbox.clone());
        mailbox
    }

    pub(super) fn leave(&self, mailbox: &Arc<Mailbox>) {
        locked(&self.clients).retain(|client| !Arc::ptr_eq(client, mailbox));
    }

    /// Sends the samples since the last batch.
    pub(super) fn publish(&self) {
        let batch = Arc::new(locked(&self.fresh).take());
        locked(&self.clients).iter().for_each(|client| client.put(&batch));
    }

    pub(super) fn request(&self, request: Request) {
        // A run that has ended receives nothing.
        let _ = locked(&self.requests).send(request);
    }
}
