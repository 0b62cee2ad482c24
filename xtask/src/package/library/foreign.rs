//! Tests with libraries of other machines, linked by Zig.

use super::{Library, WITHOUT_INSTANCE};
use crate::{
    package::{compile, platform},
    process,
};
use fmu_kit::kernel::Call;
use std::{fs, path::Path};

/// Every platform with a name here.
pub(crate) const PLATFORMS: [&str; 8] = [
    "linux64",
    "win64",
    "aarch64-linux",
    "linux32",
    "win32",
    "aarch64-windows",
    "darwin64",
    "aarch64-darwin",
];

/// The parts of a Windows library besides its functions.
const PRELUDE: &str = "
#ifdef _WIN32
#define EXPORT __declspec(dllexport)
int __stdcall DllMainCRTStartup(void *a, unsigned b, void *c) { return 1; }
int __stdcall _DllMainCRTStartup(void *a, unsigned b, void *c) { return 1; }
#else
#define EXPORT
#endif
";

/// All functions of FMI 2.0, which do nothing.
pub(crate) fn functions() -> String {
    let names = Call::ALL.iter().map(|call| call.name()).chain(WITHOUT_INSTANCE);
    names.map(|name| format!("EXPORT void {name}(void) {{}}\n")).collect()
}

/// A library in C for a platform.
pub(crate) fn library(platform: &str, text: &str, options: &[&str]) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let [source, output] = ["foreign.c", "foreign.so"].map(|name| folder.path().join(name));
    fs::write(&source, format!("{PRELUDE}{text}")).unwrap();
    let platform = platform::named(platform).unwrap();
    let mut command = compile::c_compiler(platform).unwrap();
    command.args(["-shared", "-nostdlib", "-o"]).args([&output, &source]).args(options);
    process::run(command.current_dir(folder.path())).unwrap();
    fs::read(output).unwrap()
}

fn read(platform: &str, text: &str, options: &[&str]) -> Library {
    Library::read(&library(platform, text, options)).unwrap()
}

#[test]
fn libraries_of_every_platform_are_read() {
    for name in PLATFORMS {
        let library = read(name, &functions(), &["-s"]);
        assert_eq!(library.exports().count(), 44, "{name}");
        for other in PLATFORMS {
            let verdict = library.check(platform::named(other).unwrap());
            match verdict {
                Ok(()) => assert_eq!(other, name),
                Err(reason) => {
                    let part = format!("binaries/{other} is for");
                    assert!(other != name && reason.to_string().contains(&part), "{reason}");
                }
            }
        }
        library.check_portable().unwrap_or_else(|reason| panic!("{name}: {reason}"));
    }
}

#[test]
fn a_foreign_export_is_refused_by_name() {
    for name in PLATFORMS {
        let text = functions() + "EXPORT void alien(void) {}";
        let refusal = read(name, &text, &["-s"]).check(platform::named(name).unwrap());
        assert_eq!(
            refusal.unwrap_err().to_string(),
            "it exports alien, which is no function of FMI 2.0",
            "{name}"
        );
    }
}

#[test]
fn a_library_that_not_every_windows_has_is_refused_by_name() {
    let text = functions()
        + "__declspec(dllimport) unsigned long __stdcall InternetAttemptConnect(unsigned long);\n\
           EXPORT int fmi2Extra(void) { return InternetAttemptConnect(0); }";
    let refusal = read("win64", &text, &["-s", "-lwininet"]).check_portable().unwrap_err();
    assert!(refusal.to_string().to_lowercase().contains("it needs wininet.dll"), "{refusal}");
}

#[test]
fn what_is_there_for_debuggers_is_refused() {
    for (name, part) in [("linux64", "section .debug_"), ("win64", "a debug directory")] {
        let refusal = read(name, &functions(), &["-g"]).check_portable().unwrap_err();
        assert!(refusal.to_string().contains(part), "{name}: {refusal}");
    }
}

#[test]
fn a_call_that_another_library_could_take_is_seen() {
    let seen = |platform: &str, text: &str| {
        let library = read(platform, text, &[]);
        library.interposable().map(str::to_owned).collect::<Vec<_>>()
    };
    let own = "void callee(void) {} void caller(void) { callee(); }";
    for platform in ["aarch64-linux", "linux32"] {
        assert_eq!(seen(platform, own), ["callee"]);
        let hidden = format!("__attribute__((visibility(\"hidden\"))) {own}");
        assert!(seen(platform, &hidden).is_empty());
    }
}

/// Damaged files are rejected or read, in bounded time and memory; they never end the program.
#[test]
fn damaged_libraries_do_no_harm() {
    let mut seed = 1_u64;
    let mut random = |below: usize| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as usize % below
    };
    for name in PLATFORMS {
        let whole = library(name, &functions(), &["-s"]);
        for length in (0..whole.len()).step_by(whole.len() / 200) {
            let _ = Library::read(&whole[..length]);
        }
        for _ in 0..3000 {
            let mut bytes = whole.clone();
            for _ in 0..=random(4) {
                // Headers and tables come first in most of them.
                let part = [1024, 1 << 20][random(2)];
                let place = random(bytes.len().min(part));
                bytes[place] = [0, 1, 0x7f, 0x80, 0xff, random(256) as u8][random(6)];
            }
            let _ = Library::read(&bytes);
        }
    }
    let none = Path::new("Cargo.toml");
    assert!(Library::read(&fs::read(none).unwrap()).is_err());
}
