//! The two lanes on which messages travel between the coordinator and a host.
//!
//! Zenoh usually gives a message to a thread that sends it, in pieces if it is large. Its transport
//! for low latency sends in the thread that has the message, which makes a step shorter by a
//! quarter; but what is too large for one read ends the connection, and whoever sends to somebody
//! who does not read waits without end. So a host has two sessions. By the quick one go small
//! messages only: as a host gets a command when it has answered the one before, all that can be on
//! the way fits into the buffers of a socket, whether it is read or not. The others go by the bulk
//! lane. With TLS, or a side that does not offer it, there is no such transport, and both are alike.

use std::any::Any;

use zenoh::bytes::ZBytes;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;
use zenoh::{Session, Wait};

use crate::error::{Code, Error, Result};

/// Octets of the largest message on the quick lane: those of a thousand signals.
const SMALL: usize = 8 * 1024;

/// The sessions that the lanes belong to; on the coordinator's side it is one for both.
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
    /// Each lane with its session and its key below `key`.
    fn each(&self, key: &str) -> [(&Session, String); 2] {
        [(self.quick, format!("{key}{QUICK}")), (self.bulk, format!("{key}{BULK}"))]
    }

    /// A token on each lane, the quick one last: whoever sees that one can speak to us by both, as
    /// the other side has heard of what was declared before.
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

    /// Hears what comes under `key`, as long as what this gives is kept.
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

    /// Whether somebody hears both lanes.
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
    use crate::distributed::Access;

    const LONG: Duration = Duration::from_secs(30);

    /// Here to there and back, whatever somebody's configuration says of how much is sent at once.
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
