//! What a Parquet file claims about itself, checked before the library believes it: the library
//! requests the memory that a page claims to need, and builds the tree of columns by recursion.
//!
//! Footer and pages have headers in Thrift's compact protocol: structures of fields, each with its
//! type and the distance from the number of the field before it.

use std::io;

use super::fields::{self, Fields, Type};

/// Structures within structures.
const DEEPEST: usize = 8;
/// Most octets for which one octet of Snappy stands: 64 for a copy of three.
const EXPANDS: u64 = 22;
/// For pages of a few octets.
const ANYWAY: u64 = 1024;

/// Codes of types.
const LIST: u8 = 9;
const STRUCTURE: u8 = 12;

/// Numbers of fields.
const CHILDREN: i16 = 5;
const UNPACKED: i16 = 2;
const PACKED: i16 = 3;

/// Checks the footer of a file: all columns are directly in it.
pub fn check_footer(file: &[u8]) -> io::Result<()> {
    let (rest, length) = (file.len() >= 12)
        .then(|| file[..file.len() - 4].split_last_chunk::<4>())
        .flatten()
        .ok_or_else(|| io::Error::other("it is too short"))?;
    let length = u32::from_le_bytes(*length) as usize;
    let start = rest.len().checked_sub(length).ok_or_else(broken)?;
    let rest = &mut &rest[start..];
    structure(rest, fields::FILE, 0, &mut |_, _| ())
}

/// The first element is the file, the others are its columns.
fn schema(rest: &mut &[u8]) -> io::Result<()> {
    let count = list(rest, STRUCTURE)?;
    for element in 0..count {
        let mut children = 0;
        structure(rest, fields::SCHEMA_ELEMENT, 0, &mut |field, number| {
            if field == CHILDREN {
                children = number;
            }
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
        structure(&mut rest, fields::PAGE, 0, &mut |field, number| match field {
            UNPACKED => unpacked = u64::try_from(number).ok(),
            PACKED => packed = u64::try_from(number).ok(),
            _ => (),
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

/// Reads a structure with these fields, and perhaps others; `seen` gets its integers.
fn structure(
    rest: &mut &[u8],
    fields: Fields,
    depth: usize,
    seen: &mut dyn FnMut(i16, i64),
) -> io::Result<()> {
    if depth > DEEPEST {
        return Err(broken());
    }
    let mut number = 0_i16;
    loop {
        let head = byte(rest)?;
        if head & 15 == 0 {
            return Ok(());
        }
        number = match i16::from(head >> 4) {
            0 => i16::try_from(integer(rest)?).map_err(|_| broken())?,
            distance => number.checked_add(distance).ok_or_else(broken)?,
        };
        match fields.iter().find(|(known, _)| *known == number) {
            // In a field, a Boolean is its type.
            Some((_, Type::Boolean)) if matches!(head & 15, 1 | 2) => (),
            Some((_, kind)) if code(*kind) == head & 15 => {
                if let Some(integer) = value(rest, *kind, depth)? {
                    seen(number, integer);
                }
            }
            None if matches!(head & 15, 1 | 2) => (),
            None => skip_value(rest, head & 15, depth)?,
            Some(_) => return Err(broken()),
        }
    }
}

/// The code of a type. That of a Boolean, which is its value in a field, is for lists.
fn code(kind: Type) -> u8 {
    match kind {
        Type::Boolean => 2,
        Type::I8 => 3,
        Type::I16 => 4,
        Type::I32 => 5,
        Type::I64 => 6,
        Type::Double => 7,
        Type::Binary => 8,
        Type::List(_) | Type::Schema => LIST,
        Type::Structure(_) => STRUCTURE,
    }
}

/// Reads a value of a declared type; a number if it is an integer.
fn value(rest: &mut &[u8], kind: Type, depth: usize) -> io::Result<Option<i64>> {
    let within = |bits: u32, number: i64| {
        let fits = number >> (bits - 1) == number >> 63;
        fits.then_some(Some(number)).ok_or_else(broken)
    };
    match kind {
        Type::I16 => return within(16, integer(rest)?),
        Type::I32 => return within(32, integer(rest)?),
        Type::I64 => return integer(rest).map(Some),
        Type::Schema => schema(rest)?,
        Type::List(of) => {
            let count = list(rest, code(*of))?;
            (0..count).try_for_each(|_| value(rest, *of, depth).map(drop))?;
        }
        Type::Structure(fields) => structure(rest, fields, depth + 1, &mut |_, _| ())?,
        Type::Boolean | Type::I8 | Type::Double | Type::Binary => {
            skip_value(rest, code(kind), depth)?;
        }
    }
    Ok(None)
}

/// Skips a value of this type, as the library skips what it does not know.
fn skip_value(rest: &mut &[u8], kind: u8, depth: usize) -> io::Result<()> {
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
        LIST | 10 => {
            let (kind, count) = list_head(rest)?;
            (0..count).try_for_each(|_| skip_value(rest, kind, depth))
        }
        STRUCTURE => structure(rest, &[], depth + 1, &mut |_, _| ()),
        // Headers have no maps.
        _ => Err(broken()),
    }
}

/// The number of values in a list of this type.
fn list(rest: &mut &[u8], of: u8) -> io::Result<u64> {
    match list_head(rest)? {
        // Some programs give an empty list no type.
        (kind, count) if kind == of || (kind, count) == (0, 0) => Ok(count),
        _ => Err(broken()),
    }
}

/// Type and number of the values of a list.
fn list_head(rest: &mut &[u8]) -> io::Result<(u8, u64)> {
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
