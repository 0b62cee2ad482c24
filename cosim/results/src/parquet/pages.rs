//! What a Parquet file claims about itself, checked before the library believes it: the library
//! requests the memory that a page claims to need, and builds the tree of columns by recursion.
//!
//! Footer and pages have headers in Thrift's compact protocol: structures of fields, each with its
//! type and the distance from the number of the field before it.

use std::io;

/// Structures within structures.
const DEEPEST: usize = 8;
/// Most octets for which one octet of Snappy stands: 64 for a copy of three.
const EXPANDS: u64 = 22;
/// For pages of a few octets.
const ANYWAY: u64 = 1024;

/// Numbers of fields.
const SCHEMA: i64 = 2;
const CHILDREN: i64 = 5;
const UNPACKED: i64 = 2;
const PACKED: i64 = 3;

/// Types.
const LIST: u8 = 9;
const STRUCTURE: u8 = 12;

/// Checks the footer of a file: all columns are directly in it.
pub fn check_footer(file: &[u8]) -> io::Result<()> {
    let (rest, length) = (file.len() >= 12)
        .then(|| file[..file.len() - 4].split_last_chunk::<4>())
        .flatten()
        .ok_or_else(|| io::Error::other("it is too short"))?;
    let length = u32::from_le_bytes(*length) as usize;
    let start = rest.len().checked_sub(length).ok_or_else(broken)?;
    let rest = &mut &rest[start..];
    structure(rest, |field, kind, rest| match (field, kind) {
        (SCHEMA, LIST) => schema(rest),
        (SCHEMA, _) => Err(broken()),
        _ => value(rest, kind, 0),
    })
}

/// The first element is the file, the others are its columns.
fn schema(rest: &mut &[u8]) -> io::Result<()> {
    let (kind, count) = list(rest)?;
    if kind != STRUCTURE {
        return Err(broken());
    }
    for element in 0..count {
        let mut children = 0;
        structure(rest, |field, kind, rest| match (field, kind) {
            (CHILDREN, 5) => integer(rest).map(|number| children = number),
            (CHILDREN, _) => Err(broken()),
            _ => value(rest, kind, 0),
        })?;
        let wanted = if element == 0 { count as i64 - 1 } else { 0 };
        if children != wanted {
            return Err(io::Error::other("it holds columns within columns"));
        }
    }
    Ok(())
}

/// Checks the pages among these bytes; the largest size that one has when it is unpacked.
pub(super) fn largest(bytes: &[u8]) -> io::Result<u64> {
    let (mut rest, mut largest) = (bytes, 0);
    while !rest.is_empty() {
        let (mut unpacked, mut packed) = (None, None);
        structure(&mut rest, |field, kind, rest| match (field, kind) {
            (UNPACKED, 5) => integer(rest).map(|number| unpacked = u64::try_from(number).ok()),
            (PACKED, 5) => integer(rest).map(|number| packed = u64::try_from(number).ok()),
            (UNPACKED | PACKED, _) => Err(broken()),
            _ => value(rest, kind, 0),
        })?;
        let (unpacked, packed) = unpacked.zip(packed).ok_or_else(broken)?;
        if unpacked > packed.saturating_mul(EXPANDS).saturating_add(ANYWAY) {
            let what = format!("a page of {packed} bytes claims to unpack to {unpacked}");
            return Err(io::Error::other(what));
        }
        largest = largest.max(unpacked);
        skip(&mut rest, packed)?;
    }
    Ok(largest)
}

fn broken() -> io::Error {
    io::Error::other("a header in it cannot be read")
}

/// Reads the fields of a structure: number and type of each; `field` reads its value.
fn structure<'b>(
    rest: &mut &'b [u8],
    mut field: impl FnMut(i64, u8, &mut &'b [u8]) -> io::Result<()>,
) -> io::Result<()> {
    let mut number = 0_i64;
    loop {
        let head = byte(rest)?;
        if head == 0 {
            return Ok(());
        }
        number = match head >> 4 {
            0 => integer(rest)?,
            distance => number.saturating_add(i64::from(distance)),
        };
        // In a field, a Boolean is its type.
        if !matches!(head & 15, 1 | 2) {
            field(number, head & 15, rest)?;
        }
    }
}

/// Skips a value of this type.
fn value(rest: &mut &[u8], kind: u8, depth: usize) -> io::Result<()> {
    match kind {
        3 => byte(rest).map(drop),
        4..=6 => integer(rest).map(drop),
        7 => skip(rest, 8),
        8 => {
            let length = unsigned(rest)?;
            skip(rest, length)
        }
        // Each value has at least one byte, so this ends with the bytes. There are no lists of
        // Booleans in headers; the library would skip any number of them without reading a byte.
        9 | 10 => {
            let (kind, count) = list(rest)?;
            (0..count).try_for_each(|_| value(rest, kind, depth))
        }
        STRUCTURE if depth < DEEPEST => {
            structure(rest, |_, kind, rest| value(rest, kind, depth + 1))
        }
        // Headers have no maps.
        _ => Err(broken()),
    }
}

/// Type and number of the values of a list.
fn list(rest: &mut &[u8]) -> io::Result<(u8, u64)> {
    let head = byte(rest)?;
    let count = if head >> 4 == 15 { unsigned(rest)? } else { u64::from(head >> 4) };
    Ok((head & 15, count))
}

fn byte(rest: &mut &[u8]) -> io::Result<u8> {
    let (first, after) = rest.split_first().ok_or_else(broken)?;
    *rest = after;
    Ok(*first)
}

fn skip(rest: &mut &[u8], count: u64) -> io::Result<()> {
    let count = usize::try_from(count).map_err(|_| broken())?;
    *rest = rest.get(count..).ok_or_else(broken)?;
    Ok(())
}

fn unsigned(rest: &mut &[u8]) -> io::Result<u64> {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let next = byte(rest)?;
        value |= u64::from(next & 127) << shift;
        if next < 128 {
            return Ok(value);
        }
    }
    Err(broken())
}

/// Zigzag: small numbers of either sign are short.
fn integer(rest: &mut &[u8]) -> io::Result<i64> {
    let value = unsigned(rest)?;
    Ok((value >> 1) as i64 ^ -((value & 1) as i64))
}
