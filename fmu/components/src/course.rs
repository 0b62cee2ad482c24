//! Which course to follow: a built-in name or a file of waypoints.

use fmu_kit::{ParameterError, Resources, read_text};
use rexrov::guidance::Course;
use std::path::PathBuf;

/// The course named by the parameter `course`.
///
/// A file is searched for in the FMU's resources and then, like an absolute path, in the file
/// system (relative to the working directory of the importer).
///
/// # Errors
/// There is no such file, or it is not a course: with its line and the reason.
pub fn load(name: &str, resources: &Resources) -> Result<Course, ParameterError> {
    let error = |reason: String| ParameterError::new("course", reason);
    if let Some((_, text)) = Course::BUILT_IN.iter().find(|(known, _)| *known == name) {
        return Course::parse(text).map_err(|e| error(format!("{name}: {e}")));
    }
    let path = find(name, resources).map_err(error)?;
    let text = read_text(&path).map_err(error)?;
    Course::parse(&text).map_err(|e| error(format!("{path:?}, {e}")))
}

/// The file `name`; errors of reading it appear when it is read.
fn find(name: &str, resources: &Resources) -> Result<PathBuf, String> {
    let mut places = vec![PathBuf::from(name)];
    places.splice(0..0, resources.folder().map(|folder| folder.join(name)));
    if let Some(path) = places.iter().find(|path| path.try_exists().unwrap_or(true)) {
        return Ok(path.clone());
    }
    let known = Course::BUILT_IN.map(|(name, _)| name).join(", ");
    let places: Vec<_> = places.iter().map(|path| format!("{path:?}")).collect();
    Err(format!(
        "{name:?} is neither a built-in course ({known}) nor a waypoint file: there is no {}",
        places.join(" and no ")
    ))
}
