//! The fabric over Zenoh: groups run on workers that connected to us.

use std::any::Any;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use zenoh::query::Query;
use zenoh::sample::SampleKind;
use zenoh::{Session, Wait};

use super::channels::{self, Channels, Sender};
use super::fabric::{Event, Fabric};
use super::inbox::Inbox;
use super::keys;
use super::pool::{Order, WorkerInfo};
use super::presence::Presence;
use super::process_status::ProcessStatus;
use cosim_base::error::{Code, Error, Result};

/// How long a worker may take to report how an incarnation ended. It asks its own machine, and a
/// run is waiting.
const INQUIRY: Duration = Duration::from_millis(200);

/// Interval at which the worker is asked about incarnations that are starting.
const POLL: Duration = Duration::from_millis(500);

/// Groups on workers.
pub(crate) struct Net {
    session: Session,
    run: String,
    inbox: Inbox<Notification>,
    /// Events to return next.
    due: VecDeque<Event>,
    presence: Presence,
    /// Workers that did not answer; they are used only when no other worker is connected.
    unresponsive: BTreeSet<String>,
    /// The worker that each group is assigned to.
    assigned: Vec<String>,
    /// How long to wait for a worker when none is left.
    patience: Duration,
    incarnations: BTreeMap<usize, Incarnation>,
    /// The FMUs of each group, by their hash.
    files: Vec<BTreeMap<String, PathBuf>>,
    /// FMUs that a worker may fetch, because one of their components is or was placed there.
    served: BTreeMap<(String, String), Box<dyn Any>>,
    /// Dropping it ends the subscription to workers.
    _presence: Box<dyn Any>,
}

struct Incarnation {
    generation: u32,
    worker: String,
    commands: Sender,
    /// Dropping them ends the subscriptions.
    _heard: [Box<dyn Any>; 2],
    /// It accepts messages.
    ready: bool,
}

/// What callbacks report.
pub(super) enum Notification {
    Event(Event),
    /// A worker has connected.
    Joined(String),
    /// A worker has disconnected.
    Left(String),
}

impl Net {
    /// For a run whose groups have these FMUs, by hash. [`Net::settle`] assigns the groups to
    /// workers.
    pub(crate) fn new(
        session: Session,
        run: &str,
        files: Vec<BTreeMap<String, PathBuf>>,
    ) -> Result<Self> {
        let inbox = Inbox::new();
        let (presence, subscriber) = Presence::follow(&session, inbox.slot())?;
        Ok(Self {
            session,
            run: run.to_owned(),
            inbox,
            due: VecDeque::new(),
            presence,
            unresponsive: BTreeSet::new(),
            assigned: Vec::new(),
            patience: Duration::ZERO,
            incarnations: BTreeMap::new(),
            files,
            served: BTreeMap::new(),
            _presence: subscriber,
        })
    }

    /// Waits until `count` workers, and those named, are connected.
    pub(crate) fn gather(
        &self,
        count: usize,
        named: &[String],
        patience: Duration,
    ) -> Result<Vec<String>> {
        self.presence.gather(count, named, patience)
    }

    /// Sets the worker of each group, and how long to wait for one when none is left.
    pub(crate) fn settle(&mut self, assigned: Vec<String>, patience: Duration) {
        self.assigned = assigned;
        self.patience = patience;
    }

    /// What the workers report about themselves.
    pub(crate) fn infos(&self) -> Vec<WorkerInfo> {
        let (answers, inbox) = channel();
        for worker in self.presence.names() {
            let answers = answers.clone();
            let asked = self
                .session
                .get(format!("{}/info", keys::worker(&worker)))
                .timeout(Duration::from_secs(2))
                .callback(move |reply| {
                    if let Ok(sample) = reply.result() {
                        let bytes = sample.payload().to_bytes();
                        let _ = answers.send(postcard::from_bytes::<WorkerInfo>(&bytes).ok());
                    }
                })
                .wait();
            // A worker that has just disconnected does not answer.
            drop(asked);
        }
        drop(answers);
        let mut infos: Vec<WorkerInfo> = inbox.iter().flatten().collect();
        infos.sort_by(|a, b| a.name.cmp(&b.name));
        infos
    }

