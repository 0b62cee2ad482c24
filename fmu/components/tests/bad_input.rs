//! Invalid courses, through the C interface: `fmi2Error` and one line that names function,
//! variable, file, line of the file and reason.
#![allow(unsafe_code, reason = "calls of the C interface as an importer makes them")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each is a call of the C interface as an importer makes it"
)]
#![allow(unreachable_pub, reason = "shared with the tests of the kit")]

mod components {
    pub use rexrov_fmu::{REGISTRY, fmi2};
}
#[expect(dead_code, reason = "shared with the tests of the kit")]
#[path = "../../tests/fmi2/driver.rs"]
mod driver;

use std::ffi::CString;
use std::fs;
use std::path::{Path, PathBuf};

use driver::{CS, Fmu};
use fmu_kit::kernel::Status;

/// A folder of this process, removed at the end of the test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("course {name} {}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn uri(&self) -> String {
        format!("file://{}", self.0.display())
    }

    fn file(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.join(name);
        fs::write(&path, bytes).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn follower(course: &Path, resources: Option<&str>) -> Fmu {
    let mut fmu = Fmu::with("PurePursuit", CS, 0, resources).unwrap();
    let course = CString::new(course.to_str().unwrap()).unwrap();
    assert_eq!(fmu.set_string("course", &course), Status::Ok);
    fmu
}

/// The one log line of an initialization that must fail.
fn refusal(course: &Path, resources: Option<&str>) -> String {
    let mut fmu = follower(course, resources);
    assert_eq!((fmu.setup(0.0), fmu.enter()), (Status::Ok, Status::Ok));
    assert_eq!(fmu.exit(), Status::Error, "{course:?}");
    let lines = fmu.log();
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert_eq!(lines[0].status, Status::Error);
    assert!(!lines[0].text.contains(char::is_control), "{:?}", lines[0].text);
    // The instance survives: another course works.
    unsafe { components::fmi2::fmi2Reset(fmu.c) };
    assert_eq!((fmu.setup(0.0), fmu.initialize()), (Status::Ok, Status::Ok));
    lines[0].text.clone()
}

#[test]
fn a_bad_file_is_told_with_its_line_and_the_reason() {
    let folder = Folder::new("contents");
    let mut lone = b"x,y,radius\n0,0\n".to_vec();
    lone.extend([b'9'; 100_000]);
    let cases: [(&[u8], &str); 17] = [
        (b"", ", course: needs at least two points, has 0"),
        (b"\n# nothing\n\n", ", course: needs at least two points, has 0"),
        (b"1,2\n", ", course: needs at least two points, has 1"),
        (b"x,y\n0,0\n# turn\n0,0,5\n", ", line 4: (0, 0) repeats the point before"),
        (b"0,0\nnan,0\n", ", line 2: (NaN, 0, 0) must be finite"),
        (b"0,0\n1,inf\n", ", line 2: (1, inf, 0) must be finite"),
        (b"0,0\n1e999,0\n", ", line 2: (inf, 0, 0) must be finite"),
        (b"0,0\n1e200,0\n", "0, 0) is beyond 1e9 m"),
        (b"0,0\n9,0,-1\n9,9\n", ", line 2: radius -1 must not be negative"),
        (b"0,0\r\n9,0,20\r\n9,9\r\n", ", line 2: radius 20 is too large"),
        (
            b"0,0\n1,2,3,4,5\n",
            ", line 2: expected `x,y`, `x,y,radius` or `x,y,radius,z`, found `1,2,3,4,5`",
        ),
        (b"0;0\n1;1\n", ", line 1: expected `x,y`, `x,y,radius` or `x,y,radius,z`, found `0;0`"),
        (b"north,east\n0,0\n", ", line 1: x = `north` is not a number"),
        (b"0,0\r9,0\r9,9", ", line 1: y = `0\\r9` is not a number"),
        (b"0,0\n\x00\x01\x1b[2J,\n", ", line 2: x = `\\0\\u{1}\\u{1b}[2J` is not a number"),
        (b"0,0\n1,1\n\xff\xfe\x00garbage\n", ", line 3: not text in UTF-8"),
        (
            &lone,
            ", line 3: expected `x,y`, `x,y,radius` or `x,y,radius,z`, found `9999999999999999999999999999999",
        ),
    ];
    for (number, (bytes, expected)) in cases.into_iter().enumerate() {
        let path = folder.file(&format!("{number}.csv"), bytes);
        let line = refusal(&path, None);
        let start = format!("fmi2ExitInitializationMode: course: {path:?}");
        assert!(line.starts_with(&start) && line.contains(expected), "{line}");
        assert!(line.len() < 500, "{line}");
    }
}

#[test]
fn a_file_that_cannot_be_read_is_told_with_the_reason() {
    let folder = Folder::new("files");
    let large = folder.file("large.csv", b"0,0\n1,1\n");
    fs::File::options().write(true).open(&large).unwrap().set_len(1 << 40).unwrap();
    let locked = folder.file("locked.csv", b"0,0\n1,1\n");
    let mut permissions = fs::metadata(&locked).unwrap().permissions();
    std::os::unix::fs::PermissionsExt::set_mode(&mut permissions, 0);
    fs::set_permissions(&locked, permissions).unwrap();
    // The superuser can read everything, but no one can read this.
    let locked = if fs::read(&locked).is_ok() { Path::new("/proc/self/mem") } else { &*locked };
    for (path, reason) in [
        (&*folder.0, "it is a folder, not a file"),
        (Path::new("/dev/zero"), "it is a device or a pipe, not a file"),
        (&large, "it has more than 16 MiB"),
        (locked, ""),
    ] {
        let line = refusal(path, None);
        assert!(line.contains(&format!("course: cannot read {path:?}: {reason}")), "{line}");
    }
}

#[test]
fn missing_files_and_resources_are_told_with_the_places_that_were_searched() {
    let folder = Folder::new("resources");
    let none = Path::new("no such.csv");
    let line = refusal(none, Some(&folder.uri()));
    assert!(
        line.contains("\"no such.csv\" is neither a built-in course (BE1, BE2, BE3, DIVE, HELIX)"),
        "{line}"
    );
    assert!(line.contains(&format!("there is no {:?} and no ", folder.0.join(none))), "{line}");
    let not_a_folder = folder.file("file", b"");
    for location in ["file:///there/is/nothing", not_a_folder.to_str().unwrap(), "http://x/y", "%"]
    {
        let line = refusal(none, Some(location));
        assert!(line.contains("no such.csv"), "{line}");
    }
    assert!(refusal(Path::new(""), None).contains("\"\" is neither"), "an empty name");
    // The FMU's own resources may be invalid, too.
    folder.file("own.csv", b"0,0\n1\n");
    let line = refusal(Path::new("own.csv"), Some(&folder.uri()));
    let start = format!("course: {:?}, line 2: expected", folder.0.join("own.csv"));
    assert!(line.contains(&start), "{line}");
}

#[test]
fn byte_order_marks_line_ends_and_spaces_do_not_matter() {
    let folder = Folder::new("good");
    let path =
        folder.file("ü 1.csv", "\u{feff}x, y, radius\r\n0,0\r\n 25 , 0,5\r\n25,20".as_bytes());
    for (course, location) in [(&*path, None), (Path::new("ü 1.csv"), Some(folder.uri()))] {
        let mut fmu = follower(course, location.as_deref());
        assert_eq!((fmu.setup(0.0), fmu.initialize()), (Status::Ok, Status::Ok));
        assert_eq!(fmu.step(0.0, 1.0), Status::Ok);
        assert_eq!(fmu.log(), []);
    }
}
