//! Messages between the coordinator and a host, as bytes.
//!
//! A message is a fixed little-endian header and a body of raw numbers in the order of tables that
//! both sides derive from the same plan; names and types are never sent in a step. Raw bits
//! preserve every NaN and the sign of zero. The header carries a digest of the plan, so two sides
//! with different tables notice it before any number is read.

use sha2::{Digest, Sha256};

use cosim_base::time::Time;
use cosim_import::Scalar;

/// Version of the protocol; both sides must have the same.
pub(crate) const VERSION: u8 = 1;
const MAGIC: u8 = 0xC5;
/// Size of a header, in octets.
pub(crate) const HEADER: usize = 32;

/// What a message is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Kind {
    /// Make these components: the body is a `Setup`.
    Setup = 1,
    /// Make one instance that is driven call by call: the body is a `SingleSetup`.
    Single = 2,
    /// Enter initialization mode.
    Enter = 3,
    /// Pass values on once, in initialization mode.
    Exchange = 4,
    /// Leave initialization mode.
    Exit = 5,
    /// Make the steps of one part that end at the time of the message.
    Step = 6,
    /// Read the recorded values.
    Sample = 7,
    /// Return the current state.
    Save = 8,
    /// Change a variable from outside.
    Change = 9,
    /// Return the messages of the components and end.
    Finish = 10,
    /// Make these calls of the single instance.
    Calls = 11,
    /// Success: the answer to any of these.
    Done = 64,
    /// Failure: the body is a `Failure`.
    Failed = 65,
}

/// Values of the recorded variables follow the outputs.
pub(crate) const RECORD: u8 = 1;
/// The values that are held from the end of the last instant come first in the body.
pub(crate) const OPENING: u8 = 2;
/// Only the blob at the start of the body is the same whenever the command is repeated.
pub(crate) const APART: u8 = 4;

/// The run ends with this step: steps that would end later end now.
pub(crate) const LAST: u8 = 8;

/// The header of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Header {
    /// Its kind.
    pub kind: Kind,
    /// A combination of [`RECORD`], [`OPENING`], [`APART`] and [`LAST`].
    pub flags: u8,
    /// The incarnation of the group that it is for; messages of earlier incarnations are ignored.
    pub generation: u32,
    /// Counts the commands to a group from 1; an answer has the number of its command.
    pub sequence: u64,
    /// Digest of the plan.
    pub tables: u64,
    /// The instant that is being computed.
    pub time: Time,
}

/// Why bytes are not a valid message.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Malformed {
    /// Shorter than its kind requires.
    #[error("the message is truncated: {has} octets where {needs} are needed")]
    Cut {
        /// Octets present.
        has: usize,
        /// Octets needed.
        needs: usize,
    },
    /// Longer than its kind requires.
    #[error("{0} octets too many")]
    Surplus(usize),
    /// Not a message of cosim.
    #[error("it does not begin like a message of cosim")]
    Foreign,
    /// Of another version of the protocol.
    #[error("it is of version {0} of the protocol, this cosim speaks version {VERSION}")]
    Version(u8),
    /// Of an unknown kind.
    #[error("it is of the unknown kind {0}")]
    Unknown(u8),
    /// Its checksum does not match its body.
    #[error("its checksum is wrong: it was damaged in transit")]
    Damaged,
    /// A structured body that cannot be decoded.
    #[error("its body cannot be read: {0}")]
    Body(String),
}

impl Kind {
    fn from_octet(octet: u8) -> Option<Self> {
        use Kind::*;
        let commands = [Setup, Single, Enter, Exchange, Exit, Step, Sample, Save, Change, Finish];
        let all = commands.into_iter().chain([Calls, Done, Failed]);
        all.into_iter().find(|kind| *kind as u8 == octet)
    }
}

impl Header {
    /// A message with this header and an empty body.
    pub(crate) fn message(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(512);
        bytes.extend([MAGIC, VERSION, self.kind as u8, self.flags]);
        bytes.extend(self.generation.to_le_bytes());
        bytes.extend(self.sequence.to_le_bytes());
        bytes.extend(self.tables.to_le_bytes());
        bytes.extend(self.time.ns().to_le_bytes());
        bytes
    }

