//! Debian's packages, unpacked under target/debian: nothing is installed in the system, and only
//! `apt-get` and `dpkg-deb` are needed.
//!
//! The archives are those configured in the system's apt, for its own and for ARM's packages; apt's
//! files are under target/debian/apt. `xtask/debian.txt` pins versions.

use crate::{paths, process};
use anyhow::{Context, Result, bail, ensure};
use std::{
    collections::BTreeSet,
    ffi::{OsStr, OsString},
    fs::{self, Permissions},
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
    process::Command,
    sync::Mutex,
    time::{Duration, Instant},
};

/// The folder for all of it.
pub(crate) fn folder() -> PathBuf {
    paths::target().join("debian")
}

/// The folder of the compiler with its libraries.
pub(crate) fn sysroot() -> PathBuf {
    folder().join("rust/usr")
}

/// The compiler.
pub(crate) fn rustc() -> PathBuf {
    sysroot().join("bin/rustc")
}

/// The folder of the compiler's own shared libraries, as `LD_LIBRARY_PATH`.
pub(crate) fn libraries() -> OsString {
    let mut folders = sysroot().join("lib/x86_64-linux-gnu").into_os_string();
    folders.push(":");
    folders.push(folder().join("rust/lib/x86_64-linux-gnu"));
    folders
}

/// The folder of the standard library's sources, where Cargo looks for it.
pub(crate) fn library_sources() -> Result<PathBuf> {
    let place = sysroot().join("lib/rustlib/src/rust");
    if !place.join("library").is_dir() || place.is_symlink() {
        // The package has a link there, which the compiler would follow and not recognize.
        let sources = place.canonicalize().context("rust-web-src is not unpacked")?;
        fs::remove_file(&place)?;
        fs::create_dir(&place)?;
        fs::rename(sources.join("library"), place.join("library"))?;
    }
    Ok(place.join("library"))
}

/// Unpacks the compiler and a package beside it, of the same version.
pub(crate) fn install_compiler(beside: &str) -> Result<()> {
    // Packages that nearly every system has, or that a compiler without its own linker does not
    // need.
    let present = ["libc6", "libgcc-s1", "libstdc++6", "gcc", "libc-dev", "binutils", "zlib1g"];
    let mut packages = with_dependencies("rustc-web", &present)?;
    packages.insert(beside.to_owned());
    unpack(&packages, "rust", &[])?;
    process::output(Command::new(rustc()).arg("--version").env("LD_LIBRARY_PATH", libraries()))
        .context("Debian's compiler does not start here")?;
    Ok(())
}

/// A program that runs programs for ARM, and the folder of ARM's glibc for it.
pub(crate) fn install_qemu(offline: bool) -> Result<[PathBuf; 2]> {
    let qemu = folder().join("qemu/usr/bin/qemu-aarch64-static");
    let arm = folder().join("arm64");
    if !offline {
        unpack(&named(&["qemu-user-static"]), "qemu", &["usr/bin/qemu-aarch64-static"])?;
        unpack(&named(&["libc6:arm64"]), "arm64", &[])?;
    }
    present([qemu, arm])
}

/// A program that runs programs for Windows, and a folder of libraries that it needs.
pub(crate) fn install_wine(offline: bool) -> Result<[PathBuf; 2]> {
    let wine = folder().join("wine/usr/lib");
    let programs = wine.join("wine");
    let libraries = wine.join("x86_64-linux-gnu");
    if !offline {
        let packages = ["wine64", "libwine", "libunwind8", "libz-mingw-w64"];
        unpack(&named(&packages), "wine", &[])?;
        // Links and scripts of the packages name paths in the system that do not exist there.
        let zlib = folder().join("wine/usr/x86_64-w64-mingw32/lib/zlib1.dll");
        replace(&zlib, &libraries.join("wine/x86_64-windows/zlib1.dll"))?;
        replace(&programs.join("wineserver64"), &programs.join("wineserver"))?;
    }
    present([programs.join("wine64"), libraries])
}

