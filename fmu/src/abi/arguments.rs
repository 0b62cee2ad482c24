//! Arrays and texts that come from C.

use std::ffi::{CStr, CString};
use std::slice;

use crate::kernel::spare;

use super::types::fmi2String;

/// What is wrong with an argument, in words for the log.
pub(super) type Wrong = String;

/// Most elements of an array. Nothing here has as many variables, and an importer that passes a
/// wild number is better told than followed into memory that is not its own.
const MOST: usize = 1 << 20;

/// Longest text taken, in bytes.
const LONGEST: usize = 1 << 20;

/// Whether an array may be made of this.
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

/// [`array`] without words for what is wrong.
///
/// # Safety
/// As for [`array`].
#[inline(always)]
pub(super) unsafe fn plain_array<'a, T>(pointer: *const T, n: usize) -> Option<&'a [T]> {
    // SAFETY: not null, aligned, of possible size; readable by the caller's word.
    is_sound(pointer, n).then(|| unsafe { slice::from_raw_parts(pointer, n) })
}

/// [`array_mut`] without words for what is wrong.
///
/// # Safety
/// As for [`array_mut`].
#[inline(always)]
pub(super) unsafe fn plain_array_mut<'a, T>(pointer: *mut T, n: usize) -> Option<&'a mut [T]> {
    // SAFETY: not null, aligned, of possible size; writable and exclusive by the caller's word.
    is_sound(pointer, n).then(|| unsafe { slice::from_raw_parts_mut(pointer, n) })
}

/// An array to read; NULL is fine if it is empty.
///
/// # Safety
/// `pointer` is NULL or leads to `n` readable elements that stay as they are for `'a`.
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
    // SAFETY: not null, aligned, of possible size; readable by the caller's word.
    Ok(unsafe { slice::from_raw_parts(pointer, n) })
}

/// An array to write; NULL is fine if it is empty.
///
/// # Safety
/// `pointer` is NULL or leads to `n` initialized elements that nobody else uses for `'a`.
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
    // SAFETY: not null, aligned, of possible size; writable and exclusive by the caller's word.
    Ok(unsafe { slice::from_raw_parts_mut(pointer, n) })
}

/// A single place to write.
///
/// # Safety
/// As for [`array_mut`] with one element.
pub(super) unsafe fn place<'a, T>(name: &str, pointer: *mut T) -> Result<&'a mut T, Wrong> {
    check(name, pointer, 1).map_err(|_| format!("{name} is NULL"))?;
    // SAFETY: not null and aligned; writable and exclusive by the caller's word.
    Ok(unsafe { &mut *pointer })
}

/// A text of at most [`LONGEST`] bytes; `None` for NULL.
///
/// # Safety
/// `pointer` is NULL or leads to a text that ends with a NUL and stays as it is for `'a`.
pub(super) unsafe fn text<'a>(name: &str, pointer: fmi2String) -> Result<Option<&'a CStr>, Wrong> {
    // SAFETY: not null; terminated by the caller's word.
    let text = (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) });
    match text.map_or(0, CStr::count_bytes) {
        ..=LONGEST => Ok(text),
        bytes => Err(format!("{name} has {bytes} bytes; at most {LONGEST} are taken")),
    }
}

/// Copies of texts, each as [`text`] takes it.
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
        // SAFETY: by the caller's word.
        bytes += 4 * unsafe { text(name, *pointer) }?.map_or(0, CStr::count_bytes);
    }
    spare(bytes).map_err(|trouble| trouble.text)?;
    // SAFETY: by the caller's word.
    pointers.iter().map(|p| Ok(unsafe { text(name, *p) }?.map(CString::from))).collect()
}
