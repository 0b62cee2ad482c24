//! One .fmu file: unpacked and mapped once per process, shared by all its instances.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, atomic::AtomicBool};
use std::sync::{Mutex, OnceLock, PoisonError, Weak};
use std::time::SystemTime;

use tempfile::TempDir;

use super::archive;
use super::description::{self, Description, Interface, InterfaceType};
use super::library::{self, Binary};
use crate::digest::sha256;
use crate::error::{Code, Error, Result};

/// An imported FMU.
pub struct Fmu {
    path: PathBuf,
    description: Description,
    /// The libraries for co-simulation and for model exchange; often the same file.
    binaries: [OnceLock<Binary>; 2],
    loading: Mutex<()>,
    /// An instance of an FMU that allows only one per process exists.
    pub(super) taken: AtomicBool,
    /// Declared last: the library is unmapped before its file vanishes.
    folder: TempDir,
}

/// What makes a file the same: place, size and time of change.
type Identity = (PathBuf, u64, Option<SystemTime>);

/// FMUs in use. Weak: the last user takes the unpacked folder with it.
static OPEN: Mutex<Option<HashMap<Identity, Weak<Fmu>>>> = Mutex::new(None);

impl Fmu {
    /// Opens `path`, or shares it when it is in use already.
    pub fn open(path: &Path) -> Result<Arc<Self>> {
        let identity = identity(path)?;
        let mut open = OPEN.lock().unwrap_or_else(PoisonError::into_inner);
        let open = open.get_or_insert_default();
        if let Some(fmu) = open.get(&identity).and_then(Weak::upgrade) {
            return Ok(fmu);
        }
        let fmu = Arc::new(Self::unpack(path)?);
        open.retain(|_, fmu| fmu.strong_count() > 0);
        open.insert(identity, Arc::downgrade(&fmu));
        Ok(fmu)
    }

    fn unpack(path: &Path) -> Result<Self> {
        let folder = archive::unpack(path)?;
        let file = folder.path().join("modelDescription.xml");
        if !file.is_file() {
            return Err(Error::new(Code::Archive, "the archive has no modelDescription.xml")
                .at(path)
                .help("an .fmu has that file at its top level, in no folder"));
        }
        let description = description::read(&file, &path.join("modelDescription.xml"))?;
        Ok(Self {
            path: path.to_owned(),
            description,
            binaries: Default::default(),
            loading: Mutex::new(()),
            taken: AtomicBool::new(false),
            folder,
        })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where it is unpacked.
    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Its modelDescription.xml.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// The part for an interface type, or the error that there is none.
    pub fn interface(&self, kind: InterfaceType) -> Result<&Interface> {
        self.description.interface(kind).ok_or_else(|| {
            let what = format!("the FMU has no {} part", kind.name());
            Error::new(Code::Description, what).at(&self.path).help("export it with that interface")
        })
    }

    /// The interface type that is wanted, or without a wish co-simulation if there is that.
    pub fn choose(&self, wanted: Option<InterfaceType>) -> Result<InterfaceType> {
        let kind = wanted.unwrap_or(match self.description.co_simulation {
            Some(_) => InterfaceType::CoSimulation,
            None => InterfaceType::ModelExchange,
        });
        match (self.interface(kind), wanted) {
            (Ok(_), _) => Ok(kind),
            (Err(error), Some(_)) => Err(error),
            (Err(_), None) => Err(Error::new(
                Code::Description,
                "the FMU has neither a co-simulation nor a model exchange part",
            )
            .at(&self.path)),
        }
    }

    /// Maps the library for `kind`, if that was not done before.
    pub fn load(&self, kind: InterfaceType) -> Result<()> {
        self.binary(kind).map(|_| ())
    }

    pub(super) fn binary(&self, kind: InterfaceType) -> Result<&Binary> {
        let cell = &self.binaries[kind as usize];
        if let Some(binary) = cell.get() {
            return Ok(binary);
        }
        // The lock makes one thread load; OnceLock alone cannot hand an error back.
        let _loading = self.loading.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(binary) = cell.get() {
            return Ok(binary);
        }
        let binary = library::load(&self.library_file(kind)?, &self.path, kind)?;
        Ok(cell.get_or_init(|| binary))
    }

    /// GUID and a hash of the library: what a serialized state belongs to.
    pub(crate) fn digest(&self, kind: InterfaceType) -> Result<String> {
        let file = self.library_file(kind)?;
        let bytes = fs::read(&file).map_err(|e| {
            Error::new(Code::File, "the library of the FMU cannot be read").at(&self.path).why(e)
        })?;
        Ok(format!("{} {}", self.description.guid, sha256(bytes)))
    }

    fn library_file(&self, kind: InterfaceType) -> Result<PathBuf> {
        let name = format!("{}.so", self.interface(kind)?.model_identifier);
        let binaries = self.folder.path().join("binaries");
        let found = library::folders()
            .iter()
            .map(|folder| binaries.join(folder).join(&name))
            .find(|file| file.is_file());
        found.ok_or_else(|| {
            let mut present: Vec<String> = fs::read_dir(&binaries)
                .into_iter()
                .flatten()
                .flatten()
                .map(|entry| entry.file_name().to_string_lossy().into_owned())
                .collect();
            present.sort();
            let wanted: Vec<String> =
                library::folders().iter().map(|f| format!("binaries/{f}/{name}")).collect();
            Error::new(Code::Library, "the FMU has no binary for this machine")
                .at(&self.path)
                .why(format!("it has binaries for: {}", present.join(", ")))
                .help(format!("export it so that it contains {}", wanted.join(" or ")))
        })
    }

    /// `file:///...` of the unpacked resources, with everything but plain characters escaped.
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

fn identity(path: &Path) -> Result<Identity> {
    let missing = |e| {
        Error::new(Code::File, "the FMU cannot be opened")
            .at(path)
            .why(e)
            .help("check the path; in a system description it is relative to that file")
    };
    let full = path.canonicalize().map_err(missing)?;
    let metadata = full.metadata().map_err(missing)?;
    if metadata.is_dir() {
        return Err(Error::new(Code::File, "the FMU is a folder")
            .at(path)
            .help("pack it: zip -r ../name.fmu * inside of it"));
    }
    Ok((full, metadata.len(), metadata.modified().ok()))
}
