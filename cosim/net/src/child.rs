//! The process in which one incarnation of a group is computed.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use zenoh::{Session, Wait};

use super::access::allowed::Allowed;
use super::access::credentials::Credentials;
use super::access::endpoint::Endpoint;
use super::access::session::Access;
use super::channels::Channels;
use super::host::{Handled, Host};
use super::inbox::Inbox;
use super::keys;
use super::pool::Order;
use super::setup::{FmuFile, FmuSource};
use cosim_base::error::{Code, Error, Result};
use cosim_base::sha256;
use cosim_base::shown::visible;
use cosim_import::{Fmu, LastCall};

/// How long to wait for the coordinator.
const PATIENCE: Duration = Duration::from_secs(30);

/// Computes one incarnation of a group for the worker of that name until it is asked to finish. If
/// confined, its FMUs can read only these paths.
pub fn serve(
    access: &Access,
    worker: &str,
    order: &Order,
    allowed: Allowed,
    confined: Option<&[PathBuf]>,
) -> Result<()> {
    let allowed_files = allowed.files().map(|(_, file)| file.to_owned());
    let readable = confined.map(|named| named.iter().cloned().chain(allowed_files));
    let readable: Option<Vec<PathBuf>> = readable.map(Iterator::collect);
    if let Some(readable) = &readable {
        let ports =
            access.endpoints.iter().filter_map(|endpoint| match Endpoint::parse(endpoint) {
                Ok(Endpoint::Tcp(_, port) | Endpoint::Tls(_, port)) => Some(port),
                _ => None,
            });
        cosim_confine::process(&ports.collect::<Vec<_>>(), &std::env::temp_dir(), false)?;
        let own = access.credentials.iter().flat_map(Credentials::own).cloned();
        let all: Vec<PathBuf> = readable.iter().cloned().chain(own).collect();
        cosim_confine::all_threads_read(&std::env::temp_dir(), &all)?;
    }
    let [quick, session] = access.dial_channels()?;
    let channels = Channels { quick: &quick, bulk: &session };
    let key = keys::incarnation(&order.run, worker, order.group, order.generation);
    let inbox = Inbox::new();
    let commands = inbox.slot();
    // Nothing is computed in the callback: it runs on the receiving thread.
    let _commands = channels.hear(&format!("{key}/cmd"), move |bytes| commands.put(bytes))?;
    let answers = channels.sender(&format!("{key}/rep"))?;
    let begun = Instant::now();
    while !answers.is_heard()? {
        if begun.elapsed() > PATIENCE {
            return Err(Error::new(Code::Lost, "the coordinator does not listen")
                .why(format!("no subscriber to {key}/rep for {} s", PATIENCE.as_secs())));
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    let _tokens = channels.live(&format!("{key}/alive"))?;
    let fmus = Delivered::new(&session, &order.run, worker, allowed)?;
    if let Some(readable) = &readable {
        cosim_confine::this_thread(&std::env::temp_dir(), readable, false, false)?;
    }
    let mut host = Host::new(order.generation, Box::new(fmus));
    while let Some(message) = inbox.next(1, Duration::MAX) {
        let (answer, last) = match host.handle(&message) {
            Handled::Answer(answer) => (answer, false),
            Handled::Last(answer) => (answer, true),
            Handled::Ignored(why) => {
                eprintln!("group {}.{}: ignored: {}", order.group, order.generation, visible(&why));
                continue;
            }
        };
        answers.put(answer)?;
        if last {
            break;
        }
    }
    drop(host);
    // A group whose token disappears counts as lost: keep the tokens until the answer has arrived,
    // when the coordinator stops listening.
    let ended = Instant::now();
    while answers.is_heard()? && ended.elapsed() < PATIENCE {
        std::thread::sleep(Duration::from_millis(2));
    }
    Ok(())
}

fn refused(why: zenoh::Error) -> Error {
    Error::new(Code::Session, "the session of a group failed").why(why)
}

/// The name of the file with the last FMI call, in the temporary folder of the process.
pub(super) const LAST_CALL: &str = "last-call";

/// FMUs that are stored here, or that the coordinator sends.
struct Delivered {
    session: Session,
    run: String,
    worker: String,
    folder: tempfile::TempDir,
    last_call: Arc<LastCall>,
    allowed: Allowed,
}

impl Delivered {
    fn new(session: &Session, run: &str, worker: &str, allowed: Allowed) -> Result<Self> {
        let unmade = |why| Error::new(Code::Output, "a temporary file could not be made").why(why);
        let folder = tempfile::Builder::new().prefix("cosim-").tempdir();
        let last_call = LastCall::create(std::env::temp_dir().join(LAST_CALL));
        Ok(Self {
            session: session.clone(),
            run: run.to_owned(),
            worker: worker.to_owned(),
            folder: folder.map_err(|why: std::io::Error| unmade(why))?,
            last_call: Arc::new(last_call.map_err(unmade)?),
            allowed,
        })
    }
}

impl FmuSource for Delivered {
    fn permit(&self, component: &str, file: &FmuFile) -> Result<()> {
        self.allowed.check(component, file)
    }

    fn open(&mut self, file: &FmuFile) -> Result<Arc<Fmu>> {
        // Stored under its own name, which error messages show.
        let folder = self.folder.path().join(&file.sha256);
        let path: PathBuf = folder.join(&file.name);
        if !path.is_file() {
            let bytes = self.allowed.held(file).map_or_else(|| self.ask_for(file), Ok)?;
            if sha256(&bytes) != file.sha256 {
                return Err(undelivered(file).why("its hash is not the one that was announced"));
            }
            let written =
                std::fs::create_dir_all(folder).and_then(|()| std::fs::write(&path, bytes));
            written.map_err(|why| undelivered(file).why(why))?;
        }
        Fmu::open(&path)
    }

    fn last_call(&self) -> Option<Arc<LastCall>> {
        Some(self.last_call.clone())
    }
}

impl Delivered {
    fn ask_for(&self, file: &FmuFile) -> Result<Vec<u8>> {
        let (answers, inbox) = channel();
        self.session
            .get(keys::fmu(&self.run, &self.worker, &file.sha256))
            .timeout(Duration::from_secs(120))
            .callback(move |reply| {
                let _ = answers.send(reply.into_result());
            })
            .wait()
            .map_err(refused)?;
        match inbox.recv() {
            Ok(Ok(sample)) => Ok(sample.payload().to_bytes().into_owned()),
            Ok(Err(error)) => Err(undelivered(file).why(format!("{error:?}"))),
            Err(_) => Err(undelivered(file).why("the coordinator did not answer")),
        }
    }
}

fn undelivered(file: &FmuFile) -> Error {
    Error::new(Code::File, format!("{} was not delivered", file.name))
}
