//! The protocol between the library of a remote FMU and the program beside it.
//!
//! The library is loaded into a third-party process: it computes nothing there, opens no connection
//! and starts no thread. All of that is done by the program, which ends with the socket between
//! them. While it works, it sends a signal twice a second, so the library never waits for a program
//! that hangs.

use std::io::{Error, ErrorKind, Read, Result, Write};
use std::path::PathBuf;
use std::time::Duration;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::Message;
use crate::calls::{Ask, Outcome};

/// Interval at which the program signals that it works.
pub const SIGN: Duration = Duration::from_millis(500);
/// A program that is silent for this long is given up.
pub const SILENCE: Duration = Duration::from_secs(15);
/// Maximum size of a message in octets.
const MOST: u32 = 1 << 30;

/// Requests of the library.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub enum Request {
    /// An instance of the FMU described by the resources.
    Make {
        /// The FMU's resources.
        resources: PathBuf,
        /// Name of the instance.
        name: String,
        /// Debug messages are requested from it.
        debug: bool,
    },
    /// Calls of the instance.
    Calls(Vec<Ask>),
}

/// Answers of the program.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub enum Reply {
    /// It is still working.
    Working,
    /// The outcome of the calls, messages of the instance, and losses that were recovered.
    Done(Outcome, Vec<Message>, Vec<String>),
    /// The instance no longer exists.
    Lost(String),
}

/// Writes one message.
pub fn write(into: &mut impl Write, message: &impl Serialize) -> Result<()> {
    let wrong = |why| Error::new(ErrorKind::InvalidData, why);
    let mut bytes =
        postcard::to_extend(message, vec![0; 4]).map_err(|why| wrong(why.to_string()))?;
    let length = u32::try_from(bytes.len() - 4).ok().filter(|length| *length < MOST);
    let length = length.ok_or_else(|| wrong("a message is too large".to_owned()))?;
    bytes[..4].copy_from_slice(&length.to_le_bytes());
    into.write_all(&bytes)
}

/// Reads one message.
pub fn read<T: DeserializeOwned>(from: &mut impl Read) -> Result<T> {
    let wrong = |why: String| Error::new(ErrorKind::InvalidData, why);
    let mut length = [0; 4];
    from.read_exact(&mut length)?;
    let length = u32::from_le_bytes(length);
    if length >= MOST {
        return Err(wrong(format!("{length} octets are not a message")));
    }
    // Only what arrives takes memory.
    let mut bytes = Vec::new();
    if from.take(length.into()).read_to_end(&mut bytes)? < length as usize {
        return Err(ErrorKind::UnexpectedEof.into());
    }
    postcard::from_bytes(&bytes).map_err(|why| wrong(why.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_follow_one_another_and_what_is_cut_is_noticed() {
        let one = Reply::Lost("x".to_owned());
        let two = Reply::Done(Outcome::default(), Vec::new(), vec!["y".to_owned()]);
        let mut bytes = Vec::new();
        write(&mut bytes, &one).unwrap();
        write(&mut bytes, &two).unwrap();
        let mut from = &bytes[..];
        assert_eq!(read::<Reply>(&mut from).unwrap(), one);
        assert_eq!(read::<Reply>(&mut from).unwrap(), two);
        for length in 0..7 {
            assert!(read::<Reply>(&mut &bytes[..length.min(5)]).is_err(), "{length}");
        }
        assert!(read::<Reply>(&mut &[0xff; 9][..]).is_err());
    }
}
