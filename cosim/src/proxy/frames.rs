//! What the library of a remote FMU and the program beside it say to each other.
//!
//! The library lives in a stranger's process: it computes nothing there, opens no connection and
//! starts no thread. All that is the program's, which ends with the socket between them. While it
//! works it says so twice a second, so the library never waits for one that is stuck.

use std::io::{Error, ErrorKind, Read, Result, Write};
use std::path::PathBuf;
use std::time::Duration;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::calls::{Ask, Outcome};
use crate::fmi::Message;

/// So often the program says that it works.
pub const SIGN: Duration = Duration::from_millis(500);
/// A program that says nothing for so long is given up.
pub const SILENCE: Duration = Duration::from_secs(15);
/// More octets than these are no message.
const MOST: u32 = 1 << 30;

/// What the library wants.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub enum Request {
    /// An instance of what the resources tell of.
    Make {
        /// The FMU's resources.
        resources: PathBuf,
        /// Name of the instance.
        name: String,
        /// It is asked for debug messages.
        debug: bool,
    },
    /// Calls of it.
    Calls(Vec<Ask>),
}

/// What the program answers.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub enum Reply {
    /// It works.
    Working,
    /// What became of the calls, what the instance said, and losses that were made good.
    Done(Outcome, Vec<Message>, Vec<String>),
    /// There is no instance any more.
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
        return Err(wrong(format!("{length} octets are no message")));
    }
    let mut bytes = vec![0; length as usize];
    from.read_exact(&mut bytes)?;
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
