//! Power losses: what a run has written when the power fails at any of its writes.
//!
//! A library in front of the C library's (disk.c) records what the program does to files. From
//! that, a disk is computed that keeps only what it must: content that was synced, and names whose
//! folder was synced since. It is cut after every operation, and its content is checked.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

use crate::command::text;
use crate::models::Model;
use crate::ssd::Ssd;

/// Operations on files, each identified by a number that it keeps throughout.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Operation {
    /// A file with this name is created; emptied if it existed.
    Create(u64, PathBuf),
    Write(u64, u64),
    Sync(u64),
    Link(u64, PathBuf),
    Rename(PathBuf, PathBuf),
    Remove(PathBuf),
    SyncFolder(PathBuf),
}
use Operation::{Create, Link, Remove, Rename, Sync, SyncFolder, Write};

fn parse(line: &str) -> Option<Operation> {
    let mut words = line.split('\t');
    let kind = words.next()?;
    let mut next = || words.next();
    let number = |word: Option<&str>| word?.parse().ok();
    let path = |word: Option<&str>| Some(PathBuf::from(word?));
    Some(match kind {
        "create" => Create(number(next())?, path(next())?),
        "write" => Write(number(next())?, number(next())?),
        "sync" => Sync(number(next())?),
        "link" => Link(number(next())?, path(next())?),
        "rename" => Rename(path(next())?, path(next())?),
        "remove" => Remove(path(next())?),
        "folder" => SyncFolder(path(next())?),
        _ => return None,
    })
}

/// The disk that keeps only what it must.
#[derive(Default, Clone)]
struct Disk {
    /// Current names, and those that survive.
    names: BTreeMap<PathBuf, u64>,
    kept: BTreeMap<PathBuf, u64>,
    /// Bytes written, and those that survive.
    written: BTreeMap<u64, u64>,
    synced: BTreeMap<u64, u64>,
}

impl Disk {
    fn apply(&mut self, operation: &Operation) {
        match operation {
            Create(file, name) => {
                self.names.insert(name.clone(), *file);
                self.written.insert(*file, 0);
                // Emptying a file may reach the disk immediately.
                self.synced.insert(*file, 0);
            }
            Write(file, bytes) => *self.written.entry(*file).or_default() += bytes,
            Sync(file) => {
                let written = self.written.get(file).copied().unwrap_or_default();
                self.synced.insert(*file, written);
            }
            Link(file, name) => drop(self.names.insert(name.clone(), *file)),
            Rename(from, to) => {
                if let Some(file) = self.names.remove(from) {
                    self.names.insert(to.clone(), file);
                }
            }
            Remove(name) => drop(self.names.remove(name)),
            SyncFolder(folder) => {
                let inside = |name: &&PathBuf| name.parent() == Some(folder.as_path());
                self.kept.retain(|name, _| !inside(&name));
                let now = self.names.iter().filter(|(name, _)| inside(name));
                self.kept.extend(now.map(|(name, file)| (name.clone(), *file)));
            }
        }
    }

    /// The content of a file after a power cut: its number and its bytes. A disk may have done more
    /// with names than it must, so both the guaranteed and the current names are checked.
    fn after_a_cut(&self, name: &Path) -> Vec<(u64, u64)> {
        let files = [self.kept.get(name), self.names.get(name)];
        let files = files.into_iter().flatten();
        files.map(|&file| (file, self.synced.get(&file).copied().unwrap_or_default())).collect()
    }
}

