//! Archives that are refused, each by one entry that is named.

use std::path::Path;

use super::Workspace;
use crate::models::{Model, pack};
use crate::rawzip::{End, Entry, archive, archive_with};

fn good() -> Entry {
    Entry::new("modelDescription.xml", Model::Gain.description().as_bytes())
}

/// An entry with something changed.
fn bad(name: impl AsRef<[u8]>, change: impl Fn(&mut Entry)) -> Entry {
    let mut entry = Entry::new(name, b"content");
    change(&mut entry);
    entry
}

#[test]
fn the_archives_of_these_tests_are_good_but_for_one_thing() {
    let workspace = Workspace::new();
    let entries =
        [good(), bad("resources/x", |_| ()), bad("resources/sub/", |e| e.content.clear())];
    let (code, shown) = workspace.run("info", "good.fmu", &archive(&entries));
    assert_eq!(code, 0, "{shown}");
}

#[test]
fn names_that_leave_the_folder_or_mean_something_else_elsewhere() {
    let workspace = Workspace::new();
    let deep = "d/".repeat(33) + "x";
    let long = "x".repeat(256);
    for (name, shown, why) in [
        ("../x", "../x", "outside"),
        ("resources/../../x", "resources/../../x", "outside"),
        ("/tmp/cosim-absolute", "/tmp/cosim-absolute", "absolute"),
        ("//host/share", "//host/share", "absolute"),
        ("C:/x", "C:/x", "drive"),
        ("c:x", "c:x", "drive"),
        ("..\\x", "..\\\\x", "outside"),
        ("a\\..\\..\\x", "a\\\\..\\\\..\\\\x", "outside"),
        ("\\\\host\\share", "\\\\\\\\host\\\\share", "absolute"),
        ("C:\\x", "C:\\\\x", "drive"),
        ("x\0.txt", "x\\0.txt", "control"),
        ("x\n.txt", "x\\n.txt", "control"),
        ("././", "././", "empty"),
        (&deep, "d/d/d", "too deep"),
        (&long, "xxx", "too long"),
    ] {
        let bytes = archive(&[good(), bad(name, |_| ())]);
        workspace.refuses("x.fmu", &bytes, &["[E102]", "x.fmu", shown, why]);
    }
    assert!(!Path::new("/tmp/cosim-absolute").exists());
}

#[test]
fn names_that_meet() {
    let workspace = Workspace::new();
    let with = |names: &[&str]| {
        let mut entries = vec![good()];
        entries.extend(names.iter().map(|name| bad(name, |_| ())));
        archive(&entries)
    };
    for (names, shown) in [
        (&["resources/a", "resources/a"][..], "'resources/a'"),
        (&["resources/a", "resources/A"], "'resources/A'"),
        (&["RESOURCES/a", "resources/a"], "'resources/a'"),
        (&["resources/a", "./resources//a"], "'./resources//a'"),
        (&["resources/a", "resources\\a"], "'resources\\\\a'"),
        (&["resources//a", "resources/./a"], "'resources/./a'"),
        (&["resources/a/", "resources//a"], "'resources//a'"),
        (&["modelDescription.XML"], "'modelDescription.XML'"),
        (&["resources/ä", "resources/Ä"], "'resources/Ä'"),
        (&["resources", "resources/a"], "'resources/a'"),
        (&["resources/a", "resources"], "'resources'"),
    ] {
        workspace.refuses("x.fmu", &with(names), &["[E102]", shown]);
    }
}

/// Unusual, but valid files inside the folder.
#[test]
fn names_that_are_only_names_here() {
    let names = [
        "resources/CON",
        "nul.txt",
        "resources/a.",
        "resources/a",
        "resources/a ",
        "resources/a:b",
    ];
    let mut entries = vec![good(), bad("b//c", |_| ()), bad("./b/./d", |_| ())];
    entries.extend(names.map(|name| bad(name, |_| ())));
    let bytes = std::io::Cursor::new(archive(&entries));
    let unpacked = cosim::fmi::archive::unpack_from(bytes, Path::new("x.fmu")).unwrap();
    for name in names.iter().chain(&["b/c", "b/d"]) {
        assert!(unpacked.path().join(name).is_file(), "{name}");
    }
}

