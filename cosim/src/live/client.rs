//! One client: a thread that sends what is new and hears what it wants.

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
    /// How the run is going; `dropped` are the rows that this client did not take in time.
    fn newest(&mut self, newest: &Newest, dropped: u64) -> Option<Message>;
    /// An event, as JSON.
    fn event(&mut self, event: String) -> Option<Message>;
    /// The messages of a batch.
    fn batch(&mut self, batch: &Batch) -> Vec<Message>;
    /// Answers a client's message.
    fn heard(&mut self, message: Message, hub: &Hub) -> Vec<Message>;
}

/// So long a look at what the client says takes at most.
const LOOK: Duration = Duration::from_millis(15);
/// A client that takes nothing for so long has gone.
const STALLED: Duration = Duration::from_secs(10);
/// So long a client has to answer the end.
pub(super) const FAREWELL: Duration = Duration::from_secs(1);

/// Serves a client to its end, or the run's.
pub(super) fn serve(stream: TcpStream, rest: Vec<u8>, hub: &Hub, speaker: &mut dyn Speaker) {
    let limits = stream.set_read_timeout(Some(LOOK));
    if limits.and_then(|()| stream.set_write_timeout(Some(STALLED))).is_err() {
        return;
    }
    // Batches are whole: there is nothing to wait for.
    let _ = stream.set_nodelay(true);
    let config =
        WebSocketConfig::default().max_message_size(Some(1 << 18)).max_frame_size(Some(1 << 18));
    let mut socket = WebSocket::from_partially_read(stream, rest, Role::Server, Some(config));
    let mailbox = hub.join();
    // Whatever ends it, there is nobody to report it to but the client, who has gone.
    let _ = talk(&mut socket, hub, &mailbox, speaker);
    hub.leave(&mailbox);
}

/// Nothing when the client has gone.
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
        // Before the rest: what is told with the end, or before it, is not left out.
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

/// What the client says, if it does within a while.
fn heard(socket: &mut WebSocket<TcpStream>) -> Option<Option<Message>> {
    match socket.read() {
        Ok(message) => Some(Some(message)),
        Err(Error::Io(e)) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
            Some(None)
        }
        Err(_) => None,
    }
}

/// Says good-bye, and waits a while for the answer: a connection that is cut before may lose what
/// was sent last.
fn part(socket: &mut WebSocket<TcpStream>) -> Option<()> {
    socket.close(None).ok()?;
    let mut left = FAREWELL.as_millis() / LOOK.as_millis();
    while left > 0 {
        left -= u128::from(heard(socket)?.is_none());
    }
    Some(())
}