/// Runs `cosim` and returns what it did to files below its folder.
fn observed(folder: &Path, arguments: &[&str]) -> Vec<Operation> {
    let library = folder.join("disk.so");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/all/disk.c");
    let done = Command::new("cc")
        .args(["-O1", "-shared", "-fPIC", "-w", "-o"])
        .args([&library, &source])
        .arg("-ldl")
        .status()
        .unwrap();
    assert!(done.success());
    let log = folder.join("operations");
    let output = Command::new(env!("CARGO_BIN_EXE_cosim"))
        .args(arguments)
        .current_dir(folder)
        .env("LD_PRELOAD", &library)
        .env("DISK_LOG", &log)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let noted = std::fs::read_to_string(log).unwrap();
    let real = folder.canonicalize().unwrap();
    noted
        .lines()
        .filter_map(parse)
        .filter(|operation| match operation {
            Create(_, name) | Link(_, name) | Remove(name) | Rename(_, name) => {
                name.starts_with(&real)
            }
            SyncFolder(name) => name.starts_with(&real),
            _ => true,
        })
        .collect()
}

/// At whatever operation the power fails: a snapshot is complete or absent, and the results reach
/// at least as far as the snapshot.
#[test]
fn a_snapshot_and_the_results_before_it_survive_a_cut_at_every_write() {
    for results in ["out.csv", "out.mcap"] {
        let folder = TempDir::new().unwrap();
        let fmu = Model::Integrator.fmu();
        let fmu = fmu.to_str().unwrap();
        let arguments = ["simulate", fmu, "-q", "-o", results, "--snapshot-every", "0.3"];
        let arguments = [&arguments[..], &["--snapshot-file", "s.snapshot"]].concat();
        let operations = observed(folder.path(), &arguments);
        let real = folder.path().canonicalize().unwrap();
        let (snapshot, results) = (real.join("s.snapshot"), real.join(results));
        let renames = operations.iter().filter(|o| matches!(o, Rename(_, to) if *to == snapshot));
        assert!(renames.count() >= 3, "{operations:?}");
        let mut disk = Disk::default();
        // The number of bytes of results that are written when a snapshot gets its name.
        let mut needed: BTreeMap<u64, u64> = BTreeMap::new();
        for (at, operation) in operations.iter().enumerate() {
            disk.apply(operation);
            if let (Rename(_, to), Some(&file)) = (operation, disk.names.get(&snapshot))
                && *to == snapshot
            {
                let of = disk.names.get(&results).and_then(|file| disk.written.get(file));
                needed.insert(file, of.copied().unwrap_or_default());
            }
            for (file, bytes) in disk.after_a_cut(&snapshot) {
                let whole = disk.written[&file];
                assert!(bytes == whole && whole > 0, "cut after {at}: {bytes} of {whole} bytes");
                let kept = disk.after_a_cut(&results);
                let least = kept.iter().map(|(_, bytes)| *bytes).min().unwrap_or_default();
                assert!(least >= needed[&file], "cut after {at}: {least} of {}", needed[&file]);
            }
        }
        // At the end everything is there.
        let file = disk.names[&results];
        assert_eq!(disk.kept.get(&results), Some(&file));
        assert_eq!(disk.synced[&file], disk.written[&file]);
    }
}

