//! An FMU that a worker holds, as it is advertised to a caller that does not have the file: the
//! description and the documents, without binaries. A remote FMU can be made from it.

use std::path::Path;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use zenoh::{Session, Wait};

use super::access::allowed::Allowed;
use super::access::session::Access;
use super::keys;
use super::net::refused;
use super::proxy::shell;
use super::remote::listen;
use super::setup::FmuFile;
use cosim_base::error::{Code, Error, Result};
use cosim_base::names;

/// An FMU without its binaries.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct AvailableFmu {
    /// The file's name.
    pub name: String,
    /// SHA-256 of the whole file.
    pub sha256: String,
    /// The platforms for which it has a library, by folder name.
    pub platforms: Vec<String>,
    /// The archive with its description and documents.
    pub shell: Vec<u8>,
}

/// How long a worker may take to read an FMU.
const READING: Duration = Duration::from_secs(5);
const PAUSE: Duration = Duration::from_millis(50);

impl AvailableFmu {
    /// Looks up an FMU by file name or hash; the error says why it is not available.
    pub(super) fn of(allowed: &Allowed, wanted: &str) -> Result<Self, String> {
        let files = || allowed.files().filter_map(|(hash, file)| Some((hash, file, name(file)?)));
        let is_wanted = |(hash, _, name): &(&str, &Path, &str)| {
            *hash == wanted || *name == wanted || name.strip_suffix(".fmu") == Some(wanted)
        };
        let Some((hash, file, name)) = files().find(is_wanted) else {
            let all: Vec<&str> = files().map(|(_, _, name)| name).collect();
            let held = match all.is_empty() {
                true => "it holds none: cosim worker --allow FILE.fmu".to_owned(),
                false => format!("it holds {}", all.join(", ")),
            };
            let nearest = names::did_you_mean(wanted, all.iter().copied());
            return Err(nearest.map_or(held.clone(), |nearest| format!("{nearest} {held}")));
        };
        let one = FmuFile { sha256: hash.to_owned(), name: name.to_owned() };
        if allowed.held(&one).is_none() {
            return Err(format!("{name} is no longer the file that was allowed"));
        }
        let (platforms, shell) = shell::of(file).map_err(|error| error.line())?;
        Ok(Self { name: one.name, sha256: one.sha256, platforms, shell })
    }

    /// Requests the FMU from a worker, which must connect to one of `accesses` within `wait`.
    pub(crate) fn ask(
        accesses: &[Access],
        worker: &str,
        fmu: &str,
        wait: Duration,
    ) -> Result<Self> {
        let (session, endpoint) = listen(accesses)?;
        let offer = asked(&session, worker, fmu, wait, &endpoint);
        super::run::close(session);
        offer
    }
}

fn name(file: &Path) -> Option<&str> {
    file.file_name()?.to_str()
}

fn asked(
    session: &Session,
    worker: &str,
    fmu: &str,
    wait: Duration,
    endpoint: &str,
) -> Result<AvailableFmu> {
    let key = format!("{}/offer", keys::worker(worker));
    let begun = Instant::now();
    loop {
        let replies = session.get(&key).payload(fmu).timeout(READING).wait().map_err(refused)?;
        for reply in replies {
            let Ok(sample) = reply.into_result() else { continue };
            let answer: Result<AvailableFmu, String> =
                postcard::from_bytes(&sample.payload().to_bytes()).map_err(|why| {
                    let what = format!("what worker {worker} offers cannot be read");
                    Error::new(Code::Protocol, what).why(why)
                })?;
            return answer.map_err(|why| {
                Error::new(Code::UnknownName, format!("worker {worker} offers no '{fmu}'")).why(why)
            });
        }
        if begun.elapsed() > wait {
            let waited = wait.as_secs_f64();
            let what = format!("worker {worker} did not connect to {endpoint} within {waited} s");
            let there = present(session)?;
            return Err(Error::new(Code::Lost, what)
                .why(match there.is_empty() {
                    true => "no worker is connected".to_owned(),
                    false => format!("connected: {}", there.join(", ")),
                })
                .help(format!("cosim worker --name {worker} --connect {endpoint} --allow {fmu}")));
        }
        std::thread::sleep(PAUSE);
    }
}

/// The workers that are connected.
fn present(session: &Session) -> Result<Vec<String>> {
    let replies = session.liveliness().get(keys::workers()).timeout(READING).wait();
    let tokens = replies.map_err(refused)?.into_iter();
    let tokens = tokens.filter_map(|reply| reply.into_result().ok());
    let name = |key: &str| keys::parse_worker(key).map(|(_, name)| name.to_owned());
    let mut names: Vec<String> = tokens.filter_map(|t| name(t.key_expr().as_str())).collect();
    names.sort();
    names.dedup();
    Ok(names)
}
