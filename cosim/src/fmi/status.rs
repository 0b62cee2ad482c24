//! `fmi2Status`.

/// `fmi2Status` as the C side has it; an `i32`, for an FMU may return anything.
pub(super) type RawStatus = i32;

pub(super) const OK: RawStatus = 0;
pub(super) const WARNING: RawStatus = 1;
pub(super) const DISCARD: RawStatus = 2;
pub(super) const FATAL: RawStatus = 4;

/// FMI's name of a status.
pub(super) fn name(status: RawStatus) -> &'static str {
    match status {
        OK => "OK",
        WARNING => "Warning",
        DISCARD => "Discard",
        3 => "Error",
        FATAL => "Fatal",
        5 => "Pending",
        _ => "a status that FMI 2.0 does not have",
    }
}
