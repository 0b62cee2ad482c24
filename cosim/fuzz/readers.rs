//! The readers of untrusted files as functions of bytes: they may refuse, and must not panic, take
//! long or write elsewhere. Shared by the fuzz targets and by the test that mutates valid files
//! (`cosim/tests/all/mutations.rs`).

use std::io::Cursor;
use std::path::Path;
use std::sync::{Arc, OnceLock};

use cosim::campaign::Campaign;
use cosim::fmi::{Basic, Fmu, archive, description};
use cosim::hosted::Kept;
use cosim::observe::is_results;
use cosim::proxy::frames::{self, Reply, Request};
use cosim::proxy::manifest as remote;
use cosim::roles::Declaration;
use cosim::scenario::Scenario;
use cosim::scripted;
use cosim::system::{Signal, Signals};
use cosim::{Overrides, Recording, Run, Snapshot, System, Time};
use sha2::{Digest, Sha256};
use tempfile::TempDir;

#[path = "budget.rs"]
mod budget;
#[path = "samples.rs"]
mod samples;

pub use budget::within;
pub use samples::*;

/// Unpacks archives, and checks what was unpacked.
pub fn archive(bytes: &[u8]) {
    let Ok(unpacked) = archive::unpack_from(Cursor::new(bytes), Path::new("x.fmu")) else {
        return;
    };
    inside(unpacked.path(), 0);
}

/// Only plain files and folders.
fn inside(folder: &Path, depth: usize) {
    assert!(depth <= 32);
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let kind = entry.file_type().unwrap();
        assert!(kind.is_dir() || kind.is_file(), "{}", entry.path().display());
        if kind.is_dir() {
            inside(&entry.path(), depth + 1);
        }
    }
}

/// Reads descriptions, and queries the result.
pub fn description(bytes: &[u8]) {
    let Ok(read) = description::parse(bytes, Path::new("x.fmu/modelDescription.xml")) else {
        return;
    };
    for (position, variable) in read.variables.iter().enumerate() {
        assert_eq!(read.position(&variable.name), Some(position));
        if read.variables.len() < 1000 {
            read.feeds_through(position);
        }
    }
    for output in &read.outputs {
        let named = output.dependencies.iter().flatten().chain([&output.variable]);
        assert!(named.clone().all(|&position| position < read.variables.len()));
    }
}

const GROUPS_FILE: &str = "tank_OspModelDescription.xml";

/// A folder with an FMU, used repeatedly; the FMU stays open, so it is unpacked only once.
fn folder() -> &'static TempDir {
    static FOLDER: OnceLock<(TempDir, Arc<Fmu>)> = OnceLock::new();
    let (folder, _) = FOLDER.get_or_init(|| {
        let folder = TempDir::new().unwrap();
        let file = folder.path().join("tank.fmu");
        std::fs::write(&file, fmu()).unwrap();
        std::fs::write(folder.path().join("tank.ssv"), PARAMETERS).unwrap();
        std::fs::write(folder.path().join(GROUPS_FILE), GROUPS).unwrap();
        (folder, Fmu::open(&file).unwrap())
    });
    folder
}

fn load(name: &str, bytes: &[u8]) {
    let file = folder().path().join(name);
    std::fs::write(&file, bytes).unwrap();
    if let Ok(system) = System::load(&file, &Overrides::new()) {
        assert!(system.components().iter().all(|component| !component.name.is_empty()));
    }
}

/// Reads and checks systems.
pub fn ssd(bytes: &[u8]) {
    load("fuzzed.ssd", bytes);
}

/// OSP structures with the files that belong to them: the three texts follow one another, each
/// starting at its root element.
pub fn osp(bytes: &[u8]) {
    let (structure, rest) = split(bytes, b"<OspModelDescription");
    let (groups, log_config) = split(rest, b"<simulators");
    let own = folder().path().join("osp");
    std::fs::create_dir_all(&own).unwrap();
    std::fs::write(own.join(GROUPS_FILE), groups).unwrap();
    std::fs::write(own.join("LogConfig.xml"), log_config).unwrap();
    let _ = std::fs::hard_link(folder().path().join("tank.fmu"), own.join("tank.fmu"));
    load("osp/OspSystemStructure.xml", structure);
}

fn split<'a>(bytes: &'a [u8], at: &[u8]) -> (&'a [u8], &'a [u8]) {
    let found = bytes.windows(at.len()).position(|window| window == at);
    bytes.split_at(found.unwrap_or(bytes.len()))
}

/// Unpacks, reads and checks packages.
pub fn ssp(bytes: &[u8]) {
    load("fuzzed.ssp", bytes);
}

/// Reads parameters through a valid system.
pub fn ssv(bytes: &[u8]) {
    std::fs::write(folder().path().join("fuzzed.ssv"), bytes).unwrap();
    load("good.ssd", SYSTEM.replace("tank.ssv", "fuzzed.ssv").as_bytes());
}

/// Reads tables, writes them, reads them back the same, and uses them as signals.
pub fn csv(bytes: &[u8]) {
    let (file, again) = (folder().path().join("fuzzed.csv"), folder().path().join("again.csv"));
    std::fs::write(&file, bytes).unwrap();
    let Ok(read) = Recording::read_csv(&file) else { return };
    read.write_csv(&again).unwrap();
    let twice = Recording::read_csv(&again).expect("what was written can be read");
    assert_eq!(twice.time().len(), read.time().len());
    let signals = read.columns().map(|(name, values)| Signal {
        name: name.to_owned(),
        kind: cosim::fmi::Kind::Real,
        continuous: true,
        values: values.to_vec(),
    });
    drop(Signals::new(read.time(), signals.collect()));
}

