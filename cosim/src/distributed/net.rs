//! The fabric over Zenoh: groups live on workers that dialled us.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;
use zenoh::sample::SampleKind;
use zenoh::{Session, Wait};

use super::fabric::{Event, Fabric};
use super::keys;
use super::pool::{Order, WorkerInfo};
use crate::error::{Code, Error, Result};

/// The workers that are there, by name.
type Present = Arc<Mutex<BTreeSet<String>>>;

/// Groups on workers.
pub(crate) struct Net {
    session: Session,
    run: String,
    events: Receiver<Event>,
    sender: Sender<Event>,
    present: Present,
    /// The worker that each group is meant for.
    homes: Vec<String>,
    lives: BTreeMap<usize, Life>,
    /// Subscribers and queryables end with this.
    _declared: Vec<Box<dyn std::any::Any>>,
}

struct Life {
    generation: u32,
    worker: String,
    commands: Publisher<'static>,
}

impl Net {
    /// For a run whose FMUs are `files` by their hash. Groups get their homes by [`Net::settle`].
    pub(crate) fn new(
        session: Session,
        run: &str,
        files: BTreeMap<String, PathBuf>,
    ) -> Result<Self> {
        let (sender, events) = channel();
        let present = Present::default();
        let mut declared: Vec<Box<dyn std::any::Any>> = Vec::new();

        let answers = sender.clone();
        let subscriber = session
            .declare_subscriber(keys::lives(run, "rep"))
            .callback(move |sample| {
                if let Some((group, _)) = keys::parse_life(sample.key_expr().as_str()) {
                    let bytes = sample.payload().to_bytes().into_owned();
                    let _ = answers.send(Event::Answer { group, bytes });
                }
            })
            .wait();
        declared.push(Box::new(subscriber.map_err(refused)?));

        let lives = sender.clone();
        let subscriber = session
            .liveliness()
            .declare_subscriber(keys::lives(run, "alive"))
            .history(true)
            .callback(move |sample| {
                let Some((group, generation)) = keys::parse_life(sample.key_expr().as_str()) else {
                    return;
                };
                let _ = lives.send(match sample.kind() {
                    SampleKind::Put => Event::Ready { group, generation },
                    SampleKind::Delete => {
                        let why = "its process ended".to_owned();
                        Event::Lost { group, generation, why }
                    }
                });
            })
            .wait();
        declared.push(Box::new(subscriber.map_err(refused)?));

        let workers = present.clone();
        let subscriber = session
            .liveliness()
            .declare_subscriber(keys::workers())
            .history(true)
            .callback(move |sample| {
                if let Some(worker) = keys::parse_worker(sample.key_expr().as_str()) {
                    let mut workers = workers.lock().unwrap_or_else(PoisonError::into_inner);
                    match sample.kind() {
                        SampleKind::Put => workers.insert(worker.to_owned()),
                        SampleKind::Delete => workers.remove(worker),
                    };
                }
            })
            .wait();
        declared.push(Box::new(subscriber.map_err(refused)?));

        for (hash, file) in files {
            let queryable = session
                .declare_queryable(keys::fmu(run, &hash))
                .callback(move |query| {
                    let sent = match std::fs::read(&file) {
                        Ok(bytes) => query.reply(query.key_expr().clone(), bytes).wait(),
                        Err(why) => query.reply_err(why.to_string()).wait(),
                    };
                    // One that is gone asks again in its next life.
                    drop(sent);
                })
                .wait();
            declared.push(Box::new(queryable.map_err(refused)?));
        }
        Ok(Self {
            session,
            run: run.to_owned(),
            events,
            sender,
            present,
            homes: Vec::new(),
            lives: BTreeMap::new(),
            _declared: declared,
        })
    }