#[test]
fn links_and_devices() {
    let workspace = Workspace::new();
    for (mode, why) in [
        (0o120_777, "symbolic link"),
        (0o020_666, "device"),
        (0o060_666, "device"),
        (0o010_666, "special file"),
        (0o140_666, "special file"),
    ] {
        let bytes = archive(&[good(), bad("resources/thing", |e| e.mode = mode)]);
        workspace.refuses("x.fmu", &bytes, &["[E102]", "'resources/thing'", why]);
    }
}

#[test]
fn sizes_and_contents_that_lie() {
    let workspace = Workspace::new();
    let zip64 = |size: u64, packed: u64| {
        let mut extra = vec![1, 0, 16, 0];
        extra.extend(size.to_le_bytes());
        extra.extend(packed.to_le_bytes());
        extra
    };
    let huge = |e: &mut Entry| {
        (e.size, e.packed) = (Some(u32::MAX), Some(u32::MAX));
        e.extra = zip64(1 << 60, 1 << 60);
    };
    let ratio = |e: &mut Entry| {
        (e.size, e.packed) = (Some(u32::MAX), Some(7));
        e.extra = zip64(1 << 40, 7);
    };
    for (change, why) in [
        (&(|e: &mut Entry| e.size = Some(3)) as &dyn Fn(&mut Entry), "larger"),
        (&|e| e.size = Some(9), "9 bytes"),
        (&|e| e.crc = Some(5), "cannot be unpacked"),
        (&|e| e.flags |= 1, "encrypted"),
        (&|e| e.method = 12, "compression"),
        (&|e| e.method = 99, ""),
        (&|e| e.method = 8, "cannot be unpacked"),
        (&huge, "ratio"),
        (&ratio, "ratio"),
        (&|e| e.packed = Some(1 << 30), "beyond the end"),
    ] {
        let bytes = archive(&[good(), bad("resources/x", change)]);
        workspace.refuses("x.fmu", &bytes, &["[E102]", "'resources/x'", why]);
    }
}

#[test]
fn entries_that_share_bytes() {
    let workspace = Workspace::new();
    let mut entries = vec![good(), Entry::new("resources/0", &[b'x'; 5000])];
    for number in 1..500 {
        let mut entry = Entry::new(format!("resources/{number}"), &[b'x'; 5000]);
        entry.shared = true;
        entries.push(entry);
    }
    workspace.refuses("x.fmu", &archive(&entries), &["[E102]", "'resources/1'", "shares bytes"]);
}

#[test]
fn ends_of_archives_that_lie() {
    let workspace = Workspace::new();
    let of = |end| archive_with(&[good(), bad("x", |_| ())], end);
    for end in [
        End { disk: 1, entries: None },
        End { disk: 0, entries: Some(3) },
        End { disk: 0, entries: Some(0xffff) },
        End { disk: 0, entries: Some(0) },
    ] {
        let (code, shown) = workspace.run("info", "x.fmu", &of(end));
        assert_eq!(code, 3, "{shown}");
        assert!(shown.contains("[E102]") && shown.contains("x.fmu"), "{shown}");
    }
}

#[test]
fn bombs() {
    let workspace = Workspace::new();
    let packed = workspace.folder.path().join("packed");
    let zeros = || vec![0; 40 << 20];
    pack(&packed, &[("modelDescription.xml", vec![]), ("resources/zeros", zeros())]);
    let parts = ["'resources/zeros'", "ratio"];
    workspace.refuses("x.fmu", &std::fs::read(&packed).unwrap(), &parts);
    // Many entries, each below the limit for one.
    let names: Vec<String> = (0..20).map(|n| format!("resources/{n}")).collect();
    let entries: Vec<_> = names.iter().map(|n| (n.as_str(), vec![0; 9 << 20])).collect();
    pack(&packed, &entries);
    workspace.refuses(
        "x.fmu",
        &std::fs::read(&packed).unwrap(),
        &["'resources/1", "of the archive"],
    );
    std::fs::remove_file(&packed).unwrap();
    let many: Vec<Entry> = (0..10_001).map(|n| Entry::new(format!("{n}"), b"")).collect();
    workspace.refuses("x.fmu", &archive(&many), &["10001 entries", "10000"]);
}

#[test]
fn folders_that_are_only_parts_of_names() {
    let workspace = Workspace::new();
    let path = |n: usize| (0..28).map(|level| format!("{n}-{level}/")).collect::<String>() + "x";
    let mut entries = vec![good()];
    entries.extend((0..9_000).map(|n| Entry::new(path(n), b"")));
    let parts = ["[E102]", "20000 files and folders"];
    workspace.refuses("x.fmu", &archive(&entries), &parts);
}
