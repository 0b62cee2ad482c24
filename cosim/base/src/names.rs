//! Names typed by users: the nearest valid one, and patterns with `*` and `?`.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

/// Longest name that is compared: time and memory of the comparison grow with its square.
const MAX_COMPARED: usize = 256;
/// Maximum number of compared character pairs, for one name and in total for a process. Names also
/// come from files: a file with many wrong and many valid names would keep the process busy for
/// hours.
const MAX_PAIRS: u64 = 1 << 22;
const MAX_PAIRS_IN_ALL: u64 = 1 << 28;

/// The candidate nearest to `name`, if one is close enough to be meant.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    static SPENT: AtomicU64 = AtomicU64::new(0);
    if name.len() > MAX_COMPARED || SPENT.load(Ordering::Relaxed) > MAX_PAIRS_IN_ALL {
        return None;
    }
    let mut pairs = 0;
    let mut affordable = |candidate: &str| {
        let more = ((name.len() + 1) * (candidate.len() + 1)) as u64;
        pairs += more;
        SPENT.fetch_add(more, Ordering::Relaxed);
        pairs <= MAX_PAIRS
    };
    candidates
        .into_iter()
        .filter(|candidate| candidate.len() <= MAX_COMPARED)
        .take_while(|candidate| affordable(candidate))
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

/// `did you mean 'x.fmu'?`, among the files in the folder of `path` with the same extension.
pub fn file_like(path: &Path) -> Option<String> {
    let files = std::fs::read_dir(path.parent()?).ok()?.flatten().map(|file| file.path());
    let alike = files.filter(|file| file.extension() == path.extension());
    let names: Vec<String> =
        alike.filter_map(|file| Some(file.file_name()?.to_str()?.to_owned())).collect();
    did_you_mean(path.file_name()?.to_str()?, names.iter().map(String::as_str))
}

/// Whether `pattern` is more than a plain name. Brackets are literal: variables use them.
pub fn is_pattern(pattern: &str) -> bool {
    pattern.contains(['*', '?'])
}

/// What all names that match `pattern` start with.
pub fn literal_start(pattern: &str) -> &str {
    pattern.split(['*', '?']).next().unwrap_or_default()
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

/// Aliases of variables and components: with `gps` for `fix`, `gps.stamp` is `fix.stamp`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Aliases(Vec<(String, String)>);

impl Aliases {
    /// From pairs of an alias, which is a name or its prefix up to a dot, and its meaning.
    pub fn new(mut pairs: Vec<(String, String)>) -> Self {
        // If two match, the longer one is meant.
        pairs.sort_by_key(|(alias, _)| std::cmp::Reverse(alias.len()));
        Self(pairs)
    }

    /// The meaning of a name, or of a pattern that starts with an alias.
    pub fn resolve(&self, name: &str) -> String {
        let meant = self.0.iter().find_map(|(alias, meant)| {
            let rest = name.strip_prefix(alias.as_str())?;
            (rest.is_empty() || rest.starts_with('.')).then(|| format!("{meant}{rest}"))
        });
        meant.unwrap_or_else(|| name.to_owned())
    }

    /// Aliases with their meanings.
    pub fn pairs(&self) -> &[(String, String)] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_alias_stands_for_a_whole_part_of_a_name_and_the_longest_one_wins() {
        let pair = |alias: &str, meant: &str| (alias.to_owned(), meant.to_owned());
        let pairs =
            vec![pair("imu", "unit"), pair("gps", "fix"), pair("imu.attitude", "ahrs.tilt")];
        let aliases = Aliases::new(pairs);
        for (name, meant) in [
            ("gps", "fix"),
            ("gps.position.?", "fix.position.?"),
            ("imu.attitude.yaw", "ahrs.tilt.yaw"),
            ("imu.stamp", "unit.stamp"),
            ("gps2.stamp", "gps2.stamp"),
        ] {
            assert_eq!(aliases.resolve(name), meant);
        }
    }

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
