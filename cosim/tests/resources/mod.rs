//! Current resources of this process, from /proc.

use std::fs;

pub(crate) struct Resources {
    pub(crate) resident_kb: usize,
    pub(crate) files: usize,
    pub(crate) mappings: usize,
}

pub(crate) fn of_this_process() -> Resources {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let resident = status.lines().find(|line| line.starts_with("VmRSS:")).unwrap();
    Resources {
        resident_kb: resident.split_whitespace().nth(1).unwrap().parse().unwrap(),
        files: fs::read_dir("/proc/self/fd").unwrap().count(),
        mappings: fs::read_to_string("/proc/self/maps").unwrap().lines().count(),
    }
}
