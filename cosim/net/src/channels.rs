//! The two channels on which messages travel between the coordinator and a host.
//!
//! Zenoh usually hands a message to a sender thread, which splits it if it is large. Its
//! low-latency transport sends in the calling thread, which makes a step shorter by a quarter; but
//! a message that is too large for one read ends the connection, and sending to a peer that does
//! not read blocks forever. A host therefore has two sessions. The quick channel carries small
//! messages only: a host gets a command only after it has answered the one before, so everything in
//! flight fits into the socket buffers, whether it is read or not. All other messages use the bulk
//! channel. With TLS, or if one side does not offer it, there is no low-latency transport, and both
//! channels behave alike.

use std::any::Any;

use zenoh::bytes::ZBytes;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;
use zenoh::{Session, Wait};

use cosim_base::error::{Code, Error, Result};

/// Largest message on the quick channel, in octets: the size of a thousand signals.
const SMALL: usize = 8 * 1024;

/// The sessions of the channels; the coordinator uses one session for both.
pub(super) struct Channels<'a> {
    /// For small messages.
    pub quick: &'a Session,
    /// For large ones.
    pub bulk: &'a Session,
}

/// Sends messages.
pub(super) struct Sender {
    quick: Publisher<'static>,
    bulk: Publisher<'static>,
}

/// Whether a token is the last of the two that [`Channels::live`] declares.
pub(super) fn is_last(token: &str) -> bool {
    token.ends_with(QUICK)
}

const QUICK: &str = "/quick";
const BULK: &str = "/bulk";

impl Channels<'_> {
    /// Each channel with its session and its key below `key`.
    fn each(&self, key: &str) -> [(&Session, String); 2] {
        [(self.quick, format!("{key}{QUICK}")), (self.bulk, format!("{key}{BULK}"))]
    }

    /// Declares a token on each channel, the quick one last: a peer that sees that one can reach us
    /// on both, because it has seen everything that was declared before.
    pub(super) fn live(&self, key: &str) -> Result<[LivelinessToken; 2]> {
        let [quick, bulk] = self.each(key);
        let token = |(session, key): (&Session, String)| {
            session.liveliness().declare_token(key).wait().map_err(refused)
        };
        Ok([token(bulk)?, token(quick)?])
    }

    /// Sends under `key`.
    pub(super) fn sender(&self, key: &str) -> Result<Sender> {
        let [quick, bulk] = self.each(key).map(|(session, key)| {
            session
                .declare_publisher(key)
                .congestion_control(CongestionControl::Block)
                .express(true)
                .wait()
                .map_err(refused)
        });
        Ok(Sender { quick: quick?, bulk: bulk? })
    }

    /// Calls `hear` for every message under `key` until the returned value is dropped.
    pub(super) fn hear(
        &self,
        key: &str,
        hear: impl Fn(Vec<u8>) + Clone + Send + Sync + 'static,
    ) -> Result<Box<dyn Any>> {
        let [quick, bulk] = self.each(key).map(|(session, key)| {
            let hear = hear.clone();
            session
                .declare_subscriber(key)
                .callback(move |sample| hear(sample.payload().to_bytes().into_owned()))
                .wait()
                .map_err(refused)
        });
        Ok(Box::new([quick?, bulk?]))
    }
}

impl Sender {
    /// Sends a message.
    pub(super) fn put(&self, message: impl Into<ZBytes>) -> Result<()> {
        let message = message.into();
        let publisher = if message.len() <= SMALL { &self.quick } else { &self.bulk };
        publisher.put(message).wait().map_err(refused)
    }

    /// Whether a peer subscribes to both channels.
    pub(super) fn is_heard(&self) -> Result<bool> {
        let heard = |publisher: &Publisher<'_>| {
            publisher.matching_status().wait().map(|status| status.matching()).map_err(refused)
        };
        Ok(heard(&self.quick)? && heard(&self.bulk)?)
    }
}

fn refused(why: zenoh::Error) -> Error {
    Error::new(Code::Session, "the session failed").why(why)
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;
    use std::time::{Duration, Instant};

    use super::*;
    use crate::Access;

    const LONG: Duration = Duration::from_secs(30);

    /// A message in each direction, whatever batch size the user's configuration sets.
    #[test]
    fn messages_of_every_size_arrive_on_both_sides() {
        let folder = tempfile::TempDir::new().unwrap();
        let file = folder.path().join("c.json5");
        std::fs::write(&file, "{ transport: { link: { tx: { batch_size: 1024 } } } }").unwrap();
        let endpoints = vec![format!("unixsock-stream/{}/socket", folder.path().display())];
        let access = Access { endpoints, configuration: Some(file), ..Access::default() };
        let listening = access.listen().unwrap();
        let [quick, bulk] = access.dial_channels().unwrap();
        let here = Channels { quick: &listening, bulk: &listening };
        let there = Channels { quick: &quick, bulk: &bulk };
        for (number, (from, to)) in [(&here, &there), (&there, &here)].into_iter().enumerate() {
            let key = format!("channels/{number}");
            let (heard, inbox) = channel();
            let _hearing = to.hear(&key, move |bytes| drop(heard.send(bytes))).unwrap();
            let sender = from.sender(&key).unwrap();
            let begun = Instant::now();
            while !sender.is_heard().unwrap() {
                assert!(begun.elapsed() < LONG);
                std::thread::sleep(Duration::from_millis(1));
            }
            for size in [1, SMALL - 1, SMALL, SMALL + 1, 65_535, 65_536, 3_000_000, 64] {
                let message: Vec<u8> = (0..size).map(|octet| (octet % 251) as u8).collect();
                sender.put(&message[..]).unwrap();
                assert!(inbox.recv_timeout(LONG).unwrap() == message, "{size}");
            }
        }
    }
}