/// Whatever gets a name when it is complete is the old file or the new one, at whatever operation the
/// power fails; results that are continued then have at least what they had.
#[test]
fn what_is_replaced_as_a_whole_survives_a_cut_at_every_write() {
    let folder = TempDir::new().unwrap();
    let real = folder.path().canonicalize().unwrap();
    let fmu = Model::Integrator.fmu();
    let fmu = fmu.to_str().unwrap();
    let system = Ssd::new().add("i", Model::Integrator).stop(1.0);
    std::fs::copy(system.write(), real.join("s.ssd")).unwrap();
    let campaign = "seeds = 2\n[systems]\na = 's.ssd'\n[figures.f]\nkind = 'max'\nof = 'i.y'\n";
    std::fs::write(real.join("c.toml"), campaign).unwrap();
    let saving = ["--snapshot-file", "s.snapshot", "--snapshot-at", "0.5"];
    let commands = [
        (vec!["convert", "s.ssd", "s.ssp"], "s.ssp"),
        ([&["simulate", fmu, "-o", "out.csv"], &saving[..]].concat(), "s.snapshot"),
        (vec!["simulate", fmu, "-o", "out.csv", "--resume", "s.snapshot"], "out.csv"),
        (vec!["report", "out.csv", "-o", "out.html"], "out.html"),
        (vec!["campaign", "c.toml", "--output-dir", "r", "--jobs", "1"], "r/summary.json"),
    ];
    for (arguments, wanted) in commands {
        let operations = observed(folder.path(), &arguments);
        std::fs::remove_file(folder.path().join("operations")).unwrap();
        let renamed: Vec<&PathBuf> = operations
            .iter()
            .filter_map(|o| if let Rename(_, to) = o { Some(to) } else { None })
            .collect();
        assert!(renamed.contains(&&real.join(wanted)), "{arguments:?}: {operations:?}");
        let (mut disk, mut complete) = (Disk::default(), BTreeMap::new());
        for (at, operation) in operations.iter().enumerate() {
            disk.apply(operation);
            if let Rename(_, to) = operation {
                let file = disk.names[to];
                complete.insert(file, disk.written[&file]);
            }
            for name in &renamed {
                for (file, bytes) in disk.after_a_cut(name) {
                    let whole = complete[&file];
                    assert!(
                        bytes >= whole && whole > 0,
                        "{arguments:?}, cut after {at}: {bytes} of {whole} bytes of {}",
                        name.display()
                    );
                }
            }
        }
        let log = real.join("r/runs.jsonl");
        if let Some(file) = disk.names.get(&log) {
            assert_eq!(disk.kept.get(&log), Some(file));
            assert_eq!(disk.synced[file], disk.written[file]);
        }
    }
}

/// A killed process leaves no hidden file, and the next run removes those of the previous one.
#[test]
fn nothing_hidden_is_left_beside_the_results() {
    let folder = TempDir::new().unwrap();
    let fmu = Model::Integrator.fmu();
    let fmu = fmu.to_str().unwrap();
    let run = |more: &[&str]| {
        let first = ["simulate", fmu, "-q", "-o", "out.csv", "--snapshot-file", "s.snapshot"];
        let output = crate::command::cosim(folder.path(), &[&first[..], more].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stderr)
    };
    run(&["--snapshot-at", "0.5"]);
    for name in [".out.csv.999999-0.unfinished", ".s.snapshot.999999-3.unfinished"] {
        std::fs::write(folder.path().join(name), "of a killed process").unwrap();
    }
    run(&["--resume", "s.snapshot", "--snapshot-at", "0.8"]);
    let entries = std::fs::read_dir(folder.path()).unwrap().flatten();
    let mut names: Vec<_> = entries.map(|entry| entry.file_name()).collect();
    names.sort();
    assert_eq!(names, ["out.csv", "s.snapshot"]);
}

#[test]
fn a_run_that_was_over_is_resumed_with_success() {
    let folder = TempDir::new().unwrap();
    let fmu = Model::Integrator.fmu();
    let fmu = fmu.to_str().unwrap();
    let run = |more: &[&str]| {
        let first = ["simulate", fmu, "-o", "out.csv", "--snapshot-file", "s.snapshot"];
        let output = crate::command::cosim(folder.path(), &[&first[..], more].concat());
        (output.status.code(), text(&output.stderr))
    };
    assert_eq!(run(&["--snapshot-at", "1"]).0, Some(0));
    let before = std::fs::read(folder.path().join("out.csv")).unwrap();
    let (code, shown) = run(&["--resume", "s.snapshot"]);
    assert_eq!(code, Some(0), "{shown}");
    assert!(shown.contains("nothing is left"), "{shown}");
    assert_eq!(std::fs::read(folder.path().join("out.csv")).unwrap(), before);
    let (code, shown) = run(&["--resume", "s.snapshot", "--stop-time", "0.5"]);
    assert_eq!(code, Some(3), "{shown}");
}
