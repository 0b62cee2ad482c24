//! Columns of numbers that are not kept in memory: rows are added at the end, columns are read.
//!
//! Rows become blocks, and a block is written column by column to a file without a name, which ends
//! with the process. Small tables never get a file.

use std::io;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use cosim_base::files::Unfinished;

/// Numbers of a block: so few that they do not count, so many that a column is read in few parts.
const BLOCK: usize = 1 << 16;
/// Octets of a number.
const NUMBER: usize = size_of::<f64>();

/// A table of numbers.
pub(super) struct Columns {
    pub(super) width: usize,
    /// The number of rows.
    count: usize,
    /// Where its file may be.
    folder: PathBuf,
    file: Option<Unfinished>,
    /// The rows after the last whole block, one after another.
    rest: Vec<f64>,
}

impl Columns {
    /// An empty table of so many columns; its file is in `folder`, or with other temporary files if
    /// nothing can be written there.
    pub(super) fn new(width: usize, folder: &Path) -> Self {
        Self { width, count: 0, folder: folder.to_owned(), file: None, rest: Vec::new() }
    }

    /// Rows of a block.
    fn rows(&self) -> usize {
        (BLOCK / self.width.max(1)).max(1)
    }

    /// Adds a row.
    pub(super) fn push(&mut self, row: impl IntoIterator<Item = f64>) -> io::Result<()> {
        self.rest.extend(row);
        self.count += 1;
        if self.rest.len() < self.rows() * self.width.max(1) { Ok(()) } else { self.write() }
    }

    /// Writes a block.
    fn write(&mut self) -> io::Result<()> {
        let file = match self.file.take() {
            Some(file) => file,
            None => Unfinished::new(&self.folder.join(NAME))
                .or_else(|_| Unfinished::new(&std::env::temp_dir().join(NAME)))?,
        };
        let file = self.file.insert(file).file();
        let (rows, mut part) = (self.rest.len() / self.width, Vec::new());
        for place in 0..self.width {
            part.clear();
            for number in self.rest.iter().skip(place).step_by(self.width) {
                part.extend_from_slice(&number.to_ne_bytes());
            }
            let begin = ((self.count - rows) * self.width + place * rows) * NUMBER;
            file.write_all_at(&part, begin as u64)?;
        }
        self.rest.clear();
        Ok(())
    }

    /// A column.
    pub(super) fn column(&self, place: usize) -> io::Result<Vec<f64>> {
        self.of(place, 0..self.count)
    }

    /// These rows of a column: fast if most are close to the one before.
    pub(super) fn of(
        &self,
        place: usize,
        rows: impl IntoIterator<Item = usize>,
    ) -> io::Result<Vec<f64>> {
        let (of_block, first) = (self.rows(), self.count - self.rest.len() / self.width);
        let (mut octets, mut part, mut begin) = (vec![0; of_block * NUMBER], Vec::new(), 0);
        let number = |row: usize| {
            if row >= first {
                return Ok(self.rest[(row - first) * self.width + place]);
            }
            if !(begin..begin + part.len()).contains(&row)
                && let Some(file) = &self.file
            {
                begin = row / of_block * of_block;
                let at = (begin * self.width + place * of_block) * NUMBER;
                file.file().read_exact_at(&mut octets, at as u64)?;
                part.clear();
                part.extend(octets.as_chunks().0.iter().map(|number| f64::from_ne_bytes(*number)));
            }
            Ok(part[row - begin])
        };
        rows.into_iter().map(number).collect()
    }
}

/// What its file is called where files must have a name.
const NAME: &str = "columns";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_those_of_all_rows_wherever_these_are() {
        let folder = tempfile::tempdir().unwrap();
        for (width, count) in [(1, 3), (3, 3 * BLOCK / 3 + 5), (BLOCK, 2), (BLOCK + 1, 2)] {
            let mut columns = Columns::new(width, folder.path());
            let number = |row: usize, place: usize| (row * width + place) as f64 - 0.5;
            for row in 0..count {
                columns.push((0..width).map(|place| number(row, place))).unwrap();
            }
            assert_eq!(
                columns.of(0, [count - 1, 0]).unwrap(),
                [number(count - 1, 0), number(0, 0)]
            );
            for place in [0, width / 2, width - 1] {
                let wanted: Vec<f64> = (0..count).map(|row| number(row, place)).collect();
                assert!(columns.column(place).unwrap() == wanted, "{place} of {width}");
            }
            assert!(columns.rest.len() < BLOCK.max(width));
        }
        // Its file has no name.
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        let mut elsewhere = Columns::new(BLOCK, Path::new("/nowhere"));
        elsewhere.push((0..BLOCK).map(|place| place as f64)).unwrap();
        assert_eq!(elsewhere.column(7).unwrap(), [7.0]);
    }
}
