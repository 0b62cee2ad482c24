//! Whether there is memory for what comes next.
//!
//! Rust ends the process where an allocation fails, and no host wants that of an FMU. So what
//! allocates much asks first for as much as it will need at most, in one piece, and gives it back.
//! Nothing keeps another thread from taking it in between; small texts for the log do not ask.

use super::status::Trouble;

/// Bytes of memory for a serialized byte, at most: Postcard makes one of a small integer of eight.
pub const SPREAD: usize = 8;

/// Checks that `bytes` can be had.
///
/// # Errors
/// They cannot.
pub fn spare(bytes: usize) -> Result<(), Trouble> {
    let mut place = Vec::<u8>::new();
    let asked = place.try_reserve_exact(bytes);
    // What nobody looks at, the compiler need not ask for.
    std::hint::black_box(&mut place);
    asked.map_err(|_| {
        Trouble::error(format_args!(
            "out of memory: {bytes} bytes cannot be had; free instances or states, or raise the \
             limit of the process"
        ))
    })
}
