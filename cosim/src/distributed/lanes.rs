//! The two lanes on which messages travel between the coordinator and a host.
//!
//! Zenoh usually gives a message to a thread that sends it, in pieces if it is large. Its transport
//! for low latency sends in the thread that has the message, which makes a step shorter by a
//! quarter; but what is too large for one read ends the connection, and whoever sends to somebody
//! who does not read waits without end. So a host has two sessions. By the quick one go small
//! messages only: as a host gets a command when it has answered the one before, all that can be on
//! the way fits into the buffers of a socket, whether it is read or not. The others go by the bulk
//! lane. If the other side does not offer the quick transport, both are alike.

use std::any::Any;

use zenoh::bytes::ZBytes;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;
use zenoh::{Session, Wait};

use crate::error::{Code, Error, Result};

/// Octets of the largest message on the quick lane: those of a thousand signals.
const SMALL: usize = 8 * 1024;

/// The sessions that the lanes belong to; on the coordinator's side it is one for both.
pub(super) struct Lanes<'a> {
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

impl Lanes<'_> {
    /// Each lane with its session and the key that messages have on it.
    fn each(&self, key: &str) -> [(&Session, String); 2] {
        [(self.quick, format!("{key}/quick")), (self.bulk, format!("{key}/bulk"))]
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
        let lane = if message.len() <= SMALL { &self.quick } else { &self.bulk };
        lane.put(message).wait().map_err(refused)
    }

    /// Whether somebody hears both lanes.
    pub(super) fn is_heard(&self) -> Result<bool> {
        let heard = |lane: &Publisher<'_>| {
            lane.matching_status().wait().map(|status| status.matching()).map_err(refused)
        };
        Ok(heard(&self.quick)? && heard(&self.bulk)?)
    }
}

fn refused(why: zenoh::Error) -> Error {
    Error::new(Code::Session, "the session failed").why(why)
}
