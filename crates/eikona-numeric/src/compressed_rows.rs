//! Items grouped by row.

use crate::error::NumericError;
use crate::observer::check_step;
use std::convert::Infallible;

/// Items grouped by row, in one array (compressed row storage).
///
/// ```
/// use eikona_numeric::CompressedRows;
/// let rows = CompressedRows::new(3, [(2, 'a'), (0, 'b'), (2, 'c')].into_iter());
/// assert_eq!([rows.row(0), rows.row(1), rows.row(2)], [&['b'][..], &[], &['a', 'c']]);
/// ```
#[derive(Clone, Debug)]
pub struct CompressedRows<I> {
    /// The items of row `r` are `items[starts[r]..starts[r + 1]]`.
    starts: Vec<u32>,
    items: Vec<I>,
}

impl<I: Copy + Default> CompressedRows<I> {
    /// Groups pairs of a row and an item by a counting sort. Each row keeps the order of its items.
    ///
    /// # Panics
    /// If an item is in a row that does not exist.
    ///
    /// # Cost
    /// Linear in the number of rows and items. The iterator runs twice.
    pub fn new(rows: usize, items: impl Iterator<Item = (u32, I)> + Clone) -> Self {
        match CompressedRows::grouped(rows, items, |_| Ok::<(), Infallible>(())) {
            Ok(grouped) => grouped,
        }
    }

    /// Groups pairs like [`new`](Self::new), unless the observer stops it.
    ///
    /// # Errors
    /// [`NumericError::Stopped`].
    pub fn unless_stopped(
        rows: usize,
        items: impl Iterator<Item = (u32, I)> + Clone,
    ) -> Result<Self, NumericError> {
        CompressedRows::grouped(rows, items, check_step)
    }

    /// Groups pairs, with a check of each step.
    fn grouped<E>(
        rows: usize,
        items: impl Iterator<Item = (u32, I)> + Clone,
        check: impl Fn(usize) -> Result<(), E>,
    ) -> Result<Self, E> {
        let mut starts = vec![0u32; rows + 1];
        for (step, (row, _)) in items.clone().enumerate() {
            check(step)?;
            starts[row as usize + 1] += 1;
        }
        for row in 0..rows {
            starts[row + 1] += starts[row];
        }
        let mut next = starts.clone();
        let mut grouped = vec![I::default(); starts[rows] as usize];
        for (step, (row, item)) in items.enumerate() {
            check(step)?;
            let place = &mut next[row as usize];
            grouped[*place as usize] = item;
            *place += 1;
        }
        Ok(CompressedRows { starts, items: grouped })
    }

    /// Returns the items of a row.
    #[inline]
    pub fn row(&self, row: usize) -> &[I] {
        &self.items[self.starts[row] as usize..self.starts[row + 1] as usize]
    }
    /// Returns the place of the first item of each row in [`items`](Self::items), followed by the
    /// number of items.
    pub fn starts(&self) -> &[u32] {
        &self.starts
    }
    /// Returns the items of all rows, one row after the other.
    pub fn items(&self) -> &[I] {
        &self.items
    }
    /// Returns the starts of the rows, and the items.
    pub fn into_parts(self) -> (Vec<u32>, Vec<I>) {
        (self.starts, self.items)
    }
}