/// Reads a mapping of parameters through a valid system.
pub fn ssm(bytes: &[u8]) {
    std::fs::write(folder().path().join("fuzzed.ssm"), bytes).unwrap();
    let (whole, open) = (r#"source="tank.ssv"/>"#, r#"source="tank.ssv">"#);
    let mapped = r#"<ssd:ParameterMapping source="fuzzed.ssm"/></ssd:ParameterBinding>"#;
    load("mapped.ssd", SYSTEM.replace(whole, &[open, mapped].concat()).as_bytes());
}

/// Reads a signal dictionary through a valid system.
pub fn ssb(bytes: &[u8]) {
    std::fs::write(folder().path().join("fuzzed.ssb"), bytes).unwrap();
    let end = "</ssd:System>";
    let with = r#"<ssd:SignalDictionaries>
        <ssd:SignalDictionary name="bus" source="fuzzed.ssb"/></ssd:SignalDictionaries>"#;
    load("bus.ssd", SYSTEM.replace(end, &[with, end].concat()).as_bytes());
}

/// A scenario: events as JSON, or faults as TOML.
pub fn scenario(bytes: &[u8]) {
    let json = bytes.first() == Some(&b'{');
    let file = folder().path().join(if json { "fuzzed.json" } else { "fuzzed.toml" });
    std::fs::write(&file, bytes).unwrap();
    drop(Scenario::read(&file));
}

/// Campaign files.
pub fn campaign(bytes: &[u8]) {
    let file = folder().path().join("campaign.toml");
    std::fs::write(&file, bytes).unwrap();
    drop(Campaign::read(&file));
}

/// Declarations of roles.
pub fn roles(bytes: &[u8]) {
    let file = folder().path().join("roles.toml");
    std::fs::write(&file, bytes).unwrap();
    drop(Declaration::read(&file));
}

/// Results as Parquet.
pub fn parquet(bytes: &[u8]) {
    results("fuzzed.parquet", bytes);
}

fn results(name: &str, bytes: &[u8]) {
    let file = folder().path().join(name);
    // Otherwise they would be read as CSV.
    assert!(is_results(&file), "the reader of {name} is compiled in");
    std::fs::write(&file, bytes).unwrap();
    if let Ok(read) = cosim::observe::read(&file) {
        assert!(read.columns().all(|(_, column)| column.len() == read.time().len()));
    }
}

/// Results as MCAP, unchanged and with the checksums of their chunks removed.
pub fn mcap(bytes: &[u8]) {
    for bytes in [bytes, &without_checksums(bytes)] {
        results("fuzzed.mcap", bytes);
    }
}

/// Chunks (records 6) without a checksum: zero means that there is none.
fn without_checksums(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let mut at = 8;
    while let Some((kind, rest)) = bytes.get_mut(at..).and_then(|rest| rest.split_first_mut()) {
        let Some((length, record)) = rest.split_first_chunk_mut::<8>() else { break };
        if let (6, Some(checksum)) = (&*kind, record.get_mut(24..28)) {
            checksum.fill(0);
        }
        let Ok(length) = usize::try_from(u64::from_le_bytes(*length)) else { break };
        at = at.saturating_add(9).saturating_add(length);
    }
    bytes
}

/// The system of functions.
pub fn sum() -> &'static System {
    static SYSTEM: OnceLock<System> = OnceLock::new();
    SYSTEM.get_or_init(|| functions(folder().path()).unwrap())
}

/// Snapshots of runs, unchanged and with a valid checksum; a run continues from those of its own
/// system.
pub fn snapshot(bytes: &[u8]) {
    let mut sealed = bytes.to_vec();
    if let Some((header, body)) = sealed.split_at_mut_checked(44) {
        header[12..].copy_from_slice(&Sha256::digest(body));
    }
    for bytes in [bytes, &sealed] {
        let file = folder().path().join("fuzzed.snapshot");
        std::fs::write(&file, bytes).unwrap();
        if let Ok(snapshot) = Snapshot::read(&file) {
            drop(Run::new(sum()).resume(&snapshot).go());
        }
    }
}

/// What the resources of remote FMUs, and of those of Python classes, say about them.
pub fn manifest(bytes: &[u8]) {
    let resources = folder().path().join("manifest");
    std::fs::create_dir_all(&resources).unwrap();
    for name in [remote::FILE, "component.json"] {
        std::fs::write(resources.join(name), bytes).unwrap();
    }
    if let Ok(read) = remote::Manifest::read(&resources) {
        drop(read.held(&resources));
    }
    drop(scripted::Manifest::read(&resources));
}

/// What the library of a remote FMU and the program beside it send each other; states are in it.
pub fn frame(bytes: &[u8]) {
    let (mut requests, mut replies) = (bytes, bytes);
    while frames::read::<Request>(&mut requests).is_ok() {}
    while frames::read::<Reply>(&mut replies).is_ok() {}
}

/// The variables of an exported FMU.
pub fn exported(bytes: &[u8]) {
    if let Ok(mut system) = hosted(folder().path(), bytes) {
        drop(begin(&mut system));
        for (basic, reference) in Basic::ALL.into_iter().flat_map(|b| (0..8).map(move |r| (b, r))) {
            drop(system.number(basic, reference));
        }
    }
}

/// States of an exported FMU; it continues from those that it accepts.
pub fn kept(bytes: &[u8]) {
    let Ok(kept) = postcard::from_bytes::<Kept>(bytes) else { return };
    let mut system = hosted(folder().path(), INTERFACE).unwrap();
    if system.restore(&kept).is_ok() {
        drop(system.advance(Time::from_ns(1_000_000_000)));
        drop(system.save());
    }
}

/// Messages between the processes of a distributed run.
#[cfg(feature = "distributed")]
pub fn message(bytes: &[u8]) {
    cosim::distributed::decode(bytes);
}
