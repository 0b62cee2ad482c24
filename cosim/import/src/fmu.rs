//! One FMU: unpacked and mapped once per process, shared by all its instances and by files with the
//! same content.

use std::collections::HashMap;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};
use std::time::SystemTime;

use sha2::{Digest, Sha256};

use super::archive::{self, Room};
use super::description::{self, Description, Interface, InterfaceType};
use super::elf;
use super::guard;
use super::library::{self, Binary};
use super::temporary::Unpacked;
use cosim_base::error::{Code, Error, Result};
use cosim_base::sha256;

/// An imported FMU.
pub struct Fmu {
    path: PathBuf,
    description: Description,
    /// The libraries for co-simulation and for model exchange; often the same file.
    binaries: [OnceLock<Binary>; 2],
    loading: Mutex<()>,
    /// An instance of an FMU that allows only one per process exists.
    pub(super) taken: AtomicBool,
    /// An instance was abandoned while its code may still run: the library stays mapped.
    pub(super) abandoned: AtomicBool,
    /// Declared last: the library is unmapped before its file is removed.
    folder: Folder,
}

/// Where its files are.
enum Folder {
    /// Unpacked here, and removed with the value.
    Own(Unpacked),
    /// Unpacked by someone else, who keeps it.
    Foreign(PathBuf),
}

impl Folder {
    fn path(&self) -> &Path {
        match self {
            Self::Own(unpacked) => unpacked.path(),
            Self::Foreign(folder) => folder,
        }
    }
}

/// Identifies an unchanged file without reading it: path, size and modification time.
type Identity = (PathBuf, u64, Option<SystemTime>);

/// Identifies files with the same FMU: their SHA-256; for a folder, that of its path.
type Content = [u8; 32];

/// Maximum number of remembered identities; others are forgotten, and read again when needed.
const REMEMBERED: usize = 4096;

#[derive(Default)]
struct Registry {
    /// FMUs in use. Weak: the last user removes the unpacked folder.
    open: HashMap<Content, Weak<Fmu>>,
    contents: HashMap<Identity, Content>,
}

static REGISTRY: Mutex<Option<Registry>> = Mutex::new(None);

/// Forgets which FMUs were open, if none is: for a library with this code inside that is being
/// unloaded.
pub fn forget() {
    // Whichever thread holds it is using it.
    if let Ok(mut registry) = REGISTRY.try_lock()
        && registry.as_ref().is_none_or(|r| r.open.values().all(|fmu| fmu.strong_count() == 0))
    {
        *registry = None;
    }
}

impl Fmu {
    /// Opens `path`, or shares an FMU with the same content that is already in use.
    pub fn open(path: &Path) -> Result<Arc<Self>> {
        Self::open_within(path, &mut Room::default())
    }

    /// The same, if there is room for it beside other archives.
    pub fn open_within(path: &Path, room: &mut Room) -> Result<Arc<Self>> {
        let identity = identity(path)?;
        let mut registry = REGISTRY.lock().unwrap_or_else(PoisonError::into_inner);
        let Registry { open, contents } = registry.get_or_insert_default();
        let content = match contents.get(&identity) {
            Some(content) => *content,
            None => content(path)?,
        };
        if contents.len() >= REMEMBERED {
            contents.clear();
        }
        contents.insert(identity, content);
        shared(open, content, || {
            Self::read(path, Folder::Own(archive::unpack_within(path, is_used, room)?))
        })
    }

    /// Opens the unpacked FMU in the folder `path`, which must stay as it is while the FMU is in use.
    pub fn open_unpacked(path: &Path) -> Result<Arc<Self>> {
        let folder = path.canonicalize().map_err(|e| missing(path, e))?;
        let content = Sha256::digest(folder.as_os_str().as_encoded_bytes()).into();
        let mut registry = REGISTRY.lock().unwrap_or_else(PoisonError::into_inner);
        let Registry { open, .. } = registry.get_or_insert_default();
        shared(open, content, || Self::read(path, Folder::Foreign(folder)))
    }

    fn read(path: &Path, folder: Folder) -> Result<Self> {
        let file = folder.path().join("modelDescription.xml");
        if !file.is_file() {
            return Err(Error::new(Code::Archive, "the archive has no modelDescription.xml")
                .at(path)
                .help("an .fmu has that file at its top level, not in a folder"));
        }
        let description = description::read(&file, &path.join("modelDescription.xml"))?;
        Ok(Self {
            path: path.to_owned(),
            description,
            binaries: Default::default(),
            loading: Mutex::new(()),
            taken: AtomicBool::new(false),
            abandoned: AtomicBool::new(false),
            folder,
        })
    }

    /// Whether it has binaries in the folder of that name.
    pub fn has_binaries(&self, folder: &str) -> bool {
        // Those for other machines are not unpacked, but leave their folder.
        let files = fs::read_dir(self.folder.path().join("binaries").join(folder));
        files.is_ok_and(|mut files| !library::folders().contains(&folder) || files.next().is_some())
    }

