//! Files that must be refused, through the real binary: each with exit code 3 and the entry or line
//! named, in bounded time and memory, with nothing written outside and nothing left behind.

use std::path::Path;
use std::process::{Command, Stdio};

use tempfile::TempDir;

use crate::command::text;
use crate::models::{Model, pack};
use crate::rawzip::{End, Entry, archive, archive_with};

/// Address space of the binary in KiB, and processor time in seconds: with more it is killed.
const MEMORY: u32 = 3 << 20;
const TIME: u32 = 60;

/// A folder with the file to open and its own temporary folder.
pub(crate) struct Workspace {
    folder: TempDir,
}

impl Workspace {
    pub(crate) fn new() -> Self {
        let folder = TempDir::new().unwrap();
        std::fs::create_dir_all(folder.path().join("a/b/temporary")).unwrap();
        Self { folder }
    }

    /// Writes a file beside the one to open.
    pub(crate) fn put(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.folder.path().join("a/b").join(name), bytes).unwrap();
    }

    /// Runs `cosim VERB FILE` for a file of these bytes: exit code and stderr.
    pub(crate) fn run(&self, verb: &str, name: &str, bytes: &[u8]) -> (i32, String) {
        self.run_in(MEMORY, verb, name, bytes)
    }

    /// The same with a different memory limit, in KiB.
    pub(crate) fn run_in(
        &self,
        memory: u32,
        verb: &str,
        name: &str,
        bytes: &[u8],
    ) -> (i32, String) {
        let inside = self.folder.path().join("a/b");
        std::fs::write(inside.join(name), bytes).unwrap();
        let before = self.files();
        let limit = format!("ulimit -v {memory}; ulimit -t {TIME}; exec \"$@\"");
        let output = Command::new("sh")
            .args(["-c", &limit, "sh", env!("CARGO_BIN_EXE_cosim")])
            .args(verb.split(' '))
            .arg(name)
            .current_dir(&inside)
            .env("TMPDIR", inside.join("temporary"))
            .env("NO_COLOR", "1")
            .stdin(Stdio::null())
            .output()
            .unwrap();
        assert_eq!(self.files(), before, "{name}");
        let code = output.status.code();
        let shown = text(&output.stderr);
        (code.unwrap_or_else(|| panic!("{}: {shown}", output.status)), shown)
    }

    /// Every file and folder, to check that nothing was added.
    fn files(&self) -> Vec<String> {
        fn walk(folder: &Path, found: &mut Vec<String>) {
            for entry in std::fs::read_dir(folder).unwrap().flatten() {
                found.push(entry.path().display().to_string());
                if entry.file_type().unwrap().is_dir() {
                    walk(&entry.path(), found);
                }
            }
        }
        let mut found = Vec::new();
        walk(self.folder.path(), &mut found);
        found.sort();
        found
    }

    fn refuses(&self, name: &str, bytes: &[u8], parts: &[&str]) {
        let (code, shown) = self.run("info", name, bytes);
        assert_eq!(code, 3, "{name}: {shown}");
        for part in parts {
            assert!(shown.contains(part), "{name}: {part} in {}", &shown[..shown.len().min(2000)]);
        }
        assert!(!shown.contains("panicked"), "{name}: {shown}");
    }
}

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

/// An archive whose description is `text`.
pub(crate) fn described(text: impl AsRef<[u8]>) -> Vec<u8> {
    archive(&[Entry::new("modelDescription.xml", text.as_ref())])
}

pub(crate) fn with_variables(variables: &str) -> String {
    let all = Model::Gain.description();
    all.replace("<ModelVariables>", &format!("<ModelVariables>{variables}"))
}

