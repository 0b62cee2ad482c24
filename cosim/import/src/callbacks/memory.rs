//! Reads memory at an address from an FMU without trusting it.
//!
//! `process_vm_readv` copies from this process into itself and returns an error where a plain read
//! would be a segmentation fault: a message that is used as a format (`"50% solved"`) makes
//! `printf` look for strings at arbitrary addresses.

/// The size of the smallest page: a read that ends at its boundary never fails because of the next
/// page.
#[cfg(target_os = "linux")]
const PAGE: usize = 4096;

/// The bytes at `address` up to NUL or at most `limit`; `None` if nothing can be read.
#[cfg(target_os = "linux")]
pub(super) fn string(address: usize, limit: usize) -> Option<Vec<u8>> {
    let mut found = Vec::new();
    while found.len() < limit {
        let place = address.checked_add(found.len())?;
        let mut piece = [0_u8; PAGE];
        let wanted = (PAGE - place % PAGE).min(limit - found.len());
        let read = copy(place, &mut piece[..wanted])?;
        match piece[..read].iter().position(|&b| b == 0) {
            Some(end) => {
                found.extend_from_slice(&piece[..end]);
                break;
            }
            None => found.extend_from_slice(&piece[..read]),
        }
    }
    Some(found)
}

/// On a system without such a call the FMU is trusted.
#[cfg(not(target_os = "linux"))]
pub(super) fn string(address: usize, limit: usize) -> Option<Vec<u8>> {
    let pointer = std::ptr::with_exposed_provenance::<u8>(address);
    // SAFETY: the FMU promised a string of at least that length or with a NUL.
    let byte = |k| unsafe { pointer.add(k).read() };
    Some((0..limit).map(byte).take_while(|&b| b != 0).collect())
}

#[cfg(target_os = "linux")]
fn copy(from: usize, to: &mut [u8]) -> Option<usize> {
    let pointer = std::ptr::with_exposed_provenance_mut(from);
    let local = libc::iovec { iov_base: to.as_mut_ptr().cast(), iov_len: to.len() };
    let remote = libc::iovec { iov_base: pointer, iov_len: to.len() };
    // SAFETY: `local` is `to`; the system checks `remote`.
    let read =
        unsafe { libc::process_vm_readv(std::process::id() as i32, &local, 1, &remote, 1, 0) };
    match usize::try_from(read) {
        Ok(0) => None,
        Ok(read) => Some(read),
        Err(_) if forbidden() => {
            // SAFETY: a sandbox forbids the check; the FMU promised a readable string, and a page
            // is either entirely readable or not at all.
            unsafe { std::ptr::copy_nonoverlapping(pointer.cast(), to.as_mut_ptr(), to.len()) };
            Some(to.len())
        }
        Err(_) => None,
    }
}

/// The last call failed because it is not permitted, not because of the address.
#[cfg(target_os = "linux")]
fn forbidden() -> bool {
    let error = std::io::Error::last_os_error().raw_os_error();
    matches!(error, Some(libc::EPERM | libc::ENOSYS))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_there() {
        let text = c"tank";
        assert_eq!(string(text.as_ptr().addr(), 100).unwrap(), b"tank");
        assert_eq!(string(text.as_ptr().addr(), 2).unwrap(), b"ta");
        let long = std::ffi::CString::new(vec![b'x'; 3 * 4096]).unwrap();
        assert_eq!(string(long.as_ptr().addr(), 1 << 20).unwrap().len(), 3 * 4096);
        #[cfg(target_os = "linux")]
        for address in [0, 1, usize::MAX, usize::MAX - 4096] {
            assert_eq!(string(address, 10), None);
        }
    }
}