    /// The header of a message, and its body.
    pub(crate) fn read(bytes: &[u8]) -> Result<(Self, Body<'_>), Malformed> {
        // A foreign message may be short as well: its first octets say more than its length.
        match bytes {
            [MAGIC, VERSION, ..] => {}
            [MAGIC, version, ..] => return Err(Malformed::Version(*version)),
            [] | [MAGIC] => return Err(Malformed::Cut { has: bytes.len(), needs: HEADER }),
            _ => return Err(Malformed::Foreign),
        }
        let mut body = Body(bytes.get(2..).unwrap_or_default());
        if bytes.len() < HEADER {
            return Err(Malformed::Cut { has: bytes.len(), needs: HEADER });
        }
        let [kind, flags] = body.take()?;
        let header = Header {
            kind: Kind::from_octet(kind).ok_or(Malformed::Unknown(kind))?,
            flags,
            generation: u32::from_le_bytes(body.take()?),
            sequence: u64::from_le_bytes(body.take()?),
            tables: u64::from_le_bytes(body.take()?),
            time: Time::from_ns(i64::from_le_bytes(body.take()?)),
        };
        Ok((header, body))
    }

    /// Whether a flag is set.
    pub(crate) fn has(&self, flag: u8) -> bool {
        self.flags & flag != 0
    }
}

/// The part of a body that has not been read yet.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Body<'a>(&'a [u8]);

impl<'a> Body<'a> {
    /// The body of a message whose header has already been read.
    pub(crate) fn after_header(message: &'a [u8]) -> Self {
        Self(message.get(HEADER..).unwrap_or_default())
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], Malformed> {
        let cut = Malformed::Cut { has: self.0.len(), needs: N };
        let (first, rest) = self.0.split_first_chunk::<N>().ok_or(cut)?;
        self.0 = rest;
        Ok(*first)
    }

    /// A count or position.
    pub(crate) fn number(&mut self) -> Result<u32, Malformed> {
        Ok(u32::from_le_bytes(self.take()?))
    }

    /// Reads one value per slot into its place in `values`; `texts` are the slots of Strings.
    pub(crate) fn values(
        &mut self,
        slots: impl IntoIterator<Item = usize>,
        texts: &[usize],
        values: &mut [Scalar],
    ) -> Result<(), Malformed> {
        for slot in slots {
            values[slot] = match texts.contains(&slot) {
                true => Scalar::text(self.text()?),
                false => Scalar::from(self.take()?),
            };
        }
        Ok(())
    }

    fn text(&mut self) -> Result<&'a str, Malformed> {
        std::str::from_utf8(self.blob()?).map_err(|e| Malformed::Body(e.to_string()))
    }

    /// A length followed by that many octets.
    pub(crate) fn blob(&mut self) -> Result<&'a [u8], Malformed> {
        let length = u64::from_le_bytes(self.take()?);
        let cut = Malformed::Cut { has: self.0.len(), needs: usize::MAX };
        let length = usize::try_from(length).map_err(|_| cut.clone())?;
        let (blob, rest) = self
            .0
            .split_at_checked(length)
            .ok_or(Malformed::Cut { has: self.0.len(), needs: length })?;
        self.0 = rest;
        Ok(blob)
    }

    /// The body after its SHA-256, if the checksum matches.
    pub(crate) fn whole(mut self) -> Result<Self, Malformed> {
        let sum: [u8; 32] = self.take()?;
        match Sha256::digest(self.0)[..] == sum {
            true => Ok(self),
            false => Err(Malformed::Damaged),
        }
    }

    /// The rest of the body.
    pub(crate) fn rest(self) -> &'a [u8] {
        self.0
    }

    /// The rest of the body as one structure.
    pub(crate) fn structure<T: serde::de::DeserializeOwned>(self) -> Result<T, Malformed> {
        let (value, rest) =
            postcard::take_from_bytes(self.0).map_err(|e| Malformed::Body(e.to_string()))?;
        Body(rest).end().map(|()| value)
    }

    /// Fails if anything is left.
    pub(crate) fn end(self) -> Result<(), Malformed> {
        if self.0.is_empty() { Ok(()) } else { Err(Malformed::Surplus(self.0.len())) }
    }
}