    /// The platforms for which it has binaries, with FMI's names, sorted.
    pub fn platforms(&self) -> Vec<String> {
        let folders = fs::read_dir(self.folder.path().join("binaries")).into_iter().flatten();
        let names = folders.flatten().map(|folder| folder.file_name().to_string_lossy().into());
        let mut names: Vec<String> =
            names.filter(|name: &String| self.has_binaries(name)).collect();
        names.sort();
        names
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The folder where it is unpacked.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Its modelDescription.xml.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// The part for an interface type, or an error if there is none.
    pub fn interface(&self, kind: InterfaceType) -> Result<&Interface> {
        self.description.interface(kind).ok_or_else(|| {
            let what = format!("the FMU has no {} part", kind.name());
            Error::new(Code::Description, what).at(&self.path).help("export it with that interface")
        })
    }

    /// Whether its steps may differ in length.
    pub fn varies(&self, kind: InterfaceType) -> bool {
        kind == InterfaceType::ModelExchange
            || self.description.interface(kind).is_some_and(|interface| interface.variable_step)
    }

    /// The requested interface type; by default co-simulation if the FMU supports it.
    pub fn choose(&self, wanted: Option<InterfaceType>) -> Result<InterfaceType> {
        let kind = wanted.unwrap_or(match self.description.co_simulation {
            Some(_) => InterfaceType::CoSimulation,
            None => InterfaceType::ModelExchange,
        });
        match (self.interface(kind), wanted) {
            (Ok(_), _) => self.check(kind).map(|()| kind),
            (Err(error), Some(_)) => Err(error),
            (Err(_), None) => Err(Error::new(
                Code::Description,
                "the FMU has neither a co-simulation nor a model exchange part",
            )
            .at(&self.path)),
        }
    }

    /// Whether its description is complete for that interface type.
    pub fn check(&self, kind: InterfaceType) -> Result<()> {
        match &self.description.unlisted_derivative {
            Some((name, line)) if kind == InterfaceType::ModelExchange => {
                let what = format!("'{name}' is a derivative, and no derivative is listed");
                Err(Error::new(Code::States, what)
                    .at_line(self.path.join("modelDescription.xml"), *line)
                    .why("without <ModelStructure><Derivatives> no state would be integrated"))
            }
            _ => Ok(()),
        }
    }

    /// Maps the library for `kind`, if that has not been done before.
    pub fn load(&self, kind: InterfaceType) -> Result<()> {
        self.binary(kind).map(|_| ())
    }

    pub(super) fn binary(&self, kind: InterfaceType) -> Result<&Binary> {
        let cell = &self.binaries[kind as usize];
        if let Some(binary) = cell.get() {
            return Ok(binary);
        }
        // The lock makes one thread load; OnceLock alone cannot return an error.
        let _loading = self.loading.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(binary) = cell.get() {
            return Ok(binary);
        }
        let binary = library::load(&self.library_file(kind)?, &self.path, kind)?;
        Ok(cell.get_or_init(|| binary))
    }

    /// GUID and a hash of the library: the FMU to which a serialized state belongs.
    pub fn digest(&self, kind: InterfaceType) -> Result<String> {
        let file = self.library_file(kind)?;
        let bytes = fs::read(&file).map_err(|e| {
            Error::new(Code::File, "the library of the FMU cannot be read").at(&self.path).why(e)
        })?;
        Ok(format!("{} {}", self.description.guid, sha256(bytes)))
    }

    /// Whether it has a binary for this machine; the error says for which it has one.
    pub fn is_for_this_machine(&self, kind: InterfaceType) -> Result<()> {
        self.libraries(kind).map(drop)
    }

    /// The libraries in the folders for this machine.
    fn libraries(&self, kind: InterfaceType) -> Result<Vec<PathBuf>> {
        let name = format!("{}.so", self.interface(kind)?.model_identifier);
        let binaries = self.folder.path().join("binaries");
        let files = library::folders().iter().map(|folder| binaries.join(folder).join(&name));
        let present: Vec<PathBuf> = files.filter(|file| file.is_file()).collect();
        if present.is_empty() { Err(self.no_binary(&name)) } else { Ok(present) }
    }

    fn library_file(&self, kind: InterfaceType) -> Result<PathBuf> {
        let present = self.libraries(kind)?;
        if let Some(file) = present.iter().find(|file| elf::check(file).is_ok()) {
            return Ok(file.clone());
        }
        let why = present.iter().find_map(|file| elf::check(file).err()).unwrap_or_default();
        Err(Error::new(Code::Library, "the library of the FMU cannot be loaded")
            .at(&self.path)
            .why(why)
            .help("export the FMU for this machine"))
    }

    fn no_binary(&self, name: &str) -> Error {
        let folders = library::folders();
        let wanted: Vec<String> = folders.iter().map(|f| format!("binaries/{f}/{name}")).collect();
        if let Some(other) = folders.iter().find_map(|folder| self.any_library(folder)) {
            return Error::new(Code::Library, "the library of the FMU has a wrong name")
                .at(&self.path)
                .why(format!("it is {other}; FMI requires the modelIdentifier as its name"))
                .help(format!("rename it in the archive to {}", wanted.join(" or ")));
        }
        let present = match &self.platforms()[..] {
            [] => "it has no binaries at all".to_owned(),
            platforms => format!("it has binaries for: {}", platforms.join(", ")),
        };
        Error::new(Code::Library, "the FMU has no binary for this machine")
            .at(&self.path)
            .why(present)
            .help(format!("export it so that it contains {}", wanted.join(" or ")))
    }

    /// A library of any name in a folder of binaries.
    fn any_library(&self, folder: &str) -> Option<String> {
        let files = fs::read_dir(self.folder.path().join("binaries").join(folder)).ok()?;
        let names = files.flatten().map(|file| file.file_name().to_string_lossy().into_owned());
        let library = names.filter(|name| name.ends_with(".so")).min()?;
        Some(format!("binaries/{folder}/{library}"))
    }

    /// `file:///...` of the unpacked resources, with everything except plain characters escaped.
    pub(super) fn resource_uri(&self) -> String {
        let path = self.folder.path().join("resources");
        let mut uri = String::from("file://");
        for &byte in path.as_os_str().as_encoded_bytes() {
            match byte {
                b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'-' | b'_' | b'.' | b'~' => {
                    uri.push(byte as char);
                }
                _ => uri.push_str(&format!("%{byte:02X}")),
            }
        }
        uri
    }
}

/// Whether a file of an FMU is needed to run it: an FMU may contain several times as much for
/// users, for compilers, for other tools and other machines.
fn is_used(path: &Path) -> bool {
    let mut parts = path.iter().map(|part| part.to_str().unwrap_or_default());
    match parts.next() {
        Some("documentation" | "sources" | "extra" | "model.png") => false,
        Some("binaries") => parts.next().is_none_or(|folder| library::folders().contains(&folder)),
        _ => true,
    }
}

impl Drop for Fmu {
    fn drop(&mut self) {
        let binaries = std::mem::take(&mut self.binaries);
        let loaded: Vec<Binary> = binaries.into_iter().filter_map(OnceLock::into_inner).collect();
        if self.abandoned.load(Ordering::Acquire) || loaded.iter().any(Binary::may_run) {
            loaded.into_iter().for_each(Binary::leak);
        } else if !loaded.is_empty() {
            // No instance is left that could report what changed.
            guard::around("unloading the library", || drop(loaded));
        }
    }
}

/// The FMU with this content that is in use, or else a new one.
fn shared(
    open: &mut HashMap<Content, Weak<Fmu>>,
    content: Content,
    new: impl FnOnce() -> Result<Fmu>,
) -> Result<Arc<Fmu>> {
    if let Some(fmu) = open.get(&content).and_then(Weak::upgrade) {
        return Ok(fmu);
    }
    let fmu = Arc::new(new()?);
    open.retain(|_, fmu| fmu.strong_count() > 0);
    open.insert(content, Arc::downgrade(&fmu));
    Ok(fmu)
}

fn content(path: &Path) -> Result<Content> {
    let unreadable = |e| Error::new(Code::File, "the FMU cannot be read").at(path).why(e);
    let mut file = cosim_base::files::open_input(path).map_err(unreadable)?;
    let mut hash = Sha256::new();
    let mut piece = vec![0; 1 << 16];
    loop {
        match file.read(&mut piece).map_err(unreadable)? {
            0 => return Ok(hash.finalize().into()),
            length => hash.update(&piece[..length]),
        }
    }
}

fn identity(path: &Path) -> Result<Identity> {
    let full = path.canonicalize().map_err(|e| missing(path, e))?;
    let metadata = full.metadata().map_err(|e| missing(path, e))?;
    if metadata.is_dir() {
        return Err(Error::new(Code::File, "the FMU is a folder")
            .at(path)
            .help("pack it: run zip -r ../name.fmu * inside the folder"));
    }
    if !metadata.is_file() {
        return Err(Error::new(Code::File, "the FMU is not a file").at(path));
    }
    Ok((full, metadata.len(), metadata.modified().ok()))
}

fn missing(path: &Path, why: std::io::Error) -> Error {
    Error::new(Code::File, "the FMU cannot be opened")
        .at(path)
        .why(why)
        .help("check the path; in a system description it is relative to that file")
}

#[cfg(test)]
mod tests {
    use super::is_used;
    use std::path::Path;

    #[test]
    fn what_is_for_people_and_other_machines_is_not_unpacked() {
        let own = format!("binaries/{}/libs/a.so", super::library::folders()[0]);
        for used in ["modelDescription.xml", "resources/extra/a.csv", own.as_str()] {
            assert!(is_used(Path::new(used)), "{used}");
        }
        for left in ["documentation/index.html", "sources/a.c", "binaries/win64/a.dll", "extra/a"] {
            assert!(!is_used(Path::new(left)), "{left}");
        }
    }
}
