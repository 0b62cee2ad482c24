//! What observers may read, sent in a way that cannot disturb the run.
//!
//! A separate thread sends it, and whatever cannot be sent at once is dropped: by the queue to that
//! thread, and by Zenoh when the connection to an observer is congested. The keys are not part of
//! the protocol, so an observer that reads all of them never delays a step.
//!
//! The queues of Zenoh are as long as possible and it waits longer than usual before it drops,
//! because an observer that once missed a message receives nothing more on that connection
//! (zenoh-transport 1.10 without priorities marks a congested connection with one bit and clears
//! another).
//!
//! * `cosim/1/<run>/status`: a [`Status`] in JSON, four times a second;
//! * `cosim/1/<run>/signals`, on demand: `{"time": s, "values": {"component.variable": ..}}`, the
//!   recorded values at every instant at which they are recorded.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, Instant};

use serde_json::{Map, Value, json};
use zenoh::bytes::Encoding;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;
use zenoh::{Session, Wait};

use super::keys;
use super::status::Board;
use cosim_base::error::{Code, Error, Result};
use cosim_base::texts;
use cosim_base::time::Time;
use cosim_core::master::{Change, Drive, EngineState, Report};

/// Time between two status messages.
const PULSE: Duration = Duration::from_millis(250);
/// Rows that wait to be sent; further rows are dropped.
const QUEUE: usize = 256;

/// How often signals are sent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rate {
    /// At every instant at which they are recorded.
    All,
    /// At most this many times per second of wall-clock time.
    PerSecond(f64),
}

/// One row of recorded values.
type Row = (Time, Vec<f64>);

/// Takes recorded values; it never blocks.
pub(super) struct Feed {
    rate: Option<Rate>,
    rows: SyncSender<Row>,
    last: Option<Instant>,
}

impl Feed {
    fn take(&mut self, time: Time, values: &[f64]) {
        let due = match self.rate {
            None => false,
            Some(Rate::All) => true,
            Some(Rate::PerSecond(rate)) => {
                self.last.is_none_or(|last| last.elapsed().as_secs_f64() * rate >= 1.0)
            }
        };
        if due {
            self.last = Some(Instant::now());
            // The queue is full or its reader gone: an observer misses a row.
            let _ = self.rows.try_send((time, values.to_vec()));
        }
    }
}

/// A system whose recorded values also go to a feed.
pub(super) struct Fed<'a, D> {
    pub(super) driven: &'a mut D,
    pub(super) feed: Feed,
}

impl<D: Drive> Drive for Fed<'_, D> {
    fn initialize(&mut self, stop: Time) -> Result<()> {
        self.driven.initialize(stop)
    }

    fn run_until(&mut self, limit: Time) -> Result<()> {
        self.driven.run_until(limit)
    }

    fn conclude(&mut self, now: Time) -> Result<()> {
        self.driven.conclude(now)
    }

    fn sample(&mut self, now: Time, row: &mut [f64]) -> Result<()> {
        self.driven.sample(now, row)?;
        self.feed.take(now, row);
        Ok(())
    }

    fn change(&mut self, component: usize, change: Change, now: Time) -> Result<()> {
        self.driven.change(component, change, now)
    }

    fn save(&mut self, now: Time) -> Result<EngineState> {
        self.driven.save(now)
    }

    fn resume(&mut self, state: &EngineState, time: Time, stop: Time) -> Result<()> {
        self.driven.resume(state, time, stop)
    }

    fn report(&mut self) -> Result<Report> {
        self.driven.report()
    }
}

/// The sending side.
pub(super) struct Sender {
    board: Arc<Board>,
    names: Vec<String>,
    /// The columns that hold Strings.
    texts: Vec<bool>,
    rows: Receiver<Row>,
    status: Publisher<'static>,
    signals: Publisher<'static>,
}

/// The two ends of the telemetry of a run that records `names`.
pub(super) fn open(
    session: &Session,
    run: &str,
    board: Arc<Board>,
    (names, texts): (Vec<String>, Vec<bool>),
    rate: Option<Rate>,
) -> Result<(Feed, Sender)> {
    let publisher = |what: &str| {
        session
            .declare_publisher(keys::open(&format!("{run}/{what}")))
            .congestion_control(CongestionControl::Drop)
            .encoding(Encoding::APPLICATION_JSON)
            .wait()
            .map_err(|why| Error::new(Code::Session, "telemetry cannot be announced").why(why))
    };
    let (sender, rows) = sync_channel(QUEUE);
    let (status, signals) = (publisher("status")?, publisher("signals")?);
    let feed = Feed { rate, rows: sender, last: None };
    Ok((feed, Sender { board, names, texts, rows, status, signals }))
}

impl Sender {
    /// Sends until the feed is gone.
    pub(super) fn serve(self) {
        let mut next = Instant::now();
        loop {
            match self.rows.recv_timeout(next.saturating_duration_since(Instant::now())) {
                Ok((time, values)) => {
                    let message = self.row(time, &values);
                    // What cannot be sent is lost, here and below: observers must not delay the
                    // run.
                    let _ = self.signals.put(message.to_string()).wait();
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if next <= Instant::now() {
                self.send_status(false);
                next = Instant::now() + PULSE;
            }
        }
        self.send_status(true);
    }

    fn send_status(&self, ended: bool) {
        let status = super::Status { ended, ..self.board.status() };
        if let Ok(text) = serde_json::to_string(&status) {
            let _ = self.status.put(text).wait();
        }
    }

    /// JSON has no NaN and no infinities: they become null.
    fn row(&self, time: Time, values: &[f64]) -> Value {
        let columns = self.names.iter().zip(&self.texts).zip(values);
        let values: Map<String, Value> = columns
            .map(|((name, is_text), value)| match is_text {
                true => (name.clone(), json!(*texts::text(*value))),
                false => (name.clone(), json!(value)),
            })
            .collect();
        json!({ "time": time.seconds(), "values": values })
    }
}
