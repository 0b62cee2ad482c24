//! Arrays and strings from C.

use std::ffi::{CStr, CString};
use std::slice;

use crate::kernel::spare;

use super::types::fmi2String;

/// A problem with an argument, in words for the log.
pub(super) type Wrong = String;

/// Maximum number of elements of an array. No component has as many variables, and it is better to
/// reject a wrong number from an importer than to read memory that is not its own.
const MOST: usize = 1 << 20;

/// Longest string accepted, in bytes.
const LONGEST: usize = 1 << 20;

/// Whether an array can be made from this.
#[inline(always)]
fn is_sound<T>(pointer: *const T, n: usize) -> bool {
    !pointer.is_null() && pointer.is_aligned() && n <= MOST
}

fn check<T>(name: &str, pointer: *const T, n: usize) -> Result<(), Wrong> {
    if is_sound(pointer, n) {
        return Ok(());
    }
    if pointer.is_null() {
        return Err(format!("{name} is NULL, but has {n} elements"));
    }
    if !pointer.is_aligned() {
        return Err(format!("{name} is not aligned for its type"));
    }
    Err(format!("{name} cannot have {n} elements; at most {MOST} are taken"))
}

/// [`array`] without an error message.
///
/// # Safety
/// As for [`array`].
#[inline(always)]
pub(super) unsafe fn plain_array<'a, T>(pointer: *const T, n: usize) -> Option<&'a [T]> {
    // SAFETY: not null, aligned, of possible size; readable as the caller guarantees.
    is_sound(pointer, n).then(|| unsafe { slice::from_raw_parts(pointer, n) })
}

/// [`array_mut`] without an error message.
///
/// # Safety
/// As for [`array_mut`].
#[inline(always)]
pub(super) unsafe fn plain_array_mut<'a, T>(pointer: *mut T, n: usize) -> Option<&'a mut [T]> {
    // SAFETY: not null, aligned, of possible size; writable and exclusive as the caller guarantees.
    is_sound(pointer, n).then(|| unsafe { slice::from_raw_parts_mut(pointer, n) })
}

/// An array to read; NULL is fine if it is empty.
///
/// # Safety
/// `pointer` is NULL or points to `n` readable elements that do not change for `'a`.
#[inline]
pub(super) unsafe fn array<'a, T>(
    name: &str,
    pointer: *const T,
    n: usize,
) -> Result<&'a [T], Wrong> {
    if n == 0 {
        return Ok(&[]);
    }
    check(name, pointer, n)?;
    // SAFETY: not null, aligned, of possible size; readable as the caller guarantees.
    Ok(unsafe { slice::from_raw_parts(pointer, n) })
}

/// An array to write; NULL is fine if it is empty.
///
/// # Safety
/// `pointer` is NULL or points to `n` initialized elements that nothing else uses for `'a`.
#[inline]
pub(super) unsafe fn array_mut<'a, T>(
    name: &str,
    pointer: *mut T,
    n: usize,
) -> Result<&'a mut [T], Wrong> {
    if n == 0 {
        return Ok(&mut []);
    }
    check(name, pointer, n)?;
    // SAFETY: not null, aligned, of possible size; writable and exclusive as the caller guarantees.
    Ok(unsafe { slice::from_raw_parts_mut(pointer, n) })
}

/// A single place to write.
///
/// # Safety
/// As for [`array_mut`] with one element.
pub(super) unsafe fn place<'a, T>(name: &str, pointer: *mut T) -> Result<&'a mut T, Wrong> {
    check(name, pointer, 1).map_err(|_| format!("{name} is NULL"))?;
    // SAFETY: not null and aligned; writable and exclusive as the caller guarantees.
    Ok(unsafe { &mut *pointer })
}

/// A string of at most [`LONGEST`] bytes; `None` for NULL.
///
/// # Safety
/// `pointer` is NULL or points to a NUL-terminated string that does not change for `'a`.
pub(super) unsafe fn text<'a>(name: &str, pointer: fmi2String) -> Result<Option<&'a CStr>, Wrong> {
    // SAFETY: not null; terminated as the caller guarantees.
    let text = (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) });
    match text.map_or(0, CStr::count_bytes) {
        ..=LONGEST => Ok(text),
        bytes => Err(format!("{name} has {bytes} bytes; at most {LONGEST} are taken")),
    }
}

/// Copies of strings, each read as by [`text`].
///
/// # Safety
/// As for [`text`], for each of them.
pub(super) unsafe fn copies(
    name: &str,
    pointers: &[fmi2String],
) -> Result<Vec<Option<CString>>, Wrong> {
    // They are copied once more when they are set.
    let mut bytes = 4 * size_of_val(pointers);
    for pointer in pointers {
        // SAFETY: as the caller guarantees.
        bytes += 4 * unsafe { text(name, *pointer) }?.map_or(0, CStr::count_bytes);
    }
    spare(bytes).map_err(|trouble| trouble.text)?;
    // SAFETY: as the caller guarantees.
    pointers.iter().map(|p| Ok(unsafe { text(name, *p) }?.map(CString::from))).collect()
}
