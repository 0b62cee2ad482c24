//! ZIP archives that no tool would write: every field can be wrong.

/// One entry, stored without compression.
#[derive(Clone)]
pub(crate) struct Entry {
    pub name: Vec<u8>,
    pub content: Vec<u8>,
    /// Unix mode with the file type.
    pub mode: u32,
    pub flags: u16,
    pub method: u16,
    /// The declared value in the directory; the true one if `None`.
    pub size: Option<u32>,
    pub packed: Option<u32>,
    pub crc: Option<u32>,
    /// Extra field of the directory.
    pub extra: Vec<u8>,
    /// The content is that of the previous entry: the local header is not written again.
    pub shared: bool,
}

impl Entry {
    pub(crate) fn new(name: impl AsRef<[u8]>, content: &[u8]) -> Self {
        Self {
            name: name.as_ref().to_vec(),
            content: content.to_vec(),
            mode: 0o100_644,
            flags: 0x800,
            method: 0,
            size: None,
            packed: None,
            crc: None,
            extra: Vec::new(),
            shared: false,
        }
    }
}

/// CRC-32 of ISO 3309.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| (c >> 1) ^ (0xedb8_8320 & (c & 1).wrapping_neg()))
    })
}

/// The end of an archive: the declared counts and offsets.
#[derive(Default)]
pub(crate) struct End {
    pub disk: u16,
    pub entries: Option<u16>,
}

pub(crate) fn archive(entries: &[Entry]) -> Vec<u8> {
    archive_with(entries, End::default())
}

pub(crate) fn archive_with(entries: &[Entry], end: End) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut directory = Vec::new();
    let mut offset = 0_u32;
    for entry in entries {
        let length = entry.content.len() as u32;
        let crc = entry.crc.unwrap_or_else(|| crc32(&entry.content));
        let (size, packed) = (entry.size.unwrap_or(length), entry.packed.unwrap_or(length));
        let mut common = Vec::new();
        for word in [20, entry.flags, entry.method, 0, 0x21] {
            common.extend(u16::to_le_bytes(word));
        }
        for word in [crc, packed, size] {
            common.extend(u32::to_le_bytes(word));
        }
        common.extend((entry.name.len() as u16).to_le_bytes());
        if !entry.shared {
            offset = bytes.len() as u32;
            bytes.extend(b"PK\x03\x04");
            bytes.extend(&common);
            bytes.extend([0, 0]);
            bytes.extend(&entry.name);
            bytes.extend(&entry.content);
        }
        directory.extend(b"PK\x01\x02");
        // Made by Unix: the upper half of the attributes is a mode.
        directory.extend([20, 3]);
        directory.extend(&common);
        directory.extend((entry.extra.len() as u16).to_le_bytes());
        directory.extend([0; 6]);
        directory.extend((entry.mode << 16).to_le_bytes());
        directory.extend(offset.to_le_bytes());
        directory.extend(&entry.name);
        directory.extend(&entry.extra);
    }
    let count = end.entries.unwrap_or(entries.len() as u16);
    let start = bytes.len() as u32;
    bytes.extend(&directory);
    bytes.extend(b"PK\x05\x06");
    for word in [end.disk, 0, count, count] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend((directory.len() as u32).to_le_bytes());
    bytes.extend(start.to_le_bytes());
    bytes.extend([0, 0]);
    bytes
}
