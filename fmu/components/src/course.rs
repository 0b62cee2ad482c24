//! Which course to follow: a built-in name or a file of waypoints.

use fmu_kit::{ParameterError, Resources};
use rexrov::guidance::Course;
use std::path::Path;

/// Built-in courses.
const BUILT_IN: [(&str, &str); 3] =
    [("BE1", Course::BE1), ("BE2", Course::BE2), ("BE3", Course::BE3)];

/// The course that the parameter `course` names.
///
/// A file is looked for in the FMU's resources and then, like an absolute path, in the file system
/// (relative to the working directory of the importer).
///
/// # Errors
/// There is no such file, or it is no course: with its line and the reason.
pub fn load(name: &str, resources: &Resources) -> Result<Course, ParameterError> {
    let error = |reason: String| ParameterError::new("course", reason);
    if let Some((_, text)) = BUILT_IN.iter().find(|(known, _)| *known == name) {
        return Course::parse(text).map_err(|e| error(format!("{name}: {e}")));
    }
    let in_resources = resources.folder().map(|folder| folder.join(name));
    let path = in_resources.filter(|path| path.is_file()).unwrap_or_else(|| Path::new(name).into());
    let text = std::fs::read_to_string(&path).map_err(|cause| {
        let known = BUILT_IN.map(|(name, _)| name).join(", ");
        error(format!(
            "\"{name}\" is neither a built-in course ({known}) nor a readable waypoint file: {cause}"
        ))
    })?;
    Course::parse(&text).map_err(|e| error(format!("{}: {e}", path.display())))
}
