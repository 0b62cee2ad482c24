//! One client: a thread that sends updates and receives requests.

use std::io::ErrorKind;
use std::net::TcpStream;
use std::sync::Arc;
use std::time::Duration;

use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Error, Message, WebSocket};

use super::batch::Batch;
use super::hub::{About, Hub, Mailbox, Newest};

/// A protocol that a client speaks.
pub(super) trait Speaker {
    /// The first messages.
    fn greet(&mut self, about: &About) -> Vec<Message>;
    /// The status of the run; `dropped` is the number of rows that this client did not take in
    /// time.
    fn newest(&mut self, newest: &Newest, dropped: u64) -> Option<Message>;
    /// An event, as JSON.
    fn event(&mut self, event: String) -> Option<Message>;
    /// The messages of a batch.
    fn batch(&mut self, batch: &Batch) -> Vec<Message>;
    /// Answers a client's message.
    fn heard(&mut self, message: Message, hub: &Hub) -> Vec<Message>;
}

/// How long reading from the client takes at most.
const LOOK: Duration = Duration::from_millis(15);
/// A client that takes nothing for this long is gone.
const STALLED: Duration = Duration::from_secs(10);
/// How long a client has to acknowledge the end.
pub(super) const CLOSE_TIMEOUT: Duration = Duration::from_secs(1);

/// Serves a client until it or the run ends.
pub(super) fn serve(stream: TcpStream, rest: Vec<u8>, hub: &Hub, speaker: &mut dyn Speaker) {
    let limits = stream.set_read_timeout(Some(LOOK));
    if limits.and_then(|()| stream.set_write_timeout(Some(STALLED))).is_err() {
        return;
    }
    // Batches are complete: there is nothing to wait for.
    let _ = stream.set_nodelay(true);
    let config =
        WebSocketConfig::default().max_message_size(Some(1 << 18)).max_frame_size(Some(1 << 18));
    let mut socket = WebSocket::from_partially_read(stream, rest, Role::Server, Some(config));
    let mailbox = hub.join();
    // Whatever the reason, only the client could be informed, and it is gone.
    let _ = talk(&mut socket, hub, &mailbox, speaker);
    hub.leave(&mailbox);
}

/// `None` if the client is gone.
fn talk(
    socket: &mut WebSocket<TcpStream>,
    hub: &Hub,
    mailbox: &Arc<Mailbox>,
    speaker: &mut dyn Speaker,
) -> Option<()> {
    let send = |socket: &mut WebSocket<TcpStream>, messages: Vec<Message>| {
        messages.into_iter().try_for_each(|message| socket.send(message).ok())
    };
    let (mut greeted, mut version, mut event, mut dropped) = (false, 0, 0, 0);
    loop {
        // Before the rest, so that nothing sent with the end, or before it, is lost.
        let newest = hub.newest();
        if let Some(about) = hub.about() {
            if !greeted {
                greeted = true;
                send(socket, speaker.greet(about))?;
            }
            let (events, next) = hub.events(event);
            event = next;
            send(socket, events.into_iter().filter_map(|event| speaker.event(event)).collect())?;
            while let Some(batch) = mailbox.take() {
                send(socket, speaker.batch(&batch))?;
            }
        }
        if greeted && (newest.version, mailbox.dropped()) != (version, dropped) {
            (version, dropped) = (newest.version, mailbox.dropped());
            send(socket, speaker.newest(&newest, dropped).into_iter().collect())?;
        }
        if newest.ended {
            return part(socket);
        }
        match heard(socket)? {
            Some(Message::Close(_)) => return socket.flush().ok(),
            Some(message) if greeted => send(socket, speaker.heard(message, hub))?,
            _ => (),
        }
    }
}

/// A message of the client, if one arrives in time.
fn heard(socket: &mut WebSocket<TcpStream>) -> Option<Option<Message>> {
    match socket.read() {
        Ok(message) => Some(Some(message)),
        Err(Error::Io(e)) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
            Some(None)
        }
        Err(_) => None,
    }
}

/// Closes, and waits for the acknowledgement for a while: a connection that is cut before that may
/// lose the last messages.
fn part(socket: &mut WebSocket<TcpStream>) -> Option<()> {
    socket.close(None).ok()?;
    let mut left = CLOSE_TIMEOUT.as_millis() / LOOK.as_millis();
    while left > 0 {
        left -= u128::from(heard(socket)?.is_none());
    }
    Some(())
}
