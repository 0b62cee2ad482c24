//! The FMUs that a worker loads. An FMU is native code: one that another party sends runs only if
//! it was allowed here.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::setup::FmuFile;
use crate::signature;
use cosim_base::error::{Code, Error, Result};
use cosim_base::sha256;

/// The FMUs that a worker loads.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Allowed {
    /// Every FMU that a run sends.
    pub all: bool,
    /// FMUs with this SHA-256, with the path of the file if it is stored here.
    pub hashes: BTreeMap<String, Option<PathBuf>>,
}

/// Whether a text is a SHA-256 rather than a path.
pub(crate) fn is_hash(text: &str) -> bool {
    text.len() == 64 && text.bytes().all(|byte| byte.is_ascii_hexdigit())
}

impl Allowed {
    /// Takes hashes, FMU files, and folders with FMU files; a hash may be followed by `=` and its
    /// file. If a public key is given, files must be signed with it.
    pub fn new(all: bool, list: &[String], key: Option<&Path>) -> Result<Self> {
        if all && key.is_some() {
            return Err(Error::new(Code::Usage, "FMUs that a run sends have no signature")
                .help("remove --allow-upload, or --verify-signature"));
        }
        let mut hashes = BTreeMap::new();
        for item in list {
            let (hash, file) = match item.split_once('=') {
                Some((hash, file)) => (hash, Some(PathBuf::from(file))),
                None => (item.as_str(), None),
            };
            if is_hash(hash) {
                hashes.insert(hash.to_ascii_lowercase(), file);
                continue;
            }
            for file in files(Path::new(item))? {
                let bytes = cosim_base::files::read_input(&file)
                    .map_err(|why| unreadable(&file).why(why))?;
                if let Some(key) = key {
                    signature::verify_bytes(&bytes, &file, key)?;
                }
                hashes.insert(sha256(bytes), std::path::absolute(&file).ok());
            }
        }
        Ok(Self { all, hashes })
    }

    /// The same as a list for [`Allowed::new`] from which no file is read.
    pub fn list(&self) -> impl Iterator<Item = String> {
        self.hashes.iter().map(|(hash, file)| match file.as_deref().and_then(Path::to_str) {
            Some(file) => format!("{hash}={file}"),
            None => hash.clone(),
        })
    }

    /// The bytes of an FMU that is stored here, if the file has not changed.
    pub(crate) fn held(&self, file: &FmuFile) -> Option<Vec<u8>> {
        let bytes = std::fs::read(self.hashes.get(&file.sha256)?.as_deref()?).ok()?;
        (sha256(&bytes) == file.sha256).then_some(bytes)
    }

    /// The files that are stored here, by hash.
    pub(crate) fn files(&self) -> impl Iterator<Item = (&str, &Path)> {
        self.hashes.iter().filter_map(|(hash, file)| Some((hash.as_str(), file.as_deref()?)))
    }

    /// Refuses an FMU of a component if it is not allowed.
    pub(crate) fn check(&self, component: &str, file: &FmuFile) -> Result<()> {
        if self.all || self.hashes.contains_key(&file.sha256) {
            return Ok(());
        }
        let FmuFile { name, sha256 } = file;
        Err(Error::new(Code::NotAllowed, format!("{component}: this worker does not load {name}"))
            .why(format!("the FMU with the SHA-256 {sha256} is not allowed"))
            .help(format!(
                "start the worker with --allow {sha256}, with --allow and the file or its folder, \
                 or with --allow-upload for every FMU that a run sends"
            )))
    }
}

fn files(path: &Path) -> Result<Vec<PathBuf>> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let entries = std::fs::read_dir(path).map_err(|why| unreadable(path).why(why))?;
    let mut files: Vec<PathBuf> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|end| end == "fmu"))
        .collect();
    files.sort();
    if files.is_empty() {
        return Err(unreadable(path).why("there is no .fmu in this folder"));
    }
    Ok(files)
}

fn unreadable(path: &Path) -> Error {
    Error::new(Code::File, "the FMUs to allow cannot be read")
        .at(path)
        .help("--allow takes a SHA-256, an .fmu file, or a folder with .fmu files")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_files_and_folders_are_allowed_and_nothing_else() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
        std::fs::write(path("a.fmu"), "a").unwrap();
        std::fs::write(path("b.txt"), "b").unwrap();
        let of = |content: &str| FmuFile { sha256: sha256(content), name: "x.fmu".to_owned() };
        let hash = sha256("c").to_uppercase();
        for (list, allowed) in [
            (vec![], [false, false, false]),
            (vec![path("")], [true, false, false]),
            (vec![path("b.txt"), hash], [false, true, true]),
        ] {
            let list = Allowed::new(false, &list, None).unwrap();
            assert_eq!(["a", "b", "c"].map(|c| list.check("x", &of(c)).is_ok()), allowed);
        }
        assert!(Allowed::new(true, &[], None).unwrap().check("x", &of("a")).is_ok());
        let refusal = Allowed::default().check("pump", &of("a")).unwrap_err().to_string();
        for part in ["pump", "x.fmu", &sha256("a"), "--allow"] {
            assert!(refusal.contains(part), "{refusal}");
        }
        assert!(Allowed::new(false, &[path("none.fmu")], None).is_err());
    }

    #[test]
    fn with_a_key_only_signed_files_are_allowed() {
        let folder = tempfile::TempDir::new().unwrap();
        let file = folder.path().join("a.fmu");
        std::fs::write(&file, "a").unwrap();
        let [key, public] = signature::make(&folder.path().join("k")).unwrap();
        let list = [folder.path().display().to_string()];
        let error = Allowed::new(false, &list, Some(&public)).unwrap_err();
        assert_eq!(error.code(), Code::Signature);
        signature::sign(&file, &key).unwrap();
        assert_eq!(Allowed::new(false, &list, Some(&public)).unwrap().hashes.len(), 1);
        assert_eq!(Allowed::new(true, &[], Some(&public)).unwrap_err().code(), Code::Usage);
    }
}