    /// Waits until `count` workers, or those named, are there.
    pub(crate) fn gather(
        &self,
        count: usize,
        named: &[String],
        patience: Duration,
    ) -> Result<Vec<String>> {
        let begun = Instant::now();
        loop {
            let present = self.present();
            let missing: Vec<&String> = named.iter().filter(|n| !present.contains(*n)).collect();
            if missing.is_empty() && present.len() >= count {
                return Ok(present.into_iter().collect());
            }
            if begun.elapsed() > patience {
                let what = match missing.first() {
                    Some(name) => format!("the worker '{name}' is not there"),
                    None => format!("{} of {count} workers are there", present.len()),
                };
                let there: Vec<String> = present.into_iter().collect();
                return Err(Error::new(Code::Placement, what)
                    .why(format!(
                        "after {:.0} s there are: {}",
                        patience.as_secs_f64(),
                        list(&there)
                    ))
                    .maybe_help(missing.first().and_then(|name| {
                        crate::names::did_you_mean(name, there.iter().map(String::as_str))
                    })));
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// The worker of each group.
    pub(crate) fn settle(&mut self, homes: Vec<String>) {
        self.homes = homes;
    }

    /// What the workers say of themselves.
    pub(crate) fn infos(&self) -> Vec<WorkerInfo> {
        let (answers, inbox) = channel();
        for worker in self.present() {
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
            // A worker that has just gone says nothing.
            drop(asked);
        }
        drop(answers);
        let mut infos: Vec<WorkerInfo> = inbox.iter().flatten().collect();
        infos.sort_by(|a, b| a.name.cmp(&b.name));
        infos
    }

    fn present(&self) -> BTreeSet<String> {
        self.present.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The group's own worker if that is there; else the one with the fewest groups.
    fn choose(&self, group: usize) -> Option<String> {
        let present = self.present();
        let home = self.homes.get(group)?;
        if present.contains(home) {
            return Some(home.clone());
        }
        let load = |worker: &String| self.lives.values().filter(|l| l.worker == *worker).count();
        present.into_iter().min_by_key(|worker| load(worker))
    }

    fn order(&self, group: usize, generation: u32) -> Order {
        Order { run: self.run.clone(), group, generation }
    }

    /// Asks a worker to do something; a refusal is the loss of the life.
    fn ask(&self, worker: &str, what: &str, order: &Order) -> Result<()> {
        let bytes = postcard::to_stdvec(order)
            .map_err(|why| Error::new(Code::Protocol, "an order has no bytes").why(why))?;
        let (events, group, generation) = (self.sender.clone(), order.group, order.generation);
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
                    let _ = events.send(Event::Lost { group, generation, why });
                }
            })
            .wait()
            .map_err(refused)
    }
}

impl Fabric for Net {
    fn launch(&mut self, group: usize, generation: u32) -> Result<()> {
        let worker = self.choose(group).ok_or_else(|| {
            Error::new(Code::Lost, "no worker is left").help("start some: cosim worker")
        })?;
        let commands = self
            .session
            .declare_publisher(format!("{}/cmd", keys::life(&self.run, group, generation)))
            .congestion_control(CongestionControl::Block)
            .express(true)
            .wait()
            .map_err(refused)?;
        self.lives.insert(group, Life { generation, worker: worker.clone(), commands });
        self.ask(&worker, "start", &self.order(group, generation))
    }

    fn send(&mut self, group: usize, generation: u32, message: &[u8]) -> Result<()> {
        match self.lives.get(&group) {
            Some(life) if life.generation == generation => {
                life.commands.put(message).wait().map_err(refused)
            }
            _ => Ok(()),
        }
    }

    fn next(&mut self, patience: Duration) -> Option<Event> {
        self.events.recv_timeout(patience).ok()
    }

    fn abandon(&mut self, group: usize, generation: u32) {
        let Some(life) = self.lives.get(&group).filter(|life| life.generation == generation) else {
            return;
        };
        // A worker that does not hear it is gone, or its child ends with the run.
        let _ = self.ask(&life.worker, "stop", &self.order(group, generation));
    }

    fn place(&self, group: usize) -> String {
        match self.lives.get(&group) {
            Some(life) => format!("worker {}", life.worker),
            None => "no worker".to_owned(),
        }
    }
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

fn refused(why: zenoh::Error) -> Error {
    Error::new(Code::Session, "the session failed").why(why)
}
