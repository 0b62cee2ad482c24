//! Connections of a session that listens are closed at once, whatever waits in them.
//!
//! Zenoh asks that closing a connection waits up to ten seconds for what the other side has not read
//! (`SO_LINGER`, in zenoh-link-tcp and zenoh-link-tls 1.10), and it closes in the thread that receives
//! from everybody: an observer that stops reading would stop the run, as soon as it counts as lost.
//! Without that option, the kernel delivers in the background.
#![allow(unsafe_code, reason = "file descriptors that belong to Zenoh")]

use std::collections::BTreeSet;
use std::net::SocketAddr;
use std::os::fd::{BorrowedFd, RawFd};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::Duration;

use rustix::net::{getsockname, sockopt};

/// Time between two looks at the open connections.
const PERIOD: Duration = Duration::from_millis(100);

/// Local ports of the connections; 0: any.
static PORTS: Mutex<BTreeSet<u16>> = Mutex::new(BTreeSet::new());

/// From now on, connections that this process accepts at `port` do not linger.
pub(super) fn forbid(port: u16) {
    static THREAD: OnceLock<()> = OnceLock::new();
    PORTS.lock().unwrap_or_else(PoisonError::into_inner).insert(port);
    THREAD.get_or_init(|| {
        // Without the thread, an observer may stop the run for some seconds.
        let _ = std::thread::Builder::new().name("linger".to_owned()).spawn(|| {
            loop {
                forbid_all();
                std::thread::sleep(PERIOD);
            }
        });
    });
}

/// The same for the connections there are.
fn forbid_all() {
    let Ok(open) = std::fs::read_dir("/dev/fd") else {
        return;
    };
    let numbers = open.flatten().filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    for number in numbers.collect::<Vec<RawFd>>() {
        // SAFETY: it is used for this call only. If Zenoh has closed it, the calls of the system fail;
        // a file that has got the same number is checked like every other.
        forbid_one(unsafe { BorrowedFd::borrow_raw(number) });
    }
}

fn forbid_one(socket: BorrowedFd<'_>) {
    if !matches!(sockopt::socket_linger(socket), Ok(Some(_))) {
        return;
    }
    let address = getsockname(socket).ok().and_then(|address| SocketAddr::try_from(address).ok());
    let ports = PORTS.lock().unwrap_or_else(PoisonError::into_inner);
    if address.is_some_and(|a| ports.contains(&a.port()) || ports.contains(&0)) {
        // It fails only where Zenoh has closed the connection in the meantime.
        let _ = sockopt::set_socket_linger(socket, None);
    }
}

#[cfg(test)]
mod tests {
    use std::net::{TcpListener, TcpStream};

    use super::*;

    #[test]
    fn only_connections_to_a_port_of_ours_stop_to_linger() {
        let linger = Some(Duration::from_secs(10));
        let [ours, other] = [(); 2].map(|()| TcpListener::bind("127.0.0.1:0").unwrap());
        let [accepted, others] = [&ours, &other].map(|listener| {
            let dialled = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
            let (accepted, _) = listener.accept().unwrap();
            sockopt::set_socket_linger(&accepted, linger).unwrap();
            (accepted, dialled)
        });
        forbid(ours.local_addr().unwrap().port());
        while sockopt::socket_linger(&accepted.0).unwrap().is_some() {
            std::thread::yield_now();
        }
        assert_eq!(sockopt::socket_linger(&others.0).unwrap(), linger);
    }
}
