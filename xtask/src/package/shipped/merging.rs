//! Tests of merging FMUs of several platforms.

use super::{library, packaged};
use crate::{
    package::{archive, library::Library, merge},
    process,
    python::ZIG,
};
use std::{fs, path::Path, process::Command};

/// A library with all functions of FMI 2.0, which do nothing, for a machine that this is not.
fn foreign(folder: &Path) -> Vec<u8> {
    let functions = Library::read(&library("Gps")).unwrap();
    let text: String = functions.exports().map(|f| format!("void {f}(void) {{}}\n")).collect();
    aarch64(folder, &text)
}

/// A library in C for ARM.
fn aarch64(folder: &Path, text: &str) -> Vec<u8> {
    let (source, output) = (folder.join("foreign.c"), folder.join("foreign.so"));
    fs::write(&source, text).unwrap();
    process::run(
        Command::new(ZIG.interpreter().unwrap())
            .args(["-m", "ziglang", "cc", "-target", "aarch64-linux-gnu.2.17"])
            .args(["-shared", "-nostdlib", "-o"])
            .args([&output, &source])
            .env("ZIG_GLOBAL_CACHE_DIR", ZIG.folder().join("cache"))
            .env("ZIG_LOCAL_CACHE_DIR", ZIG.folder().join("cache")),
    )
    .unwrap();
    fs::read(output).unwrap()
}

#[test]
fn a_call_that_another_library_could_take_is_seen() {
    let folder = tempfile::tempdir().unwrap();
    let seen = |text: &str| {
        let library = Library::read(&aarch64(folder.path(), text)).unwrap();
        library.interposable().map(str::to_owned).collect::<Vec<_>>()
    };
    let own = "void callee(void) {} void caller(void) { callee(); }";
    assert_eq!(seen(own), ["callee"]);
    assert!(seen(&format!("__attribute__((visibility(\"hidden\"))) {own}")).is_empty());
}

#[test]
fn fmus_of_two_platforms_become_one() {
    let folder = tempfile::tempdir().unwrap();
    let [x86, arm, merged] = ["x86", "arm", "merged"].map(|name| folder.path().join(name));
    let library = foreign(folder.path());
    let files = packaged("Gps");
    let other = exchange(&files, "binaries/aarch64-linux/Gps.so", library.clone());
    write(&x86, &files);
    write(&arm, &other);
    let paths = merge::folders(&[x86.clone(), arm.clone()], &merged).unwrap();
    let result = archive::read(&paths[0]).unwrap();
    let listed: Vec<_> = result.iter().map(|(name, _)| name.as_str()).collect();
    let libraries = ["binaries/aarch64-linux/Gps.so", "binaries/linux64/Gps.so"];
    assert_eq!(listed[..3], ["modelDescription.xml", libraries[0], libraries[1]]);
    assert_eq!(result.len(), files.len() + 1);
    // In whatever order, the same bytes.
    let first = fs::read(&paths[0]).unwrap();
    merge::folders(&[arm, x86], &merged).unwrap();
    assert_eq!(fs::read(&paths[0]).unwrap(), first);
}

#[test]
fn what_does_not_fit_is_not_merged() {
    let folder = tempfile::tempdir().unwrap();
    let [one, two, out] = ["one", "two", "out"].map(|name| folder.path().join(name));
    let files = packaged("Gps");
    let arm = "binaries/aarch64-linux/Gps.so";
    let refused = |changed: &[archive::Entry], part: &str| {
        write(&one, &files);
        write(&two, changed);
        let error = merge::folders(&[one.clone(), two.clone()], &out).unwrap_err();
        let text = format!("{error:#}");
        assert!(text.contains(part), "{text}");
        assert!(!out.exists());
    };
    let own = library("Gps");
    refused(&exchange(&files, arm, own.clone()), "built for machine");
    let mut description = exchange(&files, arm, foreign(folder.path()));
    description[0].1.push(b'\n');
    refused(&description, "modelDescription.xml differs");
    let mut grown = own;
    grown.push(0);
    refused(&exchange(&files, "binaries/linux64/Gps.so", grown), "both are for one platform");
    refused(&exchange(&files, "binaries/win64/Gps.dll", Vec::new()), "binaries/win64/Gps.dll");
    let mut short = files.clone();
    short.retain(|(name, _)| name != "model.png");
    refused(&short, "holds model.png");
}

/// The same files with another library in the place of their own.
fn exchange(files: &[archive::Entry], name: &str, library: Vec<u8>) -> Vec<archive::Entry> {
    let mut files = files.to_vec();
    files.retain(|(name, _)| !name.starts_with("binaries/"));
    files.insert(1, (name.to_owned(), library));
    files
}

fn write(folder: &Path, files: &[archive::Entry]) {
    fs::create_dir_all(folder).unwrap();
    archive::write(&folder.join("Gps.fmu"), files).unwrap();
}
