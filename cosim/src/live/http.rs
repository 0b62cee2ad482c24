//! Minimal HTTP/1.1: the page, and the upgrade to WebSocket.

use std::io::{Read, Write};
use std::net::TcpStream;

use tungstenite::handshake::derive_accept_key;

/// The head of a request, as far as it is needed.
pub(super) struct Request {
    pub(super) is_get: bool,
    pub(super) path: String,
    pub(super) token: String,
    /// The key and the protocols of a client that requests a WebSocket.
    pub(super) upgrade: Option<(String, Vec<String>)>,
    /// Data after the head.
    pub(super) rest: Vec<u8>,
}

/// Maximum length of a head.
const LONGEST: usize = 16 * 1024;

/// Reads a head; `None` if it is invalid, too long or too slow.
pub(super) fn read(stream: &mut TcpStream) -> Option<Request> {
    let mut bytes = Vec::new();
    let mut part = [0; 2048];
    loop {
        let count = stream.read(&mut part).ok().filter(|count| *count > 0)?;
        bytes.extend_from_slice(&part[..count]);
        let mut headers = [httparse::EMPTY_HEADER; 64];
        let mut head = httparse::Request::new(&mut headers);
        match head.parse(&bytes) {
            Ok(httparse::Status::Complete(length)) => {
                return Some(request(&head, bytes[length..].to_vec()));
            }
            Ok(httparse::Status::Partial) if bytes.len() < LONGEST => (),
            _ => return None,
        }
    }
}

fn request(head: &httparse::Request<'_, '_>, rest: Vec<u8>) -> Request {
    let header = |name: &str| {
        let found = head.headers.iter().find(|header| header.name.eq_ignore_ascii_case(name));
        found.and_then(|header| std::str::from_utf8(header.value).ok()).unwrap_or_default()
    };
    let (path, query) =
        head.path.unwrap_or("/").split_once('?').unwrap_or((head.path.unwrap_or("/"), ""));
    let token = query.split('&').find_map(|pair| pair.strip_prefix("token="));
    let websocket = header("upgrade").eq_ignore_ascii_case("websocket");
    let protocols = header("sec-websocket-protocol").split(',').map(|name| name.trim().to_owned());
    Request {
        is_get: head.method == Some("GET"),
        path: path.to_owned(),
        token: token.unwrap_or_default().to_owned(),
        upgrade: websocket.then(|| (header("sec-websocket-key").to_owned(), protocols.collect())),
        rest,
    }
}

/// Answers with a text and closes.
pub(super) fn answer(stream: &mut TcpStream, status: &str, kind: &str, body: &str) {
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}; charset=utf-8\r\nContent-Length: {}\r\n\
         Cache-Control: no-store\r\nReferrer-Policy: no-referrer\r\n\
         X-Content-Type-Options: nosniff\r\nX-Frame-Options: DENY\r\nConnection: close\r\n\r\n",
        body.len()
    );
    // A client that is gone gets no answer.
    let _ = stream.write_all(head.as_bytes()).and_then(|()| stream.write_all(body.as_bytes()));
}

/// Accepts a WebSocket with this protocol.
pub(super) fn upgrade(stream: &mut TcpStream, key: &str, protocol: &str) -> std::io::Result<()> {
    let accepted = derive_accept_key(key.as_bytes());
    let head = format!(
        "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Accept: {accepted}\r\nSec-WebSocket-Protocol: {protocol}\r\n\r\n"
    );
    stream.write_all(head.as_bytes())
}
