//! The C library whose math functions FMUs call: on machines with different libraries, the last bit
//! of a sine may differ.
#![allow(unsafe_code, reason = "system calls without a safe form")]

use std::path::PathBuf;

use cosim_base::sha256;

/// Its version and the SHA-256 of the file with the math functions, as far as they are known.
pub(super) fn describe() -> String {
    let file = mathematics().and_then(|path| std::fs::read(path).ok());
    let hash = file.map_or("unknown".to_owned(), |bytes| sha256(bytes).chars().take(12).collect());
    format!("{}, libm {hash}", version())
}

/// The file that is mapped into a process on this machine when it calls a math function.
fn mathematics() -> Option<PathBuf> {
    // SAFETY: the library is the system's own and no symbol is looked up. FMUs map the same file.
    let _kept = unsafe { libloading::Library::new("libm.so.6") };
    mapped(&std::fs::read_to_string("/proc/self/maps").ok()?)
}

/// The first such file in the memory map of a process.
fn mapped(maps: &str) -> Option<PathBuf> {
    // Address, permissions, offset, device, inode; then the path, which may contain spaces.
    let paths = maps.lines().filter_map(|line| Some(PathBuf::from(&line[line.find('/')?..])));
    let is_it = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with("libm.so") || name.starts_with("libm-")
    };
    paths.into_iter().find(is_it)
}

#[cfg(target_env = "gnu")]
fn version() -> String {
    // SAFETY: the text lives as long as the program.
    let text = unsafe { std::ffi::CStr::from_ptr(libc::gnu_get_libc_version()) };
    format!("glibc {}", text.to_string_lossy())
}

#[cfg(not(target_env = "gnu"))]
fn version() -> String {
    "a C library without a version".to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mathematics_is_found_among_all_that_is_mapped() {
        let maps = "7f0 r--p 0 08:01 1 /lib/libmad.so.0\n7f1 rw-p 0 00:00 0 [heap]\n\
                    7f2 r-xp 0 08:01 3 /usr/lib/x86 64/libm.so.6\n";
        assert_eq!(mapped(maps), Some(PathBuf::from("/usr/lib/x86 64/libm.so.6")));
        assert_eq!(mapped("7f1 rw-p 0 00:00 0 [heap]\n"), None);
    }

    #[cfg(target_env = "gnu")]
    #[test]
    fn the_library_here_has_a_version_and_a_hash() {
        let text = describe();
        let (version, hash) = text.split_once(", libm ").unwrap();
        assert!(version.starts_with("glibc 2."), "{text}");
        assert!(hash.len() == 12 && hash.bytes().all(|b| b.is_ascii_hexdigit()), "{text}");
    }
}
