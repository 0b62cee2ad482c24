//! The folder of files an FMU carries along.

use std::path::{Path, PathBuf};

use super::ParameterError;

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

    /// The text of the file `name` in the folder; `variable` is the parameter that asked for it.
    ///
    /// # Errors
    /// There is no folder, `name` leads out of it, or the file cannot be read as UTF-8.
    pub fn read_to_string(&self, variable: &str, name: &str) -> Result<String, ParameterError> {
        let error = |reason: String| ParameterError::new(variable, reason);
        let folder = self.folder().ok_or_else(|| {
            error(format!("needs the file \"{name}\", but the importer gave no resource location"))
        })?;
        let relative = Path::new(name);
        if !relative.components().all(|part| matches!(part, std::path::Component::Normal(_))) {
            return Err(error(format!(
                "\"{name}\" leads out of the resources folder; name a file inside it"
            )));
        }
        let path = folder.join(relative);
        std::fs::read_to_string(&path)
            .map_err(|cause| error(format!("cannot read \"{}\": {cause}", path.display())))
    }
}
