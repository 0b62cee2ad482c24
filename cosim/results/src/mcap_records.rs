//! The records of an uncompressed MCAP file, as far as they are complete. The file is untrusted, so
//! no length is accepted before that much data is there.
//!
//! A record is an opcode, its length and its content (<https://mcap.dev/spec>); a chunk contains
//! other records.

pub(super) const MAGIC: &[u8] = b"\x89MCAP0\r\n";
const FOOTER: u8 = 2;
const CHANNEL: u8 = 4;
const MESSAGE: u8 = 5;
const CHUNK: u8 = 6;

/// The records that results consist of.
pub(super) enum Record<'a> {
    Channel { id: u16, topic: &'a str, metadata: Vec<(&'a str, &'a str)> },
    Message { channel: u16, log_time: u64, data: &'a [u8] },
}

/// Shows what follows the magic bytes to `see`, up to the footer or to where the file is truncated;
/// whether there is a footer.
pub(super) fn each<'a>(
    bytes: &'a [u8],
    see: &mut dyn FnMut(Record<'a>) -> Result<(), String>,
) -> Result<bool, String> {
    walk(bytes, true, see)
}

fn walk<'a>(
    bytes: &'a [u8],
    chunks: bool,
    see: &mut dyn FnMut(Record<'a>) -> Result<(), String>,
) -> Result<bool, String> {
    let mut left = Bytes(bytes);
    while let (Some(&[opcode]), Some(length)) = (left.array::<1>(), left.u64()) {
        let there = usize::try_from(length).unwrap_or(usize::MAX).min(left.0.len());
        let whole = there as u64 == length;
        let content = Bytes(left.take(there).unwrap_or_default());
        match opcode {
            FOOTER => return Ok(true),
            // An incomplete chunk contains an incomplete record. Chunks are not nested.
            CHUNK if chunks => drop(walk(chunk(content, whole)?, false, see)?),
            CHANNEL if whole => see(channel(content).ok_or("a channel is damaged")?)?,
            MESSAGE if whole => see(message(content).ok_or("a message is damaged")?)?,
            _ => (),
        }
    }
    Ok(false)
}

/// The records of a chunk after its times, size, checksum (0: none) and compression. The checksum
/// of an incomplete chunk covers more than is left.
fn chunk(mut content: Bytes<'_>, whole: bool) -> Result<&[u8], String> {
    let (Some(_), Some(checksum), Some(compression), Some(length)) =
        (content.take(24), content.u32(), content.text(), content.u64())
    else {
        return Ok(&[]);
    };
    if !compression.is_empty() {
        return Err(format!(
            "its chunks are compressed ({compression}), which is not supported: the tool `mcap \
             decompress` writes them without compression"
        ));
    }
    let length = usize::try_from(length).unwrap_or(usize::MAX).min(content.0.len());
    let records = &content.0[..length];
    if whole && checksum != 0 && crc32fast::hash(records) as usize != checksum {
        return Err("a chunk is damaged: its checksum is wrong".to_owned());
    }
    Ok(records)
}

fn channel(mut content: Bytes<'_>) -> Option<Record<'_>> {
    let (id, _schema) = (content.u16()?, content.u16()?);
    let (topic, _encoding) = (content.text()?, content.text()?);
    let length = content.u32()?;
    let mut entries = Bytes(content.take(length)?);
    let mut metadata = Vec::new();
    while !entries.0.is_empty() {
        metadata.push((entries.text()?, entries.text()?));
    }
    Some(Record::Channel { id, topic, metadata })
}

fn message(mut content: Bytes<'_>) -> Option<Record<'_>> {
    let channel = content.u16()?;
    let _sequence = content.u32()?;
    let (log_time, _publish_time) = (content.u64()?, content.u64()?);
    Some(Record::Message { channel, log_time, data: content.0 })
}

/// The part that has not been read yet.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<&'a [u8; N]> {
        let (taken, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(taken)
    }

    fn u16(&mut self) -> Option<u16> {
        self.array().copied().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Option<usize> {
        self.array().copied().map(|bytes| u32::from_le_bytes(bytes) as usize)
    }

    fn u64(&mut self) -> Option<u64> {
        self.array().copied().map(u64::from_le_bytes)
    }

    fn text(&mut self) -> Option<&'a str> {
        let length = self.u32()?;
        std::str::from_utf8(self.take(length)?).ok()
    }
}