#[test]
fn xml_that_is_no_description() {
    let workspace = Workspace::new();
    let root = "<fmiModelDescription fmiVersion='2.0'";
    let laughs: String = (1..10)
        .map(|n| format!("<!ENTITY l{n} '{}'>", format!("&l{};", n - 1).repeat(10)))
        .collect();
    let bomb = format!("<!DOCTYPE x [<!ENTITY l0 'ha'>{laughs}]>\n{root}>&l9;</x>");
    let external = "<!DOCTYPE x SYSTEM 'file:///etc/passwd'>\n<x/>";
    let wide: String = (0..100_000).map(|n| format!(" a{n}='1'")).collect();
    for (bytes, parts) in [
        (bomb.as_bytes().to_vec(), &["modelDescription.xml:1", "DTD"][..]),
        (external.into(), &[":1", "DTD"]),
        (format!("{root} guid='&l9;'/>").into(), &[":1", "l9"]),
        ("<a>".repeat(100_000).into(), &[":1", "64 levels"]),
        (format!("{root}{wide}/>").into(), &[":1", "256 attributes"]),
        ("\n<a>".repeat(2_000_001).into(), &["nested too deeply"]),
        (format!("<a>{}", "<b/>".repeat(2_000_001)).into(), &["2000000 elements"]),
        (format!("<{}/>", "a".repeat(1 << 20)).into(), &["a name of 1048576 bytes"]),
        (format!("{root}\nguid='\u{e9}'/>").replace('\u{e9}', "?").into(), &[":1", "UTF-8"]),
    ] {
        let bytes = match parts.last() {
            // A byte of Latin-1 in the second line.
            Some(&"UTF-8") => {
                let mut bytes: Vec<u8> = bytes;
                let at = bytes.iter().position(|&b| b == b'?').unwrap();
                bytes[at] = 0xe9;
                bytes
            }
            _ => bytes,
        };
        let parts: Vec<&str> = parts
            .iter()
            .map(|p| if *p == ":1" && bytes.contains(&0xe9) { ":2" } else { p })
            .collect();
        workspace.refuses(
            "x.fmu",
            &described(bytes),
            &[&["[E103]", "modelDescription.xml"], &parts[..]].concat(),
        );
    }
}

