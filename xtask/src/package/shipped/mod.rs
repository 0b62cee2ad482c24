//! Tests of the libraries in the packaged FMUs.
#![allow(unsafe_code, reason = "calls of the C interface as an importer makes them")]

mod loaded;
mod merging;

use super::{archive, compile, compile::Linker, library::Library, platform};
use crate::{paths, platforms::clumsy::Clumsy};
use fmu_kit::{
    abi::types::fmi2Component,
    kernel::{Entry, Status},
};
use loaded::Loaded;

fn packaged(name: &str) -> Vec<archive::Entry> {
    let path = paths::fmus().join(format!("{name}.fmu"));
    archive::read(&path).unwrap_or_else(|e| panic!("{e:#}; run `cargo xtask package`"))
}

fn names() -> impl Iterator<Item = &'static str> {
    rexrov_fmu::REGISTRY.entries().map(|entry| entry.info().name)
}

/// The library of an FMU for this machine.
fn library(name: &str) -> Vec<u8> {
    let file = format!("binaries/{}/{name}.so", platform::host().unwrap().folder());
    packaged(name).into_iter().find(|(name, _)| *name == file).unwrap().1
}

fn clumsy() -> Vec<u8> {
    let (linker, host) = (Linker::at_hand(), platform::host().unwrap());
    let built = compile::build(linker, host, &["-p", "clumsy"]).unwrap();
    std::fs::read(built.join("libclumsy.so")).unwrap()
}

#[test]
fn every_packaged_library_starts_anywhere() {
    for name in names() {
        for (file, bytes) in packaged(name) {
            if let Some(rest) = file.strip_prefix("binaries/") {
                let platform = platform::named(rest.split('/').next().unwrap()).unwrap();
                let library = Library::read(&bytes).unwrap();
                library.check(platform).unwrap();
                library.check_portable().unwrap_or_else(|e| {
                    panic!("{name}: {e}; `cargo xtask package` links it for other machines")
                });
                assert_eq!(library.exports().count(), 44);
            }
        }
    }
}

#[test]
fn a_shipped_library_tells_nothing_of_the_folders_it_was_built_in() {
    let bytes = library("RexROV");
    let root = paths::root().to_str().unwrap().as_bytes();
    assert!(!bytes.windows(root.len()).any(|part| part == root));
}

#[test]
fn libraries_in_one_process_keep_to_themselves() {
    let folder = tempfile::tempdir().unwrap();
    // The first in the process has the same 44 symbols, globally visible, and another component.
    let first = Loaded::global(folder.path(), "Clumsy", &clumsy());
    for name in ["RexROV", "Gps"] {
        let own = Loaded::global(folder.path(), name, &library(name));
        let component = rexrov_fmu::REGISTRY.named(name).unwrap();
        for function in ["fmi2Instantiate", "fmi2GetVersion", "fmi2DoStep"] {
            assert_eq!(own.origin(function), own.path);
            assert_eq!(first.origin(function), first.path);
        }
        assert!(first.instantiate(component.guid()).is_null());
        let instance = own.instantiate(component.guid());
        assert!(!instance.is_null());
        own.initialize(instance);
        assert_eq!(own.step(instance), Status::Ok);
        let time = component.table().named("time").unwrap().reference;
        assert_eq!(own.get(instance, time), (Status::Ok, 0.1));
        // An instance of one library is invalid in the other.
        assert_eq!(first.call("fmi2Reset", instance), Status::Error);
        assert_eq!(own.call("fmi2Reset", instance), Status::Ok);
        let free: unsafe extern "C" fn(fmi2Component) = own.function("fmi2FreeInstance");
        // SAFETY: the instance came from this library and is not used any more.
        unsafe { free(instance) };
    }
}

#[test]
fn a_panic_in_a_shipped_library_ends_the_instance_and_not_the_host() {
    let folder = tempfile::tempdir().unwrap();
    let library = Loaded::global(folder.path(), "Panicking", &clumsy());
    let component = Entry::of::<Clumsy>();
    let reference = |name| component.table().named(name).unwrap().reference;
    let (panic, echo) = (reference("panic"), reference("echo"));
    let (one, other) =
        (library.instantiate(component.guid()), library.instantiate(component.guid()));
    for instance in [one, other] {
        assert!(!instance.is_null());
        library.initialize(instance);
        assert_eq!(library.step(instance), Status::Ok);
    }
    library.set(one, panic, 1.0);
    assert_eq!(library.get(one, echo).0, Status::Fatal);
    assert_eq!(library.get(other, echo), (Status::Ok, 0.0));
}
