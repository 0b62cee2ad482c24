//! Whether there is memory for the next operation.
//!
//! Rust ends the process if an allocation fails, which no host wants from an FMU. So operations
//! that allocate a lot first request as much as they will need at most, in one piece, and return
//! it. Another thread may still take it in between; short log messages are not checked this way.

use super::status::Trouble;

/// Maximum bytes of memory per serialized byte: Postcard encodes a small integer of eight bytes in
/// one.
pub const SPREAD: usize = 8;

/// Checks that `bytes` can be allocated.
///
/// # Errors
/// They cannot.
pub fn spare(bytes: usize) -> Result<(), Trouble> {
    let mut place = Vec::<u8>::new();
    let asked = place.try_reserve_exact(bytes);
    // The compiler may omit an allocation that no one looks at.
    std::hint::black_box(&mut place);
    asked.map_err(|_| {
        Trouble::error(format_args!(
            "out of memory: {bytes} bytes cannot be had; free instances or states, or raise the \
             limit of the process"
        ))
    })
}