#[test]
fn encodings() {
    let workspace = Workspace::new();
    let description = Model::Gain.description();
    let utf16: Vec<u8> =
        [0xfeff].into_iter().chain(description.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    workspace.refuses("x.fmu", &described(utf16), &["[E103]", "UTF-16"]);
    let declared = |name: &str, text: &str| {
        description.replace("UTF-8", name).replace("modelName=\"GAIN\"", text)
    };
    workspace.refuses(
        "x.fmu",
        &described(declared("windows-1252", "modelName=\"Gerät\"")),
        &["[E103]", ":1", "windows-1252"],
    );
    workspace.refuses("x.fmu", &described(declared("UTF-16", "")), &["[E103]", ":1", "UTF-16"]);
    // ASCII is the same in both.
    let (code, shown) =
        workspace.run("info", "x.fmu", &described(declared("ISO-8859-1", "modelName='g'")));
    assert_eq!(code, 0, "{shown}");
    let marked = [&[0xef, 0xbb, 0xbf], description.as_bytes()].concat();
    assert_eq!(workspace.run("info", "x.fmu", &described(marked)).0, 0);
}

#[test]
fn other_versions_numbers_and_names() {
    let workspace = Workspace::new();
    let description = Model::Gain.description();
    for (from, to, parts) in [
        ("fmiVersion=\"2.0\"", "fmiVersion=\"1.0\"", &[":2", "FMI version 1.0"][..]),
        ("fmiVersion=\"2.0\" ", "fmiVersion=\"3.0\" ", &[":2", "FMI version 3.0", "FMI 2.0"]),
        ("valueReference=\"3\"", "valueReference=\"4294967296\"", &[":12", "4294967296"]),
        ("valueReference=\"3\"", "valueReference=\"-1\"", &[":12", "-1"]),
        ("index=\"3\"", "index=\"18446744073709551616\"", &[":22", "18446744073709551616"]),
        ("numberOfEventIndicators", "x", &[]),
        ("guid=\"{test}\"", "guid=\"{test}\" numberOfEventIndicators=\"-1\"", &[":2", "-1"]),
        ("stopTime=\"1\"", "stopTime=\"one\"", &["stopTime=\"one\""]),
        ("canGetAndSetFMUstate=\"true\"", "canGetAndSetFMUstate=\"yes\"", &[":3", "yes"]),
        ("maxOutputDerivativeOrder", "", &[]),
    ] {
        if description.contains(from) {
            let bytes = described(description.replace(from, to));
            let code = if from.starts_with("fmiVersion") { "[E106]" } else { "[E104]" };
            workspace.refuses("x.fmu", &bytes, &[&[code, "modelDescription.xml"], parts].concat());
        }
    }
}

#[test]
fn floods_of_variables_types_and_dependencies_end_in_time() {
    let workspace = Workspace::new();
    let many = |count: usize, inside: &str| -> String {
        (0..count)
            .map(|n| {
                format!(
                    "<ScalarVariable name='v{n}' valueReference='{n}' {inside}</ScalarVariable>\n"
                )
            })
            .collect()
    };
    // Outputs that the structure does not list.
    let outputs = many(200_000, "causality='output'><Real/>");
    let (code, shown) =
        workspace.run("validate", "outputs.fmu", &described(with_variables(&outputs)));
    assert_eq!(code, 0, "{shown}");
    assert!(shown.contains("no binary for this machine"), "{shown}");
    // One long type of many variables: it is stored once.
    let items: String = (0..50_000).map(|n| format!("<Item name='i{n}' value='{n}'/>")).collect();
    let typed = many(50_000, "><Enumeration declaredType='Mode' start='1'/>");
    let text = with_variables(&typed).replace("<Item name=\"Slow\" value=\"1\"/>", &items);
    let (code, shown) = workspace.run("validate", "types.fmu", &described(text));
    assert_eq!(code, 0, "{shown}");
    // The same name again, at the end of many.
    let twice = format!(
        "{}<ScalarVariable name='v0' valueReference='0'><Real/></ScalarVariable>",
        many(100_000, "><Real/>")
    );
    workspace.refuses("twice.fmu", &described(with_variables(&twice)), &["'v0'", "declared twice"]);
    let list = "1 ".repeat(20_000_001);
    let text = Model::Gain
        .description()
        .replace("dependencies=\"1\"", &format!("dependencies=\"{list}\""));
    workspace.refuses("dependencies.fmu", &described(text), &[":22", "20000000 dependencies"]);
}

#[test]
fn what_fmi_does_not_have_is_reported() {
    let workspace = Workspace::new();
    let folder = workspace.folder.path().join("outside");
    std::fs::create_dir(&folder).unwrap();
    let fmu = Model::Gain.variant(&folder.join("x.fmu"), &[], |description| {
        description.replace("causality=\"input\"><Real", "causalty=\"input\"><Real").replace(
            "<DefaultExperiment",
            "<Surprise/><DefaultExperiment xsi:x=\"1\" xmlns:xsi=\"u\"",
        )
    });
    let bytes = std::fs::read(fmu).unwrap();
    std::fs::remove_dir_all(folder).unwrap();
    let (code, shown) = workspace.run("validate", "x.fmu", &bytes);
    assert_eq!(code, 0, "{shown}");
    for part in ["'causalty' of <ScalarVariable>", "'causality'?", "<Surprise>", "xml:9", "xml:7"] {
        assert!(shown.contains(part), "{part} in {shown}");
    }
    assert!(!shown.contains("xsi"), "{shown}");
}

#[test]
fn a_wrong_guid_is_refused_by_the_fmu_and_reported() {
    let workspace = Workspace::new();
    let folder = workspace.folder.path().join("outside");
    std::fs::create_dir(&folder).unwrap();
    let fmu = Model::Gain.variant(&folder.join("x.fmu"), &[], |d| d.replace("{test}", "{other}"));
    let bytes = std::fs::read(fmu).unwrap();
    std::fs::remove_dir_all(folder).unwrap();
    let (code, shown) = workspace.run("simulate -o -", "x.fmu", &bytes);
    // Only running it shows the problem: the library decides.
    assert_eq!(code, 1, "{shown}");
    assert!(shown.contains("returned NULL") && shown.contains("wrong GUID {other}"), "{shown}");
}

/// Found by the fuzz target: a record of 2^64 - 1 bytes, and a string of 4 GiB in a channel.
#[test]
fn results_that_lie_about_their_lengths() {
    let workspace = Workspace::new();
    let length = include_bytes!("hostile_mcap/record_length.mcap");
    let (code, shown) = workspace.run("verify r.mcap", "r.mcap", length);
    assert_eq!(code, 0, "{shown}");
    let length = include_bytes!("hostile_mcap/string_length.mcap");
    let (code, shown) = workspace.run("verify r.mcap", "r.mcap", length);
    assert_eq!(code, 3, "{shown}");
    assert!(shown.contains("r.mcap") && shown.contains("a channel is damaged"), "{shown}");
}

/// A tree takes a bounded multiple of its text: a namespace shared by all elements, names that
/// occur a million times, a million attributes. If that is too much, it is refused in time.
#[test]
fn small_files_that_would_become_large_trees() {
    let workspace = Workspace::new();
    let root = "<fmiModelDescription fmiVersion='2.0'";
    let children = "<b/>".repeat(250_000);
    let namespaced =
        format!("{root} xmlns='{}'>{children}</fmiModelDescription>", "n".repeat(60_000));
    let deep = format!("<{0} xmlns:{0}='{0}'>", "p".repeat(1000)).repeat(60);
    let prefixed = format!("{root}>{deep}");
    let attributes: String = (0..250).map(|n| format!(" a{n}=''")).collect();
    let wide = format!("<b{attributes}/>").repeat(60_000);
    let wide = format!("{root}>{wide}</fmiModelDescription>");
    let long = format!("{root} guid='{}'/>", "x".repeat(40 << 20));
    for text in [&namespaced, &prefixed, &wide, &long] {
        let (code, shown) = workspace.run_in(1 << 20, "info", "x.fmu", &described(text));
        assert!(matches!(code, 0 | 3), "{code}: {}: {shown}", &text[..100]);
    }
    let (_, shown) = workspace.run_in(1 << 20, "info", "x.fmu", &described(&wide));
    assert!(shown.contains("[E103]") && shown.contains("takes too much memory"), "{shown}");
    // The same in a system, and in the parameters that it names.
    let system = namespaced.replace("fmiModelDescription", "ssd:SystemStructureDescription");
    let system = system.replacen(
        "xmlns=",
        "xmlns:ssd='http://ssp-standard.org/SSP1/SystemStructureDescription' xmlns=",
        1,
    );
    let (code, shown) = workspace.run_in(1 << 20, "info", "x.ssd", system.as_bytes());
    assert_eq!(code, 3, "{}", &shown[..shown.len().min(2000)]);
}

#[test]
fn names_too_long_for_a_table() {
    let workspace = Workspace::new();
    let variable = |length: usize| {
        let name = "v".repeat(length);
        let inside = "causality='local'><Real start='1'/>";
        let first =
            format!("<ScalarVariable name='{name}' valueReference='90' {inside}</ScalarVariable>");
        let text = Model::Gain.description();
        described(text.replace("</ModelVariables>", &format!("{first}</ModelVariables>")))
    };
    for length in [65_535, 65_536, 1 << 20] {
        for verb in ["info", "info --format json"] {
            let (code, shown) = workspace.run(verb, "x.fmu", &variable(length));
            assert_eq!(code, 0, "{length} {verb}: {shown}");
        }
    }
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

#[test]
fn a_million_columns_are_compared_in_time() {
    let workspace = Workspace::new();
    let mut table = String::from("time");
    (0..1_000_000).for_each(|n| table.push_str(&format!(",c{n}")));
    table.push_str("\n0");
    table.push_str(&",1".repeat(1_000_000));
    table.push('\n');
    let other = table.replacen("c0,", "d0,", 1).replace("c999999\n", "d999999\n");
    std::fs::write(workspace.folder.path().join("a/b/other.csv"), &other).unwrap();
    let (code, shown) = workspace.run("verify other.csv", "r.csv", table.as_bytes());
    assert_eq!(code, 1, "{shown}");
    assert!(shown.contains("different variables"), "{shown}");
    let header = format!("time{}\n", ",".repeat(2_000_001));
    let (code, shown) = workspace.run("verify r.csv", "r.csv", header.as_bytes());
    assert_eq!(code, 3, "{shown}");
    assert!(shown.contains("2000000 columns"), "{shown}");
}

/// With a million wrong names and a thousand valid ones, the search for suggestions would take
/// hours.
#[test]
fn wrong_names_by_the_thousand_are_reported_in_time() {
    let workspace = Workspace::new();
    let name = |n: usize| format!("{}{n}", "variable_with_a_long_name_".repeat(6));
    let variables: String = (0..2_000)
        .map(|n| {
            let name = name(n);
            format!(
                "<ScalarVariable name='{name}' valueReference='{}'><Real/></ScalarVariable>",
                n + 50
            )
        })
        .collect();
    let description = Model::Gain.description();
    let description =
        description.replace("</ModelVariables>", &format!("{variables}</ModelVariables>"));
    let inside = workspace.folder.path().join("a/b");
    std::fs::write(inside.join("g.fmu"), described(description)).unwrap();
    let connections: String = (0..20_000)
        .map(|n| {
            let wrong = name(n).replace("long", "lang");
            format!(
                "<ssd:Connection startElement='g' startConnector='{wrong}' endElement='g' endConnector='u'/>"
            )
        })
        .collect();
    let system = format!(
        "<ssd:SystemStructureDescription xmlns:ssd='http://ssp-standard.org/SSP1/SystemStructureDescription' \
         version='1.0' name='s'><ssd:System name='s'><ssd:Elements><ssd:Component name='g' \
         type='application/x-fmu-sharedlibrary' source='g.fmu'/></ssd:Elements><ssd:Connections>\
         {connections}</ssd:Connections></ssd:System></ssd:SystemStructureDescription>"
    );
    let (code, shown) = workspace.run("info", "x.ssd", system.as_bytes());
    assert_eq!(code, 3, "{}", &shown[..shown.len().min(2000)]);
    assert!(shown.len() < 1 << 20, "{} bytes are reported", shown.len());
}

/// Control characters are shown escaped, wherever they come from: a name in an FMU, a scenario, a
/// message.
#[test]
fn no_text_of_a_file_commands_the_terminal() {
    let workspace = Workspace::new();
    let inside = workspace.folder.path().join("a/b");
    let hostile = "&#27;]0;owned&#7;&#x9b;2J\u{202e}&#10;error: forged";
    let description = Model::Gain.description().replace("\"GAIN\"", "'GAIN'");
    // The identifier names the library; only the name of the model is free.
    let description =
        description.replacen("modelName='GAIN'", &format!("modelName='{hostile}'"), 1);
    let description = description.replace("&#27;", "&#x1b;");
    std::fs::write(inside.join("x.fmu"), described(&description)).unwrap();
    std::fs::write(
        inside.join("s.json"),
        "{\"events\": [{\"time\": 0, \"model\": \"\\u001b[31m\"}]}",
    )
    .unwrap();
    let fmu = Model::Gain.fmu();
    let fmu = fmu.to_str().unwrap();
    let talking = Model::Gain.variant(
        &workspace.folder.path().join("talking.fmu"),
        &["ATTACK=SAY(1, \"logAll\", \"a\\033]0;owned\\007\\033[2Jb\\nerror: forged\")"],
        |description| description,
    );
    let talking = talking.to_str().unwrap();
    let commands: [&[&str]; 8] = [
        &["info", "x.fmu"],
        &["info", "x.fmu", "--format", "json"],
        &["validate", "x.fmu"],
        &["simulate", "x.fmu", "-o", "-"],
        &["simulate", fmu, "-o", "-", "--scenario", "s.json"],
        &["simulate", talking, "-o", "talked.csv"],
        &["simulate", talking, "-o", "talked.csv", "--debug-logging"],
        &["simulate", talking, "-o", "talked.csv", "--log-fmi-calls"],
    ];
    for verb in commands {
        let output = crate::command::cosim(&inside, verb);
        let shown = text(&output.stdout) + &text(&output.stderr);
        let verb = verb.join(" ");
        for c in shown.chars() {
            assert!(c == '\n' || !c.is_control() && c != '\u{202e}', "{verb}: {shown:?}");
        }
        assert!(!shown.contains("\nerror: forged"), "{verb}: {shown}");
    }
}

#[test]
fn results_never_take_the_place_of_an_input() {
    let workspace = Workspace::new();
    let inside = workspace.folder.path().join("a/b");
    let fmu = std::fs::read(Model::Gain.fmu()).unwrap();
    let ssd = crate::ssd::Ssd::new().add("g", Model::Gain);
    let ssd = std::fs::read(ssd.write()).unwrap();
    std::fs::write(inside.join("in.csv"), "time,u\n0,1\n1,1\n").unwrap();
    std::fs::write(inside.join("other.csv"), "<?xml version='1.0'?><x/>").unwrap();
    for (verb, name, bytes, code) in [
        ("simulate -o x.fmu", "x.fmu", &fmu, 2),
        ("simulate -o ../b/x.fmu", "x.fmu", &fmu, 2),
        ("simulate --digest-file x.fmu -o -", "x.fmu", &fmu, 2),
        ("simulate --input-file in.csv -o in.csv", "x.fmu", &fmu, 2),
        ("simulate -o other.csv", "x.fmu", &fmu, 1),
        ("run -o x.ssd", "x.ssd", &ssd, 2),
        ("simulate --input-file in.csv --log-fmi-calls=in.csv -o -", "x.fmu", &fmu, 2),
        ("simulate --log-fmi-calls=x.fmu -o -", "x.fmu", &fmu, 1),
        ("simulate --snapshot-file x.fmu --snapshot-every 1 -o -", "x.fmu", &fmu, 2),
        ("simulate --snapshot-file x.fmu --snapshot-every 1 -o - --isolate", "x.fmu", &fmu, 2),
        (
            "simulate --input-file in.csv --snapshot-file in.csv --snapshot-every 1 -o -",
            "x.fmu",
            &fmu,
            2,
        ),
        ("simulate --start-value text=in.csv -o in.csv", "x.fmu", &fmu, 2),
        ("convert x.ssd", "x.ssd", &ssd, 1),
        ("report in.csv -o", "in.csv", &b"time,u\n0,1\n1,1\n".to_vec(), 2),
    ] {
        let (found, shown) = workspace.run(verb, name, bytes);
        assert_eq!(found, code, "{verb}: {shown}");
        assert_eq!(&std::fs::read(inside.join(name)).unwrap(), bytes, "{verb}");
    }
    let inputs = std::fs::read_to_string(inside.join("in.csv")).unwrap();
    assert_eq!(inputs, "time,u\n0,1\n1,1\n");
}

#[test]
fn a_missing_temporary_folder_is_named() {
    let folder = TempDir::new().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_cosim"))
        .args(["info", Model::Gain.fmu().to_str().unwrap()])
        .env("TMPDIR", folder.path().join("missing"))
        .output()
        .unwrap();
    let shown = text(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{shown}");
    assert!(shown.contains("no temporary folder can be created"), "{shown}");
    assert!(shown.contains("missing") && shown.contains("TMPDIR"), "{shown}");
}
