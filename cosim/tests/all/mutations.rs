//! Thousands of valid files with mutations: the readers refuse or accept them, nothing else. The
//! same functions are the targets of `cosim/fuzz`; this test runs everywhere.

#[path = "../../fuzz/readers.rs"]
#[allow(dead_code, unreachable_pub, reason = "the fuzz targets need all of it")]
mod readers;

use std::time::{Duration, Instant};

use cosim::observe::{self, McapRecorder};
use cosim::roles::Declaration;
use cosim::scenario::Scenario;
use cosim::{Code, Overrides, Run, Snapshot, System, Time};
use tempfile::TempDir;

use crate::models::Model;
use crate::ssd::Ssd;

/// Numbers that are the same in every run (xorshift64*).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.next() >> 11) as usize % limit.max(1)
    }
}

/// Bytes that are meaningful to the readers.
const WORDS: &[&[u8]] = &[
    b"<",
    b">",
    b"/>",
    b"\"",
    b"'",
    b"&lt;",
    b"&#0;",
    b"&x;",
    b"<!DOCTYPE a>",
    b"<![CDATA[",
    b"]]>",
    b"<!--",
    b"-->",
    b"<?x?>",
    b"xmlns:a='b'",
    b"PK\x01\x02",
    b"PK\x03\x04",
    b"PK\x05\x06",
    b"PK\x06\x06",
    b"\xff\xff\xff\xff",
    b"\0\0\0\0",
    b"../",
    b"\\",
    b"\0",
    b",",
    b"\n",
    b"\r\n",
    b"nan",
    b"inf",
    b"-1",
    b"1e999",
    b"18446744073709551616",
    b"\xef\xbb\xbf",
    b"\xc3\x28",
    b" ",
];

fn mutate(good: &[u8], numbers: &mut Numbers) -> Vec<u8> {
    let mut bytes = good.to_vec();
    for _ in 0..=numbers.below(4) {
        let at = numbers.below(bytes.len());
        let length = (1 + numbers.below(32)).min(bytes.len() - at);
        match numbers.below(6) {
            0 => bytes[at] ^= 1 << numbers.below(8),
            1 => bytes[at] = numbers.next() as u8,
            2 => drop(bytes.drain(at..at + length)),
            3 => {
                let piece = bytes[at..at + length].to_vec();
                let to = numbers.below(bytes.len());
                bytes.splice(to..to, piece);
            }
            4 => bytes.truncate(at),
            _ => {
                let word = WORDS[numbers.below(WORDS.len())].iter().copied();
                let end = if numbers.below(2) == 0 { at } else { at + length };
                bytes.splice(at..end, word);
            }
        }
        if bytes.is_empty() {
            break;
        }
    }
    bytes
}

/// Feeds mutations of `good` to a reader; each must end soon, and stay within its memory budget.
fn survive(seed: u64, good: &[u8], count: usize, reader: fn(&[u8])) {
    let mut numbers = Numbers(seed);
    readers::within(reader, good);
    for round in 0..count {
        let bytes = mutate(good, &mut numbers);
        let begun = Instant::now();
        let done = std::panic::catch_unwind(|| readers::within(reader, &bytes));
        let text = String::from_utf8_lossy(&bytes);
        assert!(done.is_ok(), "the reader panics in round {round} of {text}");
        assert!(begun.elapsed() < Duration::from_secs(10), "round {round} takes long: {text}");
    }
}

#[test]
fn archives() {
    survive(1, &readers::fmu(), 1500, readers::archive);
}

#[test]
fn descriptions() {
    survive(2, readers::DESCRIPTION.as_bytes(), 4000, readers::description);
}

#[test]
fn systems() {
    survive(3, readers::SYSTEM.as_bytes(), 1500, readers::ssd);
}

/// The valid input must be read completely before it is mutated.
#[test]
fn the_structure_is_a_system() {
    let folder = TempDir::new().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    write("tank.fmu", &readers::fmu());
    write("tank_OspModelDescription.xml", readers::GROUPS.as_bytes());
    write("LogConfig.xml", readers::LOG_CONFIG.as_bytes());
    write("OspSystemStructure.xml", readers::STRUCTURE.as_bytes());
    let system = System::load(folder.path(), &Overrides::new()).unwrap();
    let names: Vec<&str> = system.components().iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["a", "b", "c", "v"]);
    assert_eq!(system.output_interval(), cosim::Step::whole(Time::from_ns(100_000_000)));
}

#[test]
fn structures() {
    survive(9, &readers::structure(), 1500, readers::osp);
}

#[test]
fn packages() {
    survive(4, &readers::package(), 500, readers::ssp);
}

#[test]
fn parameters() {
    survive(5, readers::PARAMETERS.as_bytes(), 1000, readers::ssv);
}

#[test]
fn tables() {
    survive(6, readers::TABLE.as_bytes(), 3000, readers::csv);
}

#[test]
fn mappings() {
    survive(11, readers::MAPPING.as_bytes(), 1000, readers::ssm);
}

#[test]
fn dictionaries() {
    survive(12, readers::DICTIONARY.as_bytes(), 1000, readers::ssb);
}

#[test]
fn scenarios() {
    survive(13, readers::FAULTS.as_bytes(), 2000, readers::scenario);
    survive(14, include_bytes!("../../../examples/dvl_fault.json"), 2000, readers::scenario);
}

#[test]
fn campaigns() {
    survive(15, include_bytes!("../../../examples/campaign/filters.toml"), 1000, readers::campaign);
}

