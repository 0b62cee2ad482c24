//! Archives that must not be unpacked.

use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;

use cosim::fmi::{Fmu, archive};
use tempfile::TempDir;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use crate::models::{Model, pack};

fn archive_of(folder: &TempDir, entries: &[(&str, Vec<u8>)]) -> PathBuf {
    let path = folder.path().join("x.fmu");
    pack(&path, entries);
    path
}

fn refused(entry: &str, bytes: Vec<u8>) -> String {
    let folder = TempDir::new().unwrap();
    let path = archive_of(&folder, &[("modelDescription.xml", vec![]), (entry, bytes)]);
    let error = Fmu::open(&path).err().expect(entry).to_string();
    assert!(error.contains("E102") && error.contains(entry), "{error}");
    error
}

#[test]
fn names_that_leave_the_folder() {
    assert!(refused("../x", vec![]).contains("outside"));
    assert!(refused("a/../../x", vec![]).contains("outside"));
    assert!(refused("/tmp/cosim-absolute", vec![]).contains("outside"));
    assert!(refused("a\\b", vec![]).contains("backslash"));
    assert!(!std::path::Path::new("/tmp/cosim-absolute").exists());
}

#[test]
fn an_absurd_ratio() {
    assert!(refused("resources/zeros", vec![0; 64 << 20]).contains("ratio"));
}

#[test]
fn links() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("x.fmu");
    let mut zip = ZipWriter::new(std::fs::File::create(&path).unwrap());
    zip.add_symlink("resources", "/etc", SimpleFileOptions::default()).unwrap();
    zip.finish().unwrap();
    let error = Fmu::open(&path).err().unwrap().to_string();
    assert!(error.contains("symbolic link") && error.contains("'resources'"), "{error}");
}

#[test]
fn too_many_entries() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("x.fmu");
    let mut zip = ZipWriter::new(std::fs::File::create(&path).unwrap());
    for entry in 0..10_001 {
        zip.start_file(format!("{entry}"), SimpleFileOptions::default()).unwrap();
    }
    zip.finish().unwrap();
    assert!(Fmu::open(&path).err().unwrap().to_string().contains("10001 entries"));
}

#[test]
fn cut_or_no_archive_at_all() {
    let folder = TempDir::new().unwrap();
    let whole = std::fs::read(Model::Gain.fmu()).unwrap();
    let path = folder.path().join("cut.fmu");
    for length in [0, 10, whole.len() / 2, whole.len() - 1] {
        std::fs::File::create(&path).unwrap().write_all(&whole[..length]).unwrap();
        let error = Fmu::open(&path).err().expect("cut").to_string();
        assert!(error.contains("E102"), "{error}");
    }
}

#[test]
fn the_unpacked_folder_is_private_and_vanishes() {
    let folder = archive::unpack(&Model::Gain.fmu()).unwrap();
    let path = folder.path().to_owned();
    assert_eq!(path.metadata().unwrap().permissions().mode() & 0o777, 0o700);
    assert!(path.join("modelDescription.xml").is_file());
    drop(folder);
    assert!(!path.exists());
}

#[test]
fn one_file_is_unpacked_once_while_in_use() {
    let path = Model::Gain.fmu();
    let (first, second) = (Fmu::open(&path).unwrap(), Fmu::open(&path).unwrap());
    assert!(std::sync::Arc::ptr_eq(&first, &second));
}