/// Appends the values of these slots. Strings, in the slots `texts`, are sent as such: their scalars
/// are valid in one process only.
pub(crate) fn put_values(
    message: &mut Vec<u8>,
    slots: impl IntoIterator<Item = usize>,
    texts: &[usize],
    values: &[Scalar],
) {
    for slot in slots {
        match texts.contains(&slot) {
            true => put_blob(message, values[slot].as_text().as_bytes()),
            false => message.extend(<[u8; 8]>::from(values[slot])),
        }
    }
}

/// Appends a length and that many octets.
pub(crate) fn put_blob(message: &mut Vec<u8>, blob: &[u8]) {
    message.extend((blob.len() as u64).to_le_bytes());
    message.extend(blob);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header() -> Header {
        Header {
            kind: Kind::Step,
            flags: RECORD | OPENING,
            generation: 0x0102_0304,
            sequence: 0x1122_3344_5566_7788,
            tables: 0xA0A1_A2A3_A4A5_A6A7,
            time: Time::from_ns(-2),
        }
    }

    /// The bytes that other versions and other languages must agree with.
    #[test]
    fn a_header_has_these_bytes() {
        let expected = [
            0xC5, 1, 6, 3, 4, 3, 2, 1, 0x88, 0x77, 0x66, 0x55, 0x44, 0x33, 0x22, 0x11, 0xA7, 0xA6,
            0xA5, 0xA4, 0xA3, 0xA2, 0xA1, 0xA0, 0xFE, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF,
        ];
        assert_eq!(header().message(), expected);
        assert_eq!(Header::read(&expected).unwrap().0, header());
    }

    #[test]
    fn values_keep_their_bits() {
        let odd = [Scalar::real(-0.0), Scalar::integer(i64::MAX - 1), Scalar::boolean(true)];
        let odd = [odd[0], Scalar::real(f64::from_bits(0x7FF8_0000_DEAD_BEEF)), odd[1], odd[2]];
        let mut message = header().message();
        put_values(&mut message, [3, 0, 1, 2], &[], &odd);
        let mut read = [Scalar::default(); 4];
        let (_, mut body) = Header::read(&message).unwrap();
        body.values([3, 0, 1, 2], &[], &mut read).unwrap();
        assert_eq!(read, odd);
        assert!(body.end().is_ok());
    }

    #[test]
    fn strings_are_sent_as_such() {
        let values = [Scalar::real(1.5), Scalar::text("süd"), Scalar::real(2.5)];
        let mut message = header().message();
        put_values(&mut message, 0..3, &[1], &values);
        assert!(message.windows(4).any(|part| part == "süd".as_bytes()));
        let mut read = [Scalar::default(); 3];
        let (_, mut body) = Header::read(&message).unwrap();
        body.values(0..3, &[1], &mut read).unwrap();
        assert_eq!(read, values);
        assert!(body.end().is_ok());
        // Not UTF-8.
        let place = message.len() - 9;
        message[place] = 0xFF;
        let (_, mut body) = Header::read(&message).unwrap();
        assert!(matches!(body.values(0..3, &[1], &mut read), Err(Malformed::Body(_))));
    }

    #[test]
    fn every_cut_is_noticed() {
        let mut message = header().message();
        message.extend(7_u32.to_le_bytes());
        put_values(&mut message, [0], &[], &[Scalar::real(1.5)]);
        put_blob(&mut message, b"state");
        let read = |bytes: &[u8]| -> Result<(), Malformed> {
            let (_, mut body) = Header::read(bytes)?;
            body.number()?;
            body.values([0], &[], &mut [Scalar::default()])?;
            body.blob()?;
            body.end()
        };
        assert_eq!(read(&message), Ok(()));
        for length in 0..message.len() {
            assert!(matches!(read(&message[..length]), Err(Malformed::Cut { .. })), "{length}");
        }
        message.push(0);
        assert_eq!(read(&message), Err(Malformed::Surplus(1)));
    }

    #[test]
    fn what_is_not_ours_is_named() {
        let mut message = header().message();
        message[1] = 9;
        assert_eq!(Header::read(&message).unwrap_err(), Malformed::Version(9));
        message[1] = VERSION;
        message[2] = 63;
        assert_eq!(Header::read(&message).unwrap_err(), Malformed::Unknown(63));
        assert_eq!(Header::read(b"GET / HTTP/1.1").unwrap_err(), Malformed::Foreign);
    }
}