/// A browser without windows, with its libraries and a font: the script that starts it.
pub(crate) fn install_chromium() -> Result<PathBuf> {
    let browser = folder().join("chromium");
    let start = browser.join("chromium");
    if start.is_file() {
        return Ok(start);
    }
    // What nearly every system has, and what only configures an installed system.
    let configuring = ["adduser", "chromium-common", "debconf", "dpkg", "fonts-", "x11-common"];
    let without = [&["libc6", "libgcc-s1", "libstdc++6", "zlib1g"][..], &configuring].concat();
    let mut packages = with_dependencies("chromium-headless-shell", &without)?;
    packages.insert("fonts-dejavu-core".to_owned());
    unpack(&packages, "chromium", &[])?;
    unpack(&named(&["chromium-common"]), "chromium", &["usr/lib/chromium"])?;
    let place = browser.display();
    fs::write(
        browser.join("fonts.conf"),
        format!(
            "<fontconfig><dir>{place}/usr/share/fonts</dir><cachedir>{place}/cache</cachedir>\
             </fontconfig>\n"
        ),
    )?;
    let script = format!(
        "#!/bin/sh\n\
         export FONTCONFIG_FILE='{place}/fonts.conf'\n\
         own='{place}/usr/lib/x86_64-linux-gnu'\n\
         export LD_LIBRARY_PATH=\"$own:{place}/lib/x86_64-linux-gnu:$own/pulseaudio\"\n\
         exec '{place}/usr/lib/chromium/chromium-headless-shell' \"$@\"\n"
    );
    fs::write(&start, script)?;
    fs::set_permissions(&start, Permissions::from_mode(0o755))?;
    process::output(Command::new(&start).arg("--version"))
        .context("Debian's Chromium does not start here")?;
    Ok(start)
}

fn replace(from: &Path, to: &Path) -> Result<()> {
    let _ = fs::remove_file(to);
    fs::copy(from, to).with_context(|| from.display().to_string())?;
    Ok(())
}

fn present(paths: [PathBuf; 2]) -> Result<[PathBuf; 2]> {
    if let Some(missing) = paths.iter().find(|path| !path.exists()) {
        bail!("{} is missing: `cargo xtask platforms` unpacks it on Debian", missing.display());
    }
    Ok(paths)
}

/// Deadline for downloads.
static END: Mutex<Option<Instant>> = Mutex::new(None);

/// Does something whose downloads share a time limit.
pub(crate) fn within<T>(time: Duration, work: impl FnOnce() -> Result<T>) -> Result<T> {
    let set = |end| END.lock().map(|mut place| *place = end).unwrap_or_default();
    set(Some(Instant::now() + time));
    let done = work();
    set(None);
    done
}

/// A program that downloads, terminated at the deadline.
fn limited(program: &str) -> Command {
    let Some(end) = END.lock().ok().and_then(|end| *end) else { return Command::new(program) };
    let left = end.saturating_duration_since(Instant::now()).as_secs().max(1);
    let mut command = Command::new("timeout");
    command.arg(left.to_string()).arg(program);
    command
}

fn named(packages: &[&str]) -> BTreeSet<String> {
    packages.iter().map(|&name| name.to_owned()).collect()
}

/// Downloads packages and unpacks them in a folder, the named parts or everything, unless that was
/// done.
fn unpack(packages: &BTreeSet<String>, into: &str, parts: &[&str]) -> Result<()> {
    let into = folder().join(into);
    fs::create_dir_all(&into)?;
    let done = |package: &str| into.join(format!("{}.done", package.replace(':', "_")));
    let missing: Vec<&str> =
        packages.iter().map(String::as_str).filter(|package| !done(package).is_file()).collect();
    if missing.is_empty() {
        return Ok(());
    }
    download(&missing)?;
    for package in missing {
        let archive = downloaded(package)?;
        let shown = archive.display();
        // Parts are named as in the archive, which tar reads from dpkg-deb.
        let mut contents = Command::new("dpkg-deb");
        contents.arg("--fsys-tarfile").arg(&archive).stdout(std::process::Stdio::piped());
        let mut contents = contents.spawn().context("dpkg-deb cannot be started")?;
        let piped = contents.stdout.take().context("dpkg-deb writes nothing")?;
        let mut tar = Command::new("tar");
        tar.arg("-xC").arg(&into).args(parts.iter().map(|part| format!("./{part}"))).stdin(piped);
        process::quietly(&mut tar).with_context(|| format!("{shown} cannot be unpacked"))?;
        ensure!(contents.wait()?.success(), "{shown} cannot be read");
        let version = archive.file_name().unwrap_or_default();
        fs::write(done(package), version.as_encoded_bytes())?;
        fs::remove_file(&archive)?;
    }
    Ok(())
}

