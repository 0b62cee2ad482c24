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
/// from then on takes only every second one.
#[derive(Debug, Clone)]
pub(super) struct Thinned {
    pub(super) batch: Batch,
    most: usize,
    stride: usize,
    skipped: usize,
}

impl Thinned {
    /// At most this many rows of this width, and at least two.
    pub(super) fn new(width: usize, most: usize) -> Self {
        let batch = Batch { width, ..Batch::default() };
        Self { batch, most: most.max(2), stride: 1, skipped: 0 }
    }

    pub(super) fn push(&mut self, time: i64, row: &[f64]) {
        self.skipped += 1;
        if self.skipped < self.stride {
            return;
        }
        self.skipped = 0;
        self.batch.push(time, row);
        if self.batch.times.len() > self.most {
            self.batch.halve();
            self.stride *= 2;
        }
    }

    /// Takes the stored samples; the next ones are again taken one by one.
    pub(super) fn take(&mut self) -> Batch {
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
        }
        let Batch { times, values, .. } = thinned.take();
        let gaps: Vec<i64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(gaps.iter().all(|gap| *gap == gaps[0]), "{times:?}");
        assert!(times.iter().zip(&values).all(|(time, value)| *time as f64 == *value));
        thinned.push(1000, &[0.5]);
        assert_eq!(thinned.take().times, [1000]);
    }
}