#[test]
fn roles() {
    survive(16, readers::ROLES.as_bytes(), 2000, readers::roles);
}

fn state_of_functions() -> Vec<u8> {
    readers::state_of_functions(TempDir::new().unwrap().path())
}

/// The seeds of the readers that need an ending, or another file, are valid.
#[test]
fn the_seeds_are_read_as_what_they_are() {
    let folder = TempDir::new().unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let file = folder.path().join(name);
        std::fs::write(&file, bytes).unwrap();
        file
    };
    Scenario::read(write("f.toml", readers::FAULTS.as_bytes())).unwrap();
    Declaration::read(write("r.toml", readers::ROLES.as_bytes())).unwrap();
    Snapshot::read(write("s.snapshot", &state_of_functions())).unwrap();
    write(cosim::proxy::manifest::FILE, readers::REMOTE.as_bytes());
    cosim::proxy::manifest::Manifest::read(folder.path()).unwrap();
    write("component.json", readers::CLASS.as_bytes());
    cosim::scripted::Manifest::read(folder.path()).unwrap();
    let mut hosted = readers::hosted(folder.path(), readers::INTERFACE).unwrap();
    readers::begin(&mut hosted).unwrap();
    for name in ["r.mcap", "r.parquet"] {
        let file = folder.path().join(name);
        system().run(&mut [&mut *observe::create(&file).unwrap()]).unwrap();
        assert!(cosim::observe::read(&file).unwrap().time().len() > 5);
        // Its name alone chooses the reader.
        let table = write(name, readers::TABLE.as_bytes());
        assert_eq!(cosim::observe::read(table).unwrap_err().code(), Code::Results);
    }
}

/// A system whose runs produce files to mutate.
fn system() -> System {
    let ssd = Ssd::new().add("a", Model::Clock).add("b", Model::Integrator).connect("a.y", "b.u");
    ssd.load(&Overrides::new()).unwrap()
}

#[test]
fn results() {
    let file = TempDir::new().unwrap().path().with_extension("mcap");
    system().run(&mut [&mut McapRecorder::create(&file).unwrap()]).unwrap();
    let good = std::fs::read(&file).unwrap();
    std::fs::remove_file(&file).unwrap();
    survive(7, &good, 1500, readers::mcap);
    // Lengths that would overflow: of a record, of one in a chunk, of a chunk.
    for length in [u64::MAX, u64::MAX - 8, 1 << 40] {
        for at in (0..good.len() - 8).filter(|at| good[*at..].starts_with(&[0; 6])) {
            let mut wrong = good.clone();
            wrong[at - 2..at + 6].copy_from_slice(&length.to_le_bytes());
            readers::mcap(&wrong);
        }
    }
}

#[test]
fn results_as_parquet() {
    let file = TempDir::new().unwrap().path().with_extension("parquet");
    system().run(&mut [&mut *observe::create(&file).unwrap()]).unwrap();
    let good = std::fs::read(&file).unwrap();
    std::fs::remove_file(&file).unwrap();
    survive(17, &good, 1500, readers::parquet);
}

#[test]
fn states() {
    survive(18, &state_of_functions(), 1500, readers::snapshot);
}

#[test]
fn snapshots() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("a.snapshot");
    let mut keep = |snapshot: Snapshot| snapshot.write(&file);
    let half = [Time::from_ns(500_000_000)];
    Run::new(&system()).snapshots(None, &half, &mut keep).go().unwrap();
    survive(8, &std::fs::read(&file).unwrap(), 1500, readers::snapshot);
}

#[test]
fn manifests() {
    survive(19, readers::REMOTE.as_bytes(), 1500, readers::manifest);
    survive(20, readers::CLASS.as_bytes(), 1500, readers::manifest);
}

#[test]
fn frames() {
    for (seed, frames) in (21..).zip(readers::frames()) {
        survive(seed, &frames, 20_000, readers::frame);
    }
    // A length alone takes no memory.
    readers::within(readers::frame, &[0xff, 0xff, 0xff, 0x3f]);
}

#[test]
fn exported_systems() {
    survive(23, readers::INTERFACE, 1500, readers::exported);
}

#[test]
fn states_of_exported_systems() {
    let folder = TempDir::new().unwrap();
    survive(24, &readers::state_of_hosted(folder.path()), 1500, readers::kept);
}

#[test]
fn messages() {
    survive(10, &readers::step(), 20_000, readers::message);
}

/// Small inputs that expand, in every format, stay within the same budget.
#[test]
fn inflated_texts() {
    let namespace = |inside: String| format!("<a xmlns='{}'>{inside}</a>", "n".repeat(4000));
    let attributes: String = (0..250).map(|n| format!(" a{n}=''")).collect();
    let texts = [
        namespace("<b/>".repeat(100_000)),
        namespace((0..20_000).map(|n| format!("<b{n}/>")).collect()),
        format!("<a>{}</a>", format!("<b{attributes}/>").repeat(500)),
        format!("<a>{}</a>", "&lt;".repeat(100_000)),
        format!("<a>{}</a>", "<b>x</b>".repeat(50_000)),
    ];
    for text in &texts {
        for reader in [readers::description, readers::ssd, readers::ssv, readers::osp] {
            readers::within(reader, text.as_bytes());
        }
    }
    readers::within(
        readers::csv,
        format!("time{}\n0{}\n", ",".repeat(50_000), ",1".repeat(50_000)).as_bytes(),
    );
    readers::within(readers::csv, format!("time,a\n{}", "0,1\n".repeat(50_000)).as_bytes());
}
