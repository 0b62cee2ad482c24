//! The key expressions of all messages.
//!
//! `@1` is the version of the protocol and a verbatim chunk: no wildcard of an observer ever
//! matches it, so listening cannot hold up a run. Observers may listen to everything under
//! `cosim/1/...`. Workers announce themselves under `cosim/@pool/VERSION`, so that workers of other
//! versions are seen and named.

use super::wire::VERSION;

/// The root of all keys of the protocol.
pub(crate) fn root() -> String {
    format!("cosim/@{VERSION}")
}

/// A worker: its liveliness token; queries to it go to the keys below.
pub(crate) fn worker(id: &str) -> String {
    format!("cosim/@pool/{VERSION}/{id}")
}

/// The tokens of all workers, whatever their version.
pub(crate) fn workers() -> &'static str {
    "cosim/@pool/*/*"
}

/// A run: its liveliness token. Everything started for the run ends with it.
pub(crate) fn running(run: &str) -> String {
    format!("{}/running/{run}", root())
}

/// The run in a key made by [`running`].
pub(crate) fn parse_running(key: &str) -> Option<&str> {
    key.split('/').nth(3)
}

/// An incarnation of a group on a worker; below are the channels of `cmd` and `rep` and the
/// liveliness tokens `alive`. The key contains the worker, so no worker can speak for another.
pub(crate) fn incarnation(run: &str, worker: &str, group: usize, generation: u32) -> String {
    format!("{}/run/{run}/{worker}/{group}.{generation}", root())
}

/// One key of every incarnation on a worker.
pub(crate) fn incarnations(worker: &str, what: &str) -> String {
    format!("{}/run/*/{worker}/*/{what}", root())
}

/// The bytes of an FMU, requested by the worker that computes one of its components. The key
/// contains the worker, so no other worker can request them.
pub(crate) fn fmu(run: &str, worker: &str, sha256: &str) -> String {
    format!("{}/run/{run}/{worker}/fmu/{sha256}", root())
}

/// A query for the rights of a name; every client may send it.
pub(crate) fn rights() -> String {
    format!("{}/rights", root())
}

/// All keys: a wildcard does not match a verbatim chunk.
pub(crate) fn everything() -> [String; 3] {
    ["**".to_owned(), format!("{}/**", root()), "cosim/@pool/**".to_owned()]
}

/// Keys that every client may read.
pub(crate) fn open(what: &str) -> String {
    format!("cosim/{VERSION}/{what}")
}

/// Version and name of the worker in a key made by [`worker`].
pub(crate) fn parse_worker(key: &str) -> Option<(&str, &str)> {
    let mut chunks = key.split('/').skip(2);
    Some((chunks.next()?, chunks.next()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_key_says_is_read_again() {
        assert_eq!(parse_worker(&worker("left")), Some(("1", "left")));
        assert_eq!(parse_running(&running("r")), Some("r"));
    }
}
