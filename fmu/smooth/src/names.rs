//! The probable intended name for a name that does not exist.

/// The nearest of the known names, if no more than one in `tolerance` letters differs.
pub(crate) fn nearest<'a>(name: &str, names: &[&'a str], tolerance: usize) -> Option<&'a str> {
    let name = name.to_lowercase();
    let distance = |other: &str| strsim::damerau_levenshtein(&name, &other.to_lowercase());
    let near = names.iter().map(|&other| (distance(other), other)).min()?;
    (near.0 <= (name.len() / tolerance).max(1)).then_some(near.1)
}

/// `did you mean 'x'?`, or the known names.
pub(crate) fn hint(name: &str, names: &[&str]) -> String {
    match nearest(name, names, 2) {
        Some(meant) => format!("did you mean '{meant}'?"),
        None => format!("there are {}", names.join(", ")),
    }
}
