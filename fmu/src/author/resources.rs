//! The folder of files in an FMU, and how a text file is read.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::ParameterError;

/// Larger files are not parameters of a component, and reading them would use up the importer's
/// memory.
const LARGEST_BYTES: u64 = 16 << 20;

/// The FMU's `resources` folder, if the importer named one that is a file path.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Resources {
    folder: Option<PathBuf>,
}

impl Resources {
    /// No resources: the importer named no location.
    #[must_use]
    pub const fn none() -> Self {
        Self { folder: None }
    }

    /// Resources in a folder of the file system.
    pub fn in_folder(folder: impl Into<PathBuf>) -> Self {
        Self { folder: Some(folder.into()) }
    }

    /// The folder itself.
    #[must_use]
    pub fn folder(&self) -> Option<&Path> {
        self.folder.as_deref()
    }

    /// The text of the file `name` in the folder; `variable` is the parameter that names it.
    ///
    /// # Errors
    /// There is no folder, `name` leads out of it, or [`read_text`] finds the file unreadable.
    pub fn read_to_string(&self, variable: &str, name: &str) -> Result<String, ParameterError> {
        let error = |reason: String| ParameterError::new(variable, reason);
        let folder = self.folder().ok_or_else(|| {
            error(format!("needs the file {name:?}, but the importer gave no resource location"))
        })?;
        let relative = Path::new(name);
        if !relative.components().all(|part| matches!(part, std::path::Component::Normal(_))) {
            return Err(error(format!(
                "{name:?} leads out of the resources folder; name a file inside it"
            )));
        }
        read_text(&folder.join(relative)).map_err(error)
    }
}

/// The text of a file: a regular file of at most 16 MiB, in UTF-8.
///
/// # Errors
/// The reason in words, with the file and, if the text is wrong, the line.
pub fn read_text(path: &Path) -> Result<String, String> {
    let cannot = |reason: String| format!("cannot read {path:?}: {reason}");
    // Before it is opened: opening a pipe would wait for its other end.
    let kind = path.metadata().map_err(|cause| cannot(cause.to_string()))?;
    if !kind.is_file() {
        let what = if kind.is_dir() { "a folder" } else { "a device or a pipe" };
        return Err(cannot(format!("it is {what}, not a file")));
    }
    let mut bytes = Vec::new();
    let read = |file: File| file.take(LARGEST_BYTES + 1).read_to_end(&mut bytes);
    File::open(path).and_then(read).map_err(|cause| cannot(cause.to_string()))?;
    if bytes.len() as u64 > LARGEST_BYTES {
        return Err(cannot(format!("it has more than {} MiB", LARGEST_BYTES >> 20)));
    }
    String::from_utf8(bytes).map_err(|error| {
        let (bytes, end) = (error.as_bytes(), error.utf8_error().valid_up_to());
        let line = 1 + bytes.iter().take(end).filter(|byte| **byte == b'\n').count();
        format!("{path:?}, line {line}: not text in UTF-8")
    })
}
