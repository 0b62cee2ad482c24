//! The names under which everything is sent.
//!
//! `@1` is the protocol's version and a verbatim chunk: no wildcard of an observer ever matches
//! it, so nobody can hold up a run by listening. What observers may listen to is under
//! `cosim/1/...`. Workers announce themselves under `cosim/@pool/VERSION`, so that those of other
//! versions are seen and named.

use super::wire::VERSION;

/// Everything of the protocol.
pub(crate) fn root() -> String {
    format!("cosim/@{VERSION}")
}

/// A worker: its liveliness token; queries to it are below.
pub(crate) fn worker(id: &str) -> String {
    format!("cosim/@pool/{VERSION}/{id}")
}

/// Every worker's token, of whatever version.
pub(crate) fn workers() -> &'static str {
    "cosim/@pool/*/*"
}

/// A run: its liveliness token. Whatever was started for it ends with it.
pub(crate) fn running(run: &str) -> String {
    format!("{}/running/{run}", root())
}

/// The run of a key that [`running`] gave.
pub(crate) fn parse_running(key: &str) -> Option<&str> {
    key.split('/').nth(3)
}

/// A life of a group on a worker: the lanes of `cmd` and `rep` and the liveliness tokens `alive` are
/// below. With the worker in the key, none can speak for what is on another.
pub(crate) fn incarnation(run: &str, worker: &str, group: usize, generation: u32) -> String {
    format!("{}/run/{run}/{worker}/{group}.{generation}", root())
}

/// Something of every life on a worker.
pub(crate) fn incarnations(worker: &str, what: &str) -> String {
    format!("{}/run/*/{worker}/*/{what}", root())
}

/// An FMU's bytes, asked for by the worker that one of its components is on: with the worker in the
/// key, no other can ask.
pub(crate) fn fmu(run: &str, worker: &str, sha256: &str) -> String {
    format!("{}/run/{run}/{worker}/fmu/{sha256}", root())
}

/// Which rights somebody has: a query that everybody may send.
pub(crate) fn rights() -> String {
    format!("{}/rights", root())
}

/// All keys there are: a wildcard matches no verbatim chunk.
pub(crate) fn everything() -> [String; 3] {
    ["**".to_owned(), format!("{}/**", root()), "cosim/@pool/**".to_owned()]
}

/// What everybody may read.
pub(crate) fn open(what: &str) -> String {
    format!("cosim/{VERSION}/{what}")
}

/// Version and name of the worker of a key that [`worker`] gave.
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
