//! The library of an FMU that this program writes, for one platform or for several.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use cosim_base::error::{Code, Error, Result};
use cosim_core::system::System;
use cosim_import::elf;

/// A kind of FMU that this program writes, by its library.
pub struct Kind {
    /// The environment variable that names the library, or several separated by `:`.
    pub variable: &'static str,
    /// Its file name from Cargo.
    pub file: &'static str,
    /// A marker among its bytes.
    pub mark: &'static str,
    /// What the library is for.
    pub of: &'static str,
}

/// A file beside it: the linked packages, with their terms.
const LINKED: &str = "licenses.txt";

/// The library for one platform.
pub struct Library {
    /// Folder under binaries/.
    pub folder: &'static str,
    /// Its contents.
    pub bytes: Vec<u8>,
    /// Where it was found.
    pub path: PathBuf,
    /// The linked packages, with their terms, if there is such a file beside it.
    pub linked: Option<Vec<u8>>,
}

/// Reads the named libraries, or the one that is found.
pub fn find(kind: &Kind, named: &[PathBuf]) -> Result<Vec<Library>> {
    let paths = match named {
        [] => vec![search(kind)?],
        named => named.to_vec(),
    };
    let mut libraries: Vec<Library> = Vec::new();
    for path in paths.iter().flat_map(|path| env::split_paths(path).collect::<Vec<_>>()) {
        let library = read(kind, &path)?;
        if let Some(first) = libraries.iter().find(|other| other.folder == library.folder) {
            let what = format!("two libraries are for {}", library.folder);
            return Err(Error::new(Code::Usage, what)
                .at(&library.path)
                .why(format!("the other is {}", first.path.display()))
                .help("name one library for each platform"));
        }
        libraries.push(library);
    }
    libraries.sort_by_key(|library| library.folder);
    Ok(libraries)
}

/// From the environment, beside this program, or where packages install it.
fn search(kind: &Kind) -> Result<PathBuf> {
    let Kind { variable, file, of, .. } = kind;
    if let Some(named) = env::var_os(variable).filter(|named| !named.is_empty()) {
        return Ok(named.into());
    }
    let program = env::current_exe().and_then(|program| program.canonicalize()).ok();
    let folder = program.as_deref().and_then(Path::parent).unwrap_or(Path::new("."));
    let shared = folder.join("../lib/cosim");
    let own = elf::here().map(|platform| shared.join(platform).join(file));
    let places = [folder.join(file), shared.join(file)].into_iter().chain(own);
    let places: Vec<PathBuf> = places.collect();
    if let Some(found) = places.iter().find(|place| place.is_file()) {
        return Ok(found.clone());
    }
    let places: Vec<String> = places.iter().map(|place| place.display().to_string()).collect();
    Err(Error::new(Code::Library, format!("the library of {of} was not found"))
        .why(format!("none of these exists: {}", places.join(", ")))
        .help(format!("specify it with --library or {variable}; cargo xtask package makes it")))
}

fn read(kind: &Kind, path: &Path) -> Result<Library> {
    let Kind { mark, of, .. } = kind;
    let wrong = |why: String| {
        Error::new(Code::Library, format!("this is not a library of {of}")).at(path).why(why)
    };
    let bytes = cosim_base::files::read_input(path).map_err(|e| {
        Error::new(Code::File, format!("the library of {of} cannot be read")).at(path).why(e)
    })?;
    let folder = elf::platform(&bytes).map_err(wrong)?;
    if !bytes.windows(mark.len()).any(|window| window == mark.as_bytes()) {
        return Err(wrong(format!("it does not contain '{mark}'"))
            .help("use the library that was built together with this program"));
    }
    let linked = fs::read(path.with_file_name(LINKED)).ok();
    Ok(Library { folder, bytes, path: path.to_owned(), linked })
}

/// Every inner FMU must have a binary for that platform; for this machine's platform it is loaded.
pub(crate) fn check(library: &Library, system: &System) -> Result<()> {
    let mut problems = Vec::new();
    for component in system.components() {
        let Some(fmu) = component.fmu() else { continue };
        if elf::is_here(library.folder) {
            problems.extend(fmu.load(component.interface).err());
            continue;
        }
        if !elf::folders(library.folder).iter().any(|folder| fmu.has_binaries(folder)) {
            let name = &component.name;
            let what = format!("'{name}' has no binary for {}", library.folder);
            problems.push(
                Error::new(Code::Library, what)
                    .at(fmu.path())
                    .why(format!("{} is for that platform", library.path.display()))
                    .help("export its FMU for that platform too, or omit the library"),
            );
        }
    }
    Error::all(problems)
}
