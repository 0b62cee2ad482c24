//! The server: one port, one token, a thread for each client.

use std::fs::File;
use std::io::Read;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Condvar, Mutex};
use std::time::Duration;

use serde_json::{Value, json};

use super::client::{CLOSE_TIMEOUT, Speaker, serve};
use super::foxglove::{self, Foxglove};
use super::hub::{Hub, Playing, Request, locked};
use super::page::{self, Page};
use super::{Watch, http};
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::Time;
use cosim_core::scenario::Window;
use cosim_results::roles::Declaration;

/// Maximum number of clients.
const MOST: usize = 32;
/// How long a client may take to send its request.
const PATIENCE: Duration = Duration::from_secs(5);

/// Serves a run to browsers and to Foxglove.
pub struct Server {
    shared: Arc<Shared>,
    requests: Receiver<Request>,
    address: SocketAddr,
}

struct Shared {
    hub: Arc<Hub>,
    token: String,
    closed: AtomicBool,
    /// The number of clients, and a condition to wait for their ends.
    clients: AtomicUsize,
    fewer: (Mutex<()>, Condvar),
}

impl Server {
    /// Listens at an address; port 0 is any that is free.
    pub fn listen(address: SocketAddr, playing: Playing) -> Result<Self> {
        let refused = |why: std::io::Error| {
            Error::new(Code::Usage, format!("the live view cannot listen at {address}"))
                .why(why)
                .help("choose another port, or none: --live")
        };
        let listener = TcpListener::bind(address).map_err(refused)?;
        let address = listener.local_addr().map_err(refused)?;
        let mut random = [0; 16];
        File::open("/dev/urandom").and_then(|mut source| source.read_exact(&mut random)).map_err(
            |e| Error::new(Code::Usage, "the system provides no random numbers for a token").why(e),
        )?;
        let token = random.iter().map(|byte| format!("{byte:02x}")).collect();
        let (sender, requests) = channel();
        let shared = Arc::new(Shared {
            hub: Arc::new(Hub::new(sender, playing)),
            token,
            closed: AtomicBool::new(false),
            clients: AtomicUsize::new(0),
            fewer: (Mutex::new(()), Condvar::new()),
        });
        let serving = shared.clone();
        std::thread::spawn(move || serving.accept(&listener));
        Ok(Self { shared, requests, address })
    }

    /// Address of the page.
    pub fn page(&self) -> String {
        format!("http://{}/?token={}", self.address, self.shared.token)
    }

    /// Address for Foxglove and Lichtblick.
    pub fn foxglove(&self) -> String {
        format!("ws://{}/?token={}", self.address, self.shared.token)
    }

    /// The observer that shows a run; `faults` are those known in advance.
    pub fn watch(&self, roles: Option<Declaration>, faults: Vec<Window>) -> Watch {
        Watch::new(self.shared.hub.clone(), roles, faults)
    }

    /// The next request of a client; waits for one at most this long.
    pub fn request(&self, wait: Duration) -> Option<Request> {
        if wait.is_zero() {
            self.requests.try_recv().ok()
        } else {
            self.requests.recv_timeout(wait).ok()
        }
    }

    /// Updates the status of the run; in a pause clients have all samples.
    pub fn update(&self, now: Time, playing: &Playing) {
        self.shared.hub.publish();
        self.shared.hub.update(|newest| {
            newest.time = now;
            newest.playing = playing.clone();
        });
    }

    /// Reports a note.
    pub fn note(&self, now: Time, text: &str) {
        self.shared.hub.event(now, "note", text, Value::Null);
    }

    /// Reports an error.
    pub fn error(&self, now: Time, error: &Error) {
        self.shared.hub.event(now, "error", &error.line(), Value::Null);
    }

    /// Reports an injected fault.
    pub fn fault(&self, now: Time, window: &Window) {
        self.shared.hub.event(now, "fault", &window.label, json!(window));
    }

    /// Reports the end and disconnects the clients.
    pub fn end(self, now: Time, text: &str) {
        self.note(now, text);
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let Shared { hub, closed, clients, fewer, .. } = &*self.shared;
        hub.update(|newest| newest.ended = true);
        closed.store(true, Ordering::Release);
        // Wakes the accepting thread.
        drop(TcpStream::connect(self.address));
        let guard = locked(&fewer.0);
        let some = |_: &mut ()| clients.load(Ordering::Acquire) > 0;
        // Clients that have not acknowledged the end by then are disconnected when the process
        // ends.
        drop(fewer.1.wait_timeout_while(guard, CLOSE_TIMEOUT, some));
    }
}

impl Shared {
    fn accept(self: &Arc<Self>, listener: &TcpListener) {
        for stream in listener.incoming() {
            if self.closed.load(Ordering::Acquire) {
                return;
            }
            let Ok(stream) = stream else { continue };
            if self.clients.fetch_add(1, Ordering::AcqRel) >= MOST {
                self.left();
                continue;
            }
            let shared = self.clone();
            std::thread::spawn(move || {
                shared.client(stream);
                shared.left();
            });
        }
    }

    fn left(&self) {
        let _guard = locked(&self.fewer.0);
        self.clients.fetch_sub(1, Ordering::AcqRel);
        self.fewer.1.notify_all();
    }

    /// Whether a token is ours; the comparison takes the same time for every token.
    fn knows(&self, token: &str) -> bool {
        let pairs = self.token.bytes().zip(token.bytes());
        let differing = pairs.fold(0, |differing, (own, other)| differing | (own ^ other));
        token.len() == self.token.len() && differing == 0
    }

    fn client(&self, mut stream: TcpStream) {
        let limits = stream.set_read_timeout(Some(PATIENCE));
        if limits.and_then(|()| stream.set_write_timeout(Some(PATIENCE))).is_err() {
            return;
        }
        let Some(request) = http::read(&mut stream) else { return };
        let http::Request { is_get, path, token, upgrade, rest } = request;
        let refusal = match &upgrade {
            _ if !self.knows(&token) => Some((
                "403 Forbidden",
                "The address must include the token that the run has printed.\n",
            )),
            _ if !is_get || path != "/" => {
                Some(("404 Not Found", "There is nothing here: the page is at /.\n"))
            }
            Some((_, offered)) if protocol(offered).is_none() => {
                Some(("400 Bad Request", "The protocol of the WebSocket is not known.\n"))
            }
            _ => None,
        };
        if let Some((status, text)) = refusal {
            return http::answer(&mut stream, status, "text/plain", text);
        }
        match upgrade.and_then(|(key, offered)| Some((key, protocol(&offered)?))) {
            Some((key, protocol)) => {
                let mut speaker: Box<dyn Speaker> = match protocol {
                    page::PROTOCOL => Box::new(Page::default()),
                    protocol => Box::new(Foxglove::new(protocol)),
                };
                if http::upgrade(&mut stream, &key, protocol).is_ok() {
                    serve(stream, rest, &self.hub, &mut *speaker);
                }
            }
            None => http::answer(&mut stream, "200 OK", "text/html", &cosim_report::live_page()),
        }
    }
}

/// The first of our protocols that a client offers.
fn protocol(offered: &[String]) -> Option<&'static str> {
    let ours = [page::PROTOCOL].into_iter().chain(foxglove::PROTOCOLS);
    ours.into_iter().find(|name| offered.iter().any(|offered| offered == name))
}
