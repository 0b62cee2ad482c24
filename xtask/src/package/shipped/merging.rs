//! Tests of merging FMUs of several platforms.

use super::{library, packaged};
use crate::package::{
    archive,
    library::foreign::{self, PLATFORMS},
    merge, platform,
};
use std::{fs, path::Path};

/// A library with all functions of FMI 2.0, which do nothing, for another machine.
fn foreign(platform: &str) -> Vec<u8> {
    foreign::library(platform, &foreign::functions(), &["-s"])
}

#[test]
fn fmus_of_two_platforms_become_one() {
    let folder = tempfile::tempdir().unwrap();
    let [x86, arm, merged] = ["x86", "arm", "merged"].map(|name| folder.path().join(name));
    let own = library("Gps");
    let files = exchange(&packaged("Gps"), "binaries/linux64/Gps.so", own);
    let other = exchange(&files, "binaries/aarch64-linux/Gps.so", foreign("aarch64-linux"));
    write(&x86, &files);
    write(&arm, &other);
    let paths = merge::folders(&[x86.clone(), arm.clone()], &merged).unwrap();
    let result = archive::read(&paths[0]).unwrap();
    let listed: Vec<_> = result.iter().map(|(name, _)| name.as_str()).collect();
    let libraries = ["binaries/aarch64-linux/Gps.so", "binaries/linux64/Gps.so"];
    assert_eq!(listed[..3], ["modelDescription.xml", libraries[0], libraries[1]]);
    assert_eq!(result.len(), files.len() + 1);
    // In any order, the same bytes.
    let first = fs::read(&paths[0]).unwrap();
    merge::folders(&[arm, x86], &merged).unwrap();
    assert_eq!(fs::read(&paths[0]).unwrap(), first);
}

#[test]
fn fmus_of_all_platforms_become_one() {
    let folder = tempfile::tempdir().unwrap();
    let files = packaged("Gps");
    let mut sources = Vec::new();
    let mut expected = Vec::new();
    for name in PLATFORMS {
        let source = folder.path().join(name);
        let suffix = fmu_kit::package::suffix(&platform::named(name).unwrap().folder());
        let place = format!("binaries/{name}/Gps{suffix}");
        write(&source, &exchange(&files, &place, foreign(name)));
        sources.push(source);
        expected.push(place);
    }
    expected.sort();
    let paths = merge::folders(&sources, &folder.path().join("merged")).unwrap();
    let merged = archive::read(&paths[0]).unwrap();
    let listed: Vec<_> = merged.iter().map(|(name, _)| name.clone()).collect();
    assert_eq!(listed[1..=PLATFORMS.len()], expected);
}

#[test]
fn what_does_not_fit_is_not_merged() {
    let folder = tempfile::tempdir().unwrap();
    let [one, two, out] = ["one", "two", "out"].map(|name| folder.path().join(name));
    let own = library("Gps");
    let files = exchange(&packaged("Gps"), "binaries/linux64/Gps.so", own.clone());
    let arm = "binaries/aarch64-linux/Gps.so";
    let refused = |changed: &[archive::Entry], part: &str| {
        write(&one, &files);
        write(&two, changed);
        let error = merge::folders(&[one.clone(), two.clone()], &out).unwrap_err();
        let text = format!("{error:#}");
        assert!(text.contains(part), "{text}");
        assert!(!out.exists());
    };
    refused(&exchange(&files, arm, own.clone()), "it is built for x86_64-linux");
    let mut description = exchange(&files, arm, foreign("aarch64-linux"));
    description[0].1.push(b'\n');
    refused(&description, "modelDescription.xml differs");
    let mut grown = own;
    grown.push(0);
    refused(&exchange(&files, "binaries/linux64/Gps.so", grown), "both are for one platform");
    let dll = "binaries/win64/Gps.dll";
    refused(&exchange(&files, dll, Vec::new()), dll);
    refused(&exchange(&files, dll, foreign("win32")), "it is built for x86-windows");
    refused(&exchange(&files, "binaries/win64/Gps.so", foreign("win64")), "end in .dll");
    refused(&exchange(&files, "binaries/win128/Gps.dll", foreign("win64")), "\"win128\"");
    let mut short = files.clone();
    short.retain(|(name, _)| name != "model.png");
    refused(&short, "holds model.png");
}

/// The same files with another library instead of their own.
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