    /// The group's assigned worker if it is connected; otherwise the one with the fewest groups. If
    /// none is connected, waits for one to come back.
    fn choose(&self, group: usize) -> Option<String> {
        let begun = Instant::now();
        loop {
            let mut there = self.presence.names();
            if there.iter().any(|worker| !self.unresponsive.contains(worker)) {
                there.retain(|worker| !self.unresponsive.contains(worker));
            }
            let own = self.assigned.get(group).filter(|own| there.contains(*own));
            let load = |worker: &String| {
                self.incarnations
                    .values()
                    .filter(|incarnation| incarnation.worker == *worker)
                    .count()
            };
            let least = there.iter().min_by_key(|worker| load(worker));
            if let Some(worker) = own.or(least) {
                return Some(worker.clone());
            }
            if begun.elapsed() > self.patience {
                return None;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Handles the incarnations of a worker that has disconnected: those that are not ready yet
    /// never will be. The others are still connected, or report their end themselves.
    fn left(&mut self, worker: &str) {
        for (&group, incarnation) in
            self.incarnations.iter().filter(|(_, incarnation)| incarnation.worker == worker)
        {
            if !incarnation.ready {
                let (generation, why) =
                    (incarnation.generation, format!("worker {worker} is gone"));
                self.due.push_back(Event::Lost { group, generation, why });
            }
        }
    }

    fn order(&self, group: usize, generation: u32) -> Order {
        Order { run: self.run.clone(), group, generation }
    }

    fn channels(&self) -> Channels<'_> {
        Channels { quick: &self.session, bulk: &self.session }
    }

    /// Lets a worker fetch the FMUs of a group that is placed there.
    fn serve_fmus(&mut self, group: usize, worker: &str) -> Result<()> {
        for (hash, file) in self.files.get(group).into_iter().flatten() {
            let place = (worker.to_owned(), hash.clone());
            if self.served.contains_key(&place) {
                continue;
            }
            let file = file.clone();
            let queryable = self
                .session
                .declare_queryable(keys::fmu(&self.run, worker, hash))
                .callback(move |query| {
                    let file = file.clone();
                    // In a thread of its own: other messages must not wait for it.
                    std::thread::spawn(move || deliver(&query, &file));
                })
                .wait();
            self.served.insert(place, Box::new(queryable.map_err(refused)?));
        }
        Ok(())
    }

    /// Whether an incarnation that is not ready yet has ended: nothing else would report it.
    fn poll_launches(&self) {
        for (&group, incarnation) in
            self.incarnations.iter().filter(|(_, incarnation)| !incarnation.ready)
        {
            let generation = incarnation.generation;
            let Ok(order) = postcard::to_stdvec(&self.order(group, generation)) else { continue };
            let events = self.inbox.slot();
            let asked = self
                .session
                .get(format!("{}/fate", keys::worker(&incarnation.worker)))
                .payload(order)
                .timeout(POLL)
                .callback(move |reply| {
                    let Ok(sample) = reply.result() else { return };
                    let answer = postcard::from_bytes(&sample.payload().to_bytes());
                    if let Ok(Ok::<ProcessStatus, String>(status)) = answer
                        && status.has_ended()
                    {
                        let why = "it ended before it was ready".to_owned();
                        events.put_urgent(Notification::Event(Event::Lost {
                            group,
                            generation,
                            why,
                        }));
                    }
                })
                .wait();
            // The loss of a worker is noticed elsewhere.
            drop(asked);
        }
    }

    /// Subscribes to an incarnation under its own key, which no one else may use.
    fn hear(&self, key: &str, group: usize, generation: u32) -> Result<[Box<dyn Any>; 2]> {
        let answers = self.inbox.slot();
        let answered = self.channels().hear(&format!("{key}/rep"), move |bytes| {
            answers.put(Notification::Event(Event::Answer { group, bytes, at: Instant::now() }));
        })?;
        let incarnations = self.inbox.slot();
        let token = self
            .session
            .liveliness()
            .declare_subscriber(format!("{key}/alive/*"))
            .history(true)
            .callback(move |sample| {
                let event = match sample.kind() {
                    SampleKind::Put if !channels::is_last(sample.key_expr()) => return,
                    SampleKind::Put => Event::Ready { group, generation },
                    SampleKind::Delete => {
                        let why = "the connection was lost".to_owned();
                        Event::Lost { group, generation, why }
                    }
                };
                incarnations.put_urgent(Notification::Event(event));
            })
            .wait()
            .map_err(refused)?;
        Ok([answered, Box::new(token)])
    }

    /// Sends a worker an order; a refusal counts as the loss of the incarnation.
    fn ask(&self, worker: &str, what: &str, order: &Order) -> Result<()> {
        let bytes = postcard::to_stdvec(order)
            .map_err(|why| Error::new(Code::Protocol, "an order cannot be serialized").why(why))?;
        let (events, group, generation) = (self.inbox.slot(), order.group, order.generation);
        let name = worker.to_owned();
        self.session
            .get(format!("{}/{what}", keys::worker(worker)))
            .payload(bytes)
            .timeout(Duration::from_secs(30))
            .callback(move |reply| {
                let outcome = match reply.result() {
                    Ok(sample) => postcard::from_bytes(&sample.payload().to_bytes())
                        .unwrap_or_else(|why| Err(format!("its answer cannot be read: {why}"))),
                    Err(error) => Err(format!("{error:?}")),
                };
                if let Err::<(), String>(why) = outcome {
                    let why = format!("worker {name}: {why}");
                    events.put_urgent(Notification::Event(Event::Lost { group, generation, why }));
                }
            })
            .wait()
            .map_err(refused)
    }
}

impl Fabric for Net {
    fn launch(&mut self, group: usize, generation: u32) -> Result<()> {
        let worker = self.choose(group).ok_or_else(|| {
            Error::new(Code::Lost, "no worker is left")
                .why(format!("none connected within {:.0} s", self.patience.as_secs_f64()))
                .help("start one: cosim worker")
        })?;
        self.serve_fmus(group, &worker)?;
        let key = keys::incarnation(&self.run, &worker, group, generation);
        let heard = self.hear(&key, group, generation)?;
        let commands = self.channels().sender(&format!("{key}/cmd"))?;
        let incarnation = Incarnation {
            generation,
            worker: worker.clone(),
            commands,
            _heard: heard,
            ready: false,
        };
        self.incarnations.insert(group, incarnation);
        self.ask(&worker, "start", &self.order(group, generation))
    }

    fn send(&mut self, group: usize, generation: u32, message: &[u8]) -> Result<()> {
        match self.incarnations.get(&group) {
            Some(incarnation) if incarnation.generation == generation => {
                incarnation.commands.put(message)
            }
            _ => Ok(()),
        }
    }

    fn next(&mut self, awaited: usize, patience: Duration) -> Option<Event> {
        let begun = Instant::now();
        loop {
            if let Some(event) = self.due.pop_front() {
                return Some(event);
            }
            let left = patience.saturating_sub(begun.elapsed());
            let launching = self.incarnations.values().any(|incarnation| !incarnation.ready);
            let notification =
                match self.inbox.next(awaited, if launching { left.min(POLL) } else { left }) {
                    Some(notification) => notification,
                    None if launching && left > POLL => {
                        self.poll_launches();
                        continue;
                    }
                    None => return None,
                };
            match notification {
                Notification::Event(event) => {
                    if let Event::Ready { group, generation } = event
                        && let Some(incarnation) = self.incarnations.get_mut(&group)
                    {
                        incarnation.ready |= incarnation.generation == generation;
                    }
                    return Some(event);
                }
                Notification::Joined(worker) => drop(self.unresponsive.remove(&worker)),
                Notification::Left(worker) => self.left(&worker),
            }
        }
    }

    fn inquire(&mut self, group: usize, generation: u32) -> Option<ProcessStatus> {
        let incarnation = self
            .incarnations
            .get(&group)
            .filter(|incarnation| incarnation.generation == generation)?;
        let worker = incarnation.worker.clone();
        if !self.presence.names().contains(&worker) {
            return None;
        }
        let order = postcard::to_stdvec(&self.order(group, generation)).ok()?;
        let (answers, inbox) = channel();
        self.session
            .get(format!("{}/fate", keys::worker(&worker)))
            .payload(order)
            .timeout(INQUIRY)
            .callback(move |reply| {
                let bytes =
                    reply.result().ok().map(|sample| sample.payload().to_bytes().into_owned());
                let _ = answers.send(bytes);
            })
            .wait()
            .ok()?;
        // The channel closes without an answer when the worker is gone or does not answer in time.
        let Ok(Some(answer)) = inbox.recv_timeout(2 * INQUIRY) else {
            self.unresponsive.insert(worker);
            return None;
        };
        postcard::from_bytes::<Result<ProcessStatus, String>>(&answer).ok()?.ok()
    }

    fn abandon(&mut self, group: usize, generation: u32) {
        let Some(incarnation) = self
            .incarnations
            .get(&group)
            .filter(|incarnation| incarnation.generation == generation)
        else {
            return;
        };
        // A worker that does not receive it is gone, or its child ends with the run.
        let _ = self.ask(&incarnation.worker, "stop", &self.order(group, generation));
    }

    fn place(&self, group: usize) -> String {
        match self.incarnations.get(&group) {
            Some(incarnation) => format!("worker {}", incarnation.worker),
            None => "no worker".to_owned(),
        }
    }
}

/// Sends an FMU to a worker that requests it. If the worker is gone, it requests the FMU again for
/// the next incarnation.
fn deliver(query: &Query, file: &Path) {
    let sent = match std::fs::read(file) {
        Ok(bytes) => query.reply(query.key_expr().clone(), bytes).wait(),
        Err(why) => query.reply_err(why.to_string()).wait(),
    };
    drop(sent);
}

pub(super) fn refused(why: zenoh::Error) -> Error {
    Error::new(Code::Session, "the session failed").why(why)
}
