//! `fmi2Status`.

/// `fmi2Status` as on the C side; an `i32`, because an FMU may return anything.
pub(crate) type RawStatus = i32;

pub(super) const OK: RawStatus = 0;
pub(super) const WARNING: RawStatus = 1;
pub(super) const DISCARD: RawStatus = 2;
pub(crate) const ERROR: RawStatus = 3;
pub(crate) const FATAL: RawStatus = 4;
pub(super) const PENDING: RawStatus = 5;
/// Not part of FMI: returned by the replacement for a function that the library does not have.
pub(super) const MISSING: RawStatus = i32::MIN;

/// FMI's name of a status.
pub(super) fn name(status: RawStatus) -> &'static str {
    match status {
        OK => "OK",
        WARNING => "Warning",
        DISCARD => "Discard",
        ERROR => "Error",
        FATAL => "Fatal",
        PENDING => "Pending",
        MISSING => "the library has no such function",
        _ => "a status that FMI 2.0 does not have",
    }
}
