//! A part of a campaign: which runs belong to it, and where its number comes from.

use std::str::FromStr;

/// One of several parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shard {
    /// Counted from 0.
    index: u64,
    count: u64,
}

impl Shard {
    /// Its folder beside those of the others.
    pub(super) fn folder(self) -> String {
        format!("shard-{}-of-{}", self.index + 1, self.count)
    }

    /// Whether a run belongs to it: every part has runs of all cells, and further seeds do not move
    /// a run to another part.
    pub(super) fn has(self, run: u64, cells: usize) -> bool {
        let cells = cells as u64;
        (run / cells + run % cells) % self.count == self.index
    }

    fn new(index: u64, count: u64) -> Result<Self, String> {
        match index < count {
            true => Ok(Self { index, count }),
            false => Err(format!("there is no part {} of {count}", index + 1)),
        }
    }

    fn read(text: &str, environment: impl Fn(&str) -> Option<String>) -> Result<Self, String> {
        let number = |what: &str, text: &str| {
            text.parse::<u64>().map_err(|_| format!("{what} is '{text}', which is not an integer"))
        };
        let number_of = |name: &str| environment(name).map(|text| number(name, &text)).transpose();
        let (first, count) = match text.split_once('/') {
            Some((first, count)) => (first, Some(number("the count", count)?)),
            None => (text, None),
        };
        if first != "auto" {
            let count = count.ok_or("write 1/8, auto or auto/8")?;
            return match number("the part", first)? {
                0 => Err("the first part is 1".to_owned()),
                index => Self::new(index - 1, count),
            };
        }
        if let Some(task) = number_of("SLURM_ARRAY_TASK_ID")? {
            let least = number_of("SLURM_ARRAY_TASK_MIN")?.unwrap_or(0);
            let count = count.or(number_of("SLURM_ARRAY_TASK_COUNT")?);
            let count = count.ok_or("SLURM_ARRAY_TASK_COUNT is not set; write auto/8")?;
            return Self::new(task.saturating_sub(least), count);
        }
        match (number_of("JOB_COMPLETION_INDEX")?, count) {
            (Some(index), Some(count)) => Self::new(index, count),
            (Some(_), None) => {
                Err("Kubernetes does not provide the number of parts; write auto/8".into())
            }
            (None, _) => {
                Err("neither SLURM_ARRAY_TASK_ID nor JOB_COMPLETION_INDEX is set".to_owned())
            }
        }
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::read(text, |name| std::env::var(name).ok())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_comes_from_the_option_or_from_the_scheduler() {
        let read = |text: &str, set: &[(&str, &str)]| {
            let value =
                |name: &str| set.iter().find(|(n, _)| *n == name).map(|(_, v)| v.to_string());
            Shard::read(text, value)
        };
        let shard = |index, count| Ok(Shard { index, count });
        assert_eq!(read("1/8", &[]), shard(0, 8));
        assert_eq!(read("8/8", &[]), shard(7, 8));
        let slurm = [
            ("SLURM_ARRAY_TASK_ID", "7"),
            ("SLURM_ARRAY_TASK_MIN", "5"),
            ("SLURM_ARRAY_TASK_COUNT", "4"),
        ];
        assert_eq!(read("auto", &slurm), shard(2, 4));
        assert_eq!(read("auto/6", &slurm), shard(2, 6));
        assert_eq!(read("auto/3", &[("JOB_COMPLETION_INDEX", "2")]), shard(2, 3));
        for (text, set, why) in [
            ("0/8", &[][..], "first part is 1"),
            ("9/8", &[], "no part 9 of 8"),
            ("1/0", &[], "no part 1 of 0"),
            ("3", &[], "1/8"),
            ("x/8", &[], "'x'"),
            ("auto", &[], "SLURM_ARRAY_TASK_ID"),
            ("auto", &[("JOB_COMPLETION_INDEX", "2")], "auto/8"),
        ] {
            let error = read(text, set).unwrap_err();
            assert!(error.contains(why), "{text}: {error}");
        }
    }

    #[test]
    fn each_run_is_in_one_part_and_parts_have_runs_of_all_cells() {
        let (count, cells) = (3, 6);
        let mut seen = vec![0; 60];
        for index in 0..count {
            let shard = Shard { index, count };
            let runs: Vec<u64> = (0..60).filter(|run| shard.has(*run, cells)).collect();
            assert_eq!(runs.len(), 20);
            assert!((0..6).all(|cell| runs.iter().any(|run| run % 6 == cell)));
            runs.iter().for_each(|run| seen[*run as usize] += 1);
        }
        assert!(seen.iter().all(|count| *count == 1));
    }
}
