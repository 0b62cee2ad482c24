//! The sizes that pages of a Parquet file claim for their unpacked content. The library requests
//! that memory before it looks at the content.
//!
//! A page has a header in Thrift's compact protocol: structures of fields, each with its type and
//! the distance from the number of the field before it. Field 2 is the size unpacked, field 3 the
//! size that follows.

use std::io;

/// Structures within structures.
const DEEPEST: usize = 8;

/// The largest size that a page among these bytes claims to have when it is unpacked.
pub(super) fn largest(bytes: &[u8]) -> io::Result<u64> {
    let (mut rest, mut largest) = (bytes, 0);
    while !rest.is_empty() {
        let (mut unpacked, mut packed) = (None, None);
        structure(&mut rest, 0, &mut |field, value| match field {
            2 => unpacked = u64::try_from(value).ok(),
            3 => packed = u64::try_from(value).ok(),
            _ => (),
        })?;
        let (unpacked, packed) = unpacked.zip(packed).ok_or_else(broken)?;
        largest = largest.max(unpacked);
        skip(&mut rest, packed)?;
    }
    Ok(largest)
}

fn broken() -> io::Error {
    io::Error::other("the header of a page cannot be read")
}

/// Reads a structure, and passes on the integers directly in it with the numbers of their fields.
fn structure(rest: &mut &[u8], depth: usize, number: &mut dyn FnMut(i64, i64)) -> io::Result<()> {
    let mut field = 0_i64;
    loop {
        let head = byte(rest)?;
        if head == 0 {
            return Ok(());
        }
        field = match head >> 4 {
            0 => integer(rest)?,
            distance => field.saturating_add(i64::from(distance)),
        };
        match head & 15 {
            // In a field, a Boolean is its type.
            1 | 2 => (),
            4..=6 => number(field, integer(rest)?),
            kind => value(rest, kind, depth)?,
        }
    }
}

/// Skips a value of this type.
fn value(rest: &mut &[u8], kind: u8, depth: usize) -> io::Result<()> {
    match kind {
        1..=3 => byte(rest).map(drop),
        4..=6 => integer(rest).map(drop),
        7 => skip(rest, 8),
        8 => {
            let length = unsigned(rest)?;
            skip(rest, length)
        }
        9 | 10 => {
            let head = byte(rest)?;
            let count = if head >> 4 == 15 { unsigned(rest)? } else { u64::from(head >> 4) };
            // Each has at least one byte, so this ends with the bytes.
            (0..count).try_for_each(|_| value(rest, head & 15, depth))
        }
        12 if depth < DEEPEST => structure(rest, depth + 1, &mut |_, _| ()),
        // Headers of pages have no maps.
        _ => Err(broken()),
    }
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