/// Downloads packages: the pinned versions, or the newest available ones if the archives no longer
/// have all of those.
fn download(packages: &[&str]) -> Result<()> {
    println!("downloading {}", packages.join(" "));
    let pinned = |package: &&str| {
        let pin = PINS.lines().filter_map(|line| line.split_once(' '));
        let version = pin.filter(|(of, _)| of == &name(package)).map(|(_, version)| version).next();
        version.map_or_else(|| (*package).to_owned(), |version| format!("{package}={version}"))
    };
    fetch(packages.iter().map(pinned)).or_else(|gone| {
        println!("  {gone:#}\n  taking the newest versions instead");
        fetch(packages.iter().map(|&package| package.to_owned()))
    })
}

/// The file of a package that was downloaded.
fn downloaded(package: &str) -> Result<PathBuf> {
    let mut found = fs::read_dir(archives())?.flatten().map(|entry| entry.path());
    let is_it = |path: &PathBuf| {
        path.extension() == Some(OsStr::new("deb"))
            && path.file_name().and_then(OsStr::to_str).is_some_and(|file| {
                file.strip_prefix(name(package)).is_some_and(|rest| rest.starts_with('_'))
            })
    };
    found.find(is_it).with_context(|| format!("apt-get has left no file of {package}"))
}

/// A package's name without its architecture.
fn name(package: &str) -> &str {
    package.split(':').next().unwrap_or_default()
}

/// The versions to take: a name and a version, in which `*` is any text.
const PINS: &str = include_str!("../debian.txt");

fn archives() -> PathBuf {
    folder().join("apt/archives")
}

/// Downloads packages to an empty folder.
fn fetch(packages: impl Iterator<Item = String>) -> Result<()> {
    let _ = fs::remove_dir_all(archives());
    fs::create_dir_all(archives())?;
    let mut command = apt("apt-get")?;
    process::quietly(command.args(["--quiet", "download"]).args(packages).current_dir(archives()))
        .context("not all packages are to be had")
}

/// A package with its dependencies, except those with these prefixes and their dependencies.
fn with_dependencies(package: &str, without: &[&str]) -> Result<BTreeSet<String>> {
    let mut open = named(&[package]);
    let mut found = BTreeSet::new();
    while !open.is_empty() {
        let only =
            "--no-recommends --no-suggests --no-conflicts --no-breaks --no-replaces --no-enhances";
        let mut command = apt("apt-cache")?;
        let listed = process::output(command.arg("depends").args(only.split(' ')).args(&open))?;
        found.append(&mut open);
        let names = listed.lines().filter_map(|line| line.trim().strip_prefix("Depends: "));
        let needed = names.filter(|name| !without.iter().any(|start| name.starts_with(start)));
        let real = needed.filter(|name| !name.starts_with('<')).map(str::to_owned);
        open = real.filter(|name| !found.contains(name)).collect();
    }
    Ok(found)
}

/// apt with its lists and archives under target/, which it fetches at the first use.
fn apt(program: &str) -> Result<Command> {
    ensure!(cfg!(target_arch = "x86_64"), "Debian's packages are taken for x86-64 machines only");
    let own = folder().join("apt");
    let file = own.join("apt.conf");
    let configured = |program: &str| {
        let mut command = limited(program);
        command.env("APT_CONFIG", &file);
        command
    };
    if !file.is_file() {
        let status = own.join("status");
        for part in ["lists/partial", "cache/archives/partial"] {
            fs::create_dir_all(own.join(part))?;
        }
        fs::write(&status, "")?;
        fs::write(&file, configuration(&own, &status))?;
        println!("reading the lists of Debian's packages");
        process::quietly(configured("apt-get").args(["--quiet", "update"])).map_err(|reason| {
            let _ = fs::remove_file(&file);
            reason.context("Debian's packages cannot be had")
        })?;
    }
    Ok(configured(program))
}

fn configuration(own: &Path, status: &Path) -> String {
    let lists = own.join("lists");
    let cache = own.join("cache");
    format!(
        "Dir::State::lists {lists:?};\nDir::State::status {status:?};\nDir::Cache {cache:?};\n\
         APT::Architectures {{ \"amd64\"; \"arm64\"; }};\nAPT::Sandbox::User \"\";\n\
         Acquire::Languages \"none\";\n"
    )
}
