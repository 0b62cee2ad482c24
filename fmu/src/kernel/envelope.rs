//! Saved states as bytes: magic and version, length, the state, SHA-256 of everything before it.

use fmu_standard::Call;
use sha2::{Digest, Sha256};

use super::status::Trouble;

/// What serialized states begin with; the digit is the version of the format.
const MAGIC: &[u8; 8] = b"fmu-kit2";
/// Length of the magic and of the number of bytes that follow it.
const HEAD: usize = 16;
const CHECKSUM: usize = 32;

/// The bytes of a state in their envelope.
#[must_use]
pub fn seal(mut body: Vec<u8>) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend((body.len() as u64).to_le_bytes());
    bytes.append(&mut body);
    bytes.extend(Sha256::digest(&bytes));
    bytes
}

/// Copies a serialized state into a caller's memory.
///
/// # Errors
/// It does not have the reported size.
pub fn hand_out(bytes: &[u8], into: &mut [u8]) -> Result<(), Trouble> {
    if bytes.len() != into.len() {
        return Err(Trouble::error(format_args!(
            "size = {}, but {} said {}",
            into.len(),
            Call::SerializedFmuStateSize.name(),
            bytes.len()
        )));
    }
    into.copy_from_slice(bytes);
    Ok(())
}

/// The input of [`seal`], if nothing was altered.
///
/// # Errors
/// What is wrong with the bytes, as the end of a sentence that begins with them.
pub fn unseal(bytes: &[u8]) -> Result<&[u8], String> {
    let Some((head, rest)) = bytes.split_at_checked(HEAD) else {
        return Err("are too few for a state".to_owned());
    };
    let (magic, length) = head.split_at(MAGIC.len());
    if magic != MAGIC {
        return Err("are not a state of this version of fmu-kit".to_owned());
    }
    let length = length.iter().rev().fold(0, |n: u64, byte| n << 8 | u64::from(*byte));
    let Some((body, checksum)) = rest.split_last_chunk::<CHECKSUM>() else {
        return Err("are cut short".to_owned());
    };
    if body.len() as u64 != length {
        return Err(format!("hold {} bytes of state, not {length}", body.len()));
    }
    let digest = Sha256::new().chain_update(head).chain_update(body).finalize();
    if digest[..] != checksum[..] {
        return Err("were altered: their checksum does not fit".to_owned());
    }
    Ok(body)
}
