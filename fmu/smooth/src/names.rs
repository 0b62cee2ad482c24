//! The name that was meant by one that does not exist.

/// The nearest of the names there are, if it is near.
pub(crate) fn nearest<'a>(name: &str, names: &[&'a str]) -> Option<&'a str> {
    let distance = |other: &str| strsim::damerau_levenshtein(&name.to_lowercase(), &other.to_lowercase());
    let near = names.iter().map(|&other| (distance(other), other)).min()?;
    (near.0 <= (name.len() / 4).max(1)).then_some(near.1)
}

/// `did you mean 'x'?`, or what there is.
pub(crate) fn hint(name: &str, names: &[&str]) -> String {
    match nearest(name, names) {
        Some(meant) => format!("did you mean '{meant}'?"),
        None => format!("there are {}", names.join(", ")),
    }
}
