//! Names as people type them: the nearest valid one, and patterns with `*` and `?`.

/// Longest name that is compared: the comparison takes time and memory by the square.
const MAX_COMPARED: usize = 256;

/// The candidate nearest to `name`, when one is near enough to be meant.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if name.len() > MAX_COMPARED {
        return None;
    }
    candidates
        .into_iter()
        .filter(|candidate| candidate.len() <= MAX_COMPARED)
        .map(|candidate| (strsim::damerau_levenshtein(name, candidate), candidate))
        .min_by_key(|&(distance, _)| distance)
        .filter(|&(distance, candidate)| distance <= (candidate.len().max(name.len()) / 2).max(1))
        .map(|(_, candidate)| candidate)
}

/// `did you mean 'x'?`, or nothing.
pub fn did_you_mean<'a>(
    name: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Option<String> {
    nearest(name, candidates).map(|found| format!("did you mean '{found}'?"))
}

/// Whether `pattern` is more than a plain name. Brackets are ordinary: variables use them.
pub fn is_pattern(pattern: &str) -> bool {
    pattern.contains(['*', '?'])
}

/// Whether `name` matches `pattern`: `*` is any text, `?` one character, the rest is literal.
pub fn matches(pattern: &str, name: &str) -> bool {
    let (pattern, name) = (pattern.as_bytes(), name.as_bytes());
    let (mut p, mut n) = (0, 0);
    let mut retry = None;
    while n < name.len() {
        match pattern.get(p) {
            Some(b'*') => {
                retry = Some((p + 1, n));
                p += 1;
            }
            Some(&c) if c == b'?' || c == name[n] => {
                p += 1;
                n += 1;
            }
            _ => {
                let Some((after_star, from)) = retry else {
                    return false;
                };
                retry = Some((after_star, from + 1));
                (p, n) = (after_star, from + 1);
            }
        }
    }
    pattern[p..].iter().all(|&c| c == b'*')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns() {
        assert!(matches("plant.pose.*", "plant.pose.x"));
        assert!(matches("*.thruster[?].force", "plant.thruster[3].force"));
        assert!(matches("*", ""));
        assert!(!matches("plant.pose", "plant.pose.x"));
        assert!(!matches("*.y", "plant.pose.x"));
        assert!(matches("a*b*c", "a-b-b-c"));
    }

    #[test]
    fn nearest_name() {
        let names = ["plant.pose.x", "plant.pose.y", "gps"];
        assert_eq!(nearest("plant.poze.x", names), Some("plant.pose.x"));
        assert_eq!(nearest("quite different thing", names), None);
    }
}
