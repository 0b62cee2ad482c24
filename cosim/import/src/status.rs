//! `fmi2Status` as FMUs return it.

use fmu_standard::Status;

/// `fmi2Status` as on the C side; an `i32`, because an FMU may return anything.
pub(crate) type RawStatus = i32;

pub(super) const OK: RawStatus = Status::Ok as RawStatus;
pub(super) const WARNING: RawStatus = Status::Warning as RawStatus;
pub(super) const DISCARD: RawStatus = Status::Discard as RawStatus;
/// `fmi2Error`.
pub const ERROR: RawStatus = Status::Error as RawStatus;
/// `fmi2Fatal`.
pub const FATAL: RawStatus = Status::Fatal as RawStatus;
pub(super) const PENDING: RawStatus = Status::Pending as RawStatus;
/// Not part of FMI: returned by the replacement for a function that the library does not have.
pub(super) const MISSING: RawStatus = i32::MIN;

/// FMI's name of a status.
pub(super) fn name(status: RawStatus) -> &'static str {
    match (status, Status::from_number(status)) {
        (_, Some(status)) => status.name(),
        (MISSING, None) => "the library has no such function",
        (_, None) => "a status that FMI 2.0 does not have",
    }
}
