//! Samples on their way to clients, limited to what they can use.

/// Times and rows of values.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Batch {
    /// Nanoseconds.
    pub(super) times: Vec<i64>,
    /// Row by row.
    pub(super) values: Vec<f64>,
    pub(super) width: usize,
}

impl Batch {
    pub(super) fn rows(&self) -> impl Iterator<Item = (i64, &[f64])> {
        self.times.iter().copied().zip(self.values.chunks_exact(self.width.max(1)))
    }

    fn push(&mut self, time: i64, row: &[f64]) {
        self.times.push(time);
        self.values.extend_from_slice(row);
    }

    /// Drops every second row; the newest stays.
    fn halve(&mut self) {
        let (width, count) = (self.width, self.times.len());
        let mut kept = 0;
        for at in (0..count).filter(|at| (count - 1 - at) % 2 == 0) {
            self.times[kept] = self.times[at];
            self.values.copy_within(at * width..(at + 1) * width, kept * width);
            kept += 1;
        }
        self.times.truncate(kept);
        self.values.truncate(kept * width);
    }
}

/// Keeps a limited number of evenly spaced samples: when it is full, it drops every second one, and
/// from then on takes only every second one. The newest is kept in any case: after the end of a run
/// no other follows.
#[derive(Debug, Clone)]
pub(super) struct Thinned {
    pub(super) batch: Batch,
    most: usize,
    stride: usize,
    skipped: usize,
    /// The newest sample, if it is not among the others.
    newest: Option<i64>,
    row: Vec<f64>,
}

impl Thinned {
    /// At most this many rows of this width, and at least two.
    pub(super) fn new(width: usize, most: usize) -> Self {
        let batch = Batch { width, ..Batch::default() };
        Self { batch, most: most.max(2), stride: 1, skipped: 0, newest: None, row: Vec::new() }
    }

    pub(super) fn push(&mut self, time: i64, row: &[f64]) {
        self.skipped += 1;
        if self.skipped < self.stride {
            self.newest = Some(time);
            self.row.clear();
            self.row.extend_from_slice(row);
            return;
        }
        (self.skipped, self.newest) = (0, None);
        self.batch.push(time, row);
        if self.batch.times.len() > self.most {
            self.batch.halve();
            self.stride *= 2;
        }
    }

    /// The stored samples, with the newest.
    pub(super) fn all(&self) -> Batch {
        let mut all = self.batch.clone();
        self.newest.iter().for_each(|time| all.push(*time, &self.row));
        all
    }

    /// Takes the stored samples; the next ones are again taken one by one.
    pub(super) fn take(&mut self) -> Batch {
        if let Some(time) = self.newest.take() {
            self.batch.push(time, &self.row);
        }
        (self.stride, self.skipped) = (1, 0);
        let width = self.batch.width;
        std::mem::replace(&mut self.batch, Batch { width, ..Batch::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_kept_evenly_and_never_more_than_asked() {
        let mut thinned = Thinned::new(1, 8);
        for time in 0..1000 {
            thinned.push(time, &[time as f64]);
            assert!(thinned.batch.times.len() <= 8);
            assert_eq!(
                thinned.all().times.last(),
                Some(&time),
                "a client that connects now gets the newest"
            );
        }
        assert_eq!(thinned.all(), thinned.clone().take());
        let Batch { mut times, values, .. } = thinned.take();
        assert_eq!(times.last(), Some(&999), "the newest is there, though it is not evenly spaced");
        assert!(times.iter().zip(&values).all(|(time, value)| *time as f64 == *value));
        times.pop();
        let gaps: Vec<i64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(gaps.iter().all(|gap| *gap == gaps[0]), "{times:?}");
        thinned.push(1000, &[0.5]);
        assert_eq!(thinned.take().times, [1000]);
    }
}
