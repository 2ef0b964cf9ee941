//! Structure of the factor: supernodes, their row indices, and the supernodal elimination tree.

use crate::compressed_rows::CompressedRows;
use crate::error::NumericError;
use crate::observer::check_step;
use std::ops::Range;

const NONE: u32 = u32::MAX;

/// Relaxed amalgamation: the largest share of explicit zeros in a supernode, by its number of
/// columns. A few large blocks are faster than many small ones. (Measured at 100,000 faces: halving
/// or doubling these shares changes the times by a few percent.)
const RELAXED: [(usize, f64); 4] = [(16, 0.3), (32, 0.2), (64, 0.15), (usize::MAX, 0.05)];

/// Supernodes in elimination order: consecutive columns with the same rows below them.
#[derive(Debug)]
pub(crate) struct Supernodes {
    /// First column of each supernode, followed by the number of columns.
    begin: Vec<u32>,
    /// Row indices below the diagonal block, ascending: `rows[row_ptr[s]..row_ptr[s + 1]]`.
    row_ptr: Vec<usize>,
    rows: Vec<u32>,
    /// Start of each panel in the values of the factor.
    value_ptr: Vec<usize>,
    parent: Vec<u32>,
    first_descendant: Vec<usize>,
    /// Whether the depth of a supernode in the elimination tree is odd.
    odd: Vec<bool>,
    stack_entries: [usize; 2],
    largest_height: usize,
}

impl Supernodes {
    /// Builds the supernodes of a lower triangle by columns, with sorted rows and the diagonal
    /// first, in postorder of the elimination tree `parent`.
    ///
    /// # Errors
    /// [`NumericError::Stopped`].
    pub(crate) fn of(parent: &[u32], col_ptr: &[u32], row_idx: &[u32]) -> Result<Supernodes, NumericError> {
        let mut builder = Builder::new(parent.len());
        for column in 0..parent.len() {
            check_step(column)?;
            let entries = &row_idx[col_ptr[column] as usize + 1..col_ptr[column + 1] as usize];
            let continues = column > 0 && parent[column - 1] == column as u32;
            if !(continues && builder.extend(column, entries)) {
                builder.close(column);
                builder.open(column, entries);
            }
        }
        builder.close(parent.len());
        Ok(builder.finish())
    }

    /// Multiplications in the front of a supernode.
    pub(crate) fn work(&self, s: usize) -> f64 {
        let (width, below) = (self.columns(s).len() as f64, self.rows(s).len() as f64);
        width * (below * below + width * below + width * width / 3.0)
    }

    pub(crate) fn count(&self) -> usize {
        self.begin.len() - 1
    }
    #[inline(always)]
    pub(crate) fn columns(&self, s: usize) -> Range<usize> {
        self.begin[s] as usize..self.begin[s + 1] as usize
    }
    /// Returns the supernode of a column.
    pub(crate) fn of_column(&self, column: usize) -> usize {
        self.begin.partition_point(|&begin| begin as usize <= column) - 1
    }
    #[inline(always)]
    pub(crate) fn rows(&self, s: usize) -> &[u32] {
        &self.rows[self.row_ptr[s]..self.row_ptr[s + 1]]
    }
    /// Range of a supernode's panel in the values of the factor, stored by columns.
    #[inline(always)]
    pub(crate) fn panel(&self, s: usize) -> Range<usize> {
        self.value_ptr[s]..self.value_ptr[s + 1]
    }
    /// Number of stored entries of the factor.
    pub(crate) fn entries(&self) -> usize {
        self.value_ptr[self.count()]
    }
    /// Rows of the tallest panel.
    pub(crate) fn largest_height(&self) -> usize {
        self.largest_height
    }

    /// Whether the update matrix of a supernode waits on the second stack.
    ///
    /// Update matrices wait for assembly on two stacks, one for even and one for odd depth: the
    /// children of a front lie on top of one stack while the front's own update matrix is formed on
    /// top of the other.
    pub(crate) fn is_odd(&self, s: usize) -> bool {
        self.odd[s]
    }
    /// Largest number of entries on each stack.
    pub(crate) fn stack_entries(&self) -> [usize; 2] {
        self.stack_entries
    }

    /// Parent in the supernodal elimination tree.
    pub(crate) fn parent(&self, s: usize) -> Option<usize> {
        Some(self.parent[s]).filter(|&parent| parent != NONE).map(|parent| parent as usize)
    }
    /// First supernode in the subtree of a supernode.
    pub(crate) fn first_descendant(&self, s: usize) -> usize {
        self.first_descendant[s]
    }
    /// Children in the supernodal elimination tree, the last one first.
    pub(crate) fn children(&self, s: usize) -> impl Iterator<Item = usize> {
        // The last descendant of a supernode is its last child, and precedes it.
        let mut child = s.checked_sub(1).filter(|&c| self.parent(c) == Some(s));
        std::iter::from_fn(move || {
            let this = child?;
            child = self.first_descendant[this].checked_sub(1).filter(|&c| self.parent(c) == Some(s));
            Some(this)
        })
    }

    /// Marks all ancestors of the marked supernodes.
    pub(crate) fn mark_ancestors(&self, marked: &mut [bool]) {
        for s in 0..marked.len() {
            if marked[s] && self.parent[s] != NONE {
                marked[self.parent[s] as usize] = true;
            }
        }
    }
}

/// Completed supernode, which its parent may still absorb.
#[derive(Clone, Copy)]
struct Supernode {
    begin: usize,
    end: usize,
    /// Explicit zeros in its panel.
    zeros: usize,
    /// The next supernode with the same first row.
    next: u32,
}

/// Builds supernodes column by column. The structure of a column is the union of its entries and
/// the rows of the supernodes whose first row it is, so every row list is read once or twice.
struct Builder {
    closed: Vec<Supernode>,
    row_ptr: Vec<usize>,
    rows: Vec<u32>,
    /// Last completed supernode whose first row is this column: head of a linked list.
    waiting: Vec<u32>,
    /// Marks rows of the open front with its first column.
    mark: Vec<u32>,
    /// Rows of the open front, unsorted; rows that have become columns are still among them.
    open_rows: Vec<u32>,
    open: Option<Supernode>,
    /// Number of rows below all columns.
    below: usize,
}

impl Builder {
    fn new(columns: usize) -> Self {
        Builder {
            closed: Vec::new(),
            row_ptr: vec![0],
            rows: Vec::new(),
            waiting: vec![NONE; columns],
            mark: vec![NONE; columns],
            open_rows: Vec::new(),
            open: None,
            below: 0,
        }
    }

    fn open(&mut self, column: usize, entries: &[u32]) {
        self.open_rows.clear();
        self.open = Some(Supernode { begin: column, end: column + 1, zeros: 0, next: NONE });
        self.gather(column, column as u32, entries);
        self.below = self.open_rows.len();
    }

    /// Adds the unmarked rows of a column.
    fn gather(&mut self, column: usize, mark: u32, entries: &[u32]) {
        let (marks, rows) = (&mut self.mark, &mut self.open_rows);
        let mut add = |row: u32| {
            if marks[row as usize] != mark {
                marks[row as usize] = mark;
                rows.push(row);
            }
        };
        entries.iter().copied().for_each(&mut add);
        let mut child = self.waiting[column];
        while child != NONE {
            // Skip the first row: it is the column itself.
            let child_rows = self.row_ptr[child as usize] + 1..self.row_ptr[child as usize + 1];
            self.rows[child_rows].iter().copied().for_each(&mut add);
            child = self.closed[child as usize].next;
        }
    }

    /// Appends a column, the parent of the last one, to the open front, unless that stores too many
    /// zeros.
    fn extend(&mut self, column: usize, entries: &[u32]) -> bool {
        let Some(front) = self.open else { return false };
        let known = self.open_rows.len();
        self.gather(column, front.begin as u32, entries);
        let added = self.open_rows.len() - known;
        let width = column - front.begin;
        let zeros = front.zeros + width * added;
        let below = self.below - 1 + added;
        if !acceptable(width + 1, below, zeros) {
            self.open_rows.truncate(known);
            return false;
        }
        self.open = Some(Supernode { end: column + 1, zeros, ..front });
        self.below = below;
        true
    }

    /// Completes the open front at `column`; absorbs the children right before it while few zeros
    /// are added.
    fn close(&mut self, column: usize) {
        let Some(mut front) = self.open.take() else { return };
        self.open_rows.retain(|&row| row as usize >= column);
        self.open_rows.sort_unstable();
        while let Some(&last) = self.closed.last() {
            let last_rows = &self.rows[self.row_ptr[self.closed.len() - 1]..];
            if last_rows.first().is_none_or(|&row| row as usize >= column) {
                break;
            }
            let missing = column - front.begin + self.open_rows.len() - last_rows.len();
            let zeros = front.zeros + last.zeros + (last.end - last.begin) * missing;
            if !acceptable(column - last.begin, self.open_rows.len(), zeros) {
                break;
            }
            front = Supernode { begin: last.begin, zeros, ..front };
            self.closed.pop();
            self.row_ptr.pop();
            self.rows.truncate(self.row_ptr[self.closed.len()]);
        }
        if let Some(&first) = self.open_rows.first() {
            front.next = self.waiting[first as usize];
            self.waiting[first as usize] = self.closed.len() as u32;
        }
        self.rows.extend_from_slice(&self.open_rows);
        self.row_ptr.push(self.rows.len());
        self.closed.push(front);
    }

    fn finish(self) -> Supernodes {
        let Builder { closed, row_ptr, rows, mark, .. } = self;
        let count = closed.len();
        let mut begin: Vec<u32> = closed.iter().map(|s| s.begin as u32).collect();
        begin.push(mark.len() as u32);
        let mut owner = mark; // reused for the supernode of each column
        for (s, columns) in begin.windows(2).enumerate() {
            owner[columns[0] as usize..columns[1] as usize].fill(s as u32);
        }
        let mut value_ptr = Vec::with_capacity(count + 1);
        value_ptr.push(0);
        let mut parent = Vec::with_capacity(count);
        let mut largest_height = 0;
        for s in 0..count {
            let below = row_ptr[s + 1] - row_ptr[s];
            let width = (begin[s + 1] - begin[s]) as usize;
            value_ptr.push(value_ptr[s] + width * (width + below));
            largest_height = largest_height.max(width + below);
            parent.push(if below == 0 { NONE } else { owner[rows[row_ptr[s]] as usize] });
        }
        let mut odd = vec![false; count];
        for s in (0..count).rev().filter(|&s| parent[s] != NONE) {
            odd[s] = !odd[parent[s] as usize];
        }
        let mut first_descendant: Vec<usize> = (0..count).collect();
        for s in (0..count).filter(|&s| parent[s] != NONE) {
            let above = parent[s] as usize;
            first_descendant[above] = first_descendant[above].min(first_descendant[s]);
        }
        let stack_entries = stack_entries(&parent, &odd, |s| row_ptr[s + 1] - row_ptr[s]);
        Supernodes {
            begin,
            row_ptr,
            rows,
            value_ptr,
            parent,
            first_descendant,
            odd,
            stack_entries,
            largest_height,
        }
    }
}

/// Whether a supernode with this shape may store this many explicit zeros.
fn acceptable(width: usize, below: usize, zeros: usize) -> bool {
    let entries = width * (width + 1) / 2 + width * below;
    let share = RELAXED.iter().find(|(columns, _)| width <= *columns).map_or(0.0, |(_, share)| *share);
    zeros as f64 <= share * entries as f64
}

/// Largest number of entries on each stack when every supernode pushes a square update matrix on
/// its own stack, then pops those of its children from the other.
fn stack_entries(parent: &[u32], odd: &[bool], size: impl Fn(usize) -> usize) -> [usize; 2] {
    let mut waiting: [Vec<(u32, usize)>; 2] = [Vec::new(), Vec::new()];
    let mut largest = [0; 2];
    for s in 0..parent.len() {
        let own = usize::from(odd[s]);
        if parent[s] != NONE {
            let top = waiting[own].last().map_or(0, |top| top.1) + size(s) * size(s);
            waiting[own].push((parent[s], top));
            largest[own] = largest[own].max(top);
        }
        while waiting[1 - own].pop_if(|(parent, _)| *parent == s as u32).is_some() {}
    }
    largest
}

/// Computes the elimination tree by Liu's algorithm with path compression. `rows` holds the
/// columns left of the diagonal of each row. Roots have the parent `NONE`.
pub(crate) fn elimination_tree(rows: &CompressedRows<u32>) -> Vec<u32> {
    let n = rows.starts().len() - 1;
    let mut parent = vec![NONE; n];
    let mut ancestor = vec![NONE; n];
    for i in 0..n {
        for &column in rows.row(i) {
            let mut k = column;
            while k < i as u32 {
                let next = ancestor[k as usize];
                ancestor[k as usize] = i as u32;
                if next == NONE {
                    parent[k as usize] = i as u32;
                    break;
                }
                k = next;
            }
        }
    }
    parent
}

/// Returns the postorder position of each column: subtrees are contiguous, children come before
/// parents. The factor keeps its entries, and chains of columns become supernodes.
pub(crate) fn postorder(parent: &[u32]) -> Vec<u32> {
    let n = parent.len();
    let mut first_child = vec![NONE; n];
    let mut next_sibling = vec![NONE; n];
    let mut stack = Vec::new();
    for j in (0..n).rev() {
        match parent[j] {
            NONE => stack.push(j as u32),
            p => {
                next_sibling[j] = first_child[p as usize];
                first_child[p as usize] = j as u32;
            }
        }
    }
    let mut position = vec![0; n];
    let mut next = 0;
    while let Some(&j) = stack.last() {
        let child = first_child[j as usize];
        if child == NONE {
            position[j as usize] = next;
            next += 1;
            stack.pop();
        } else {
            first_child[j as usize] = next_sibling[child as usize];
            stack.push(child);
        }
    }
    position
}

/// Renumbers the tree.
pub(crate) fn renumbered(parent: &[u32], position: &[u32]) -> Vec<u32> {
    let mut result = vec![NONE; parent.len()];
    for (j, &p) in parent.iter().enumerate() {
        if p != NONE {
            result[position[j] as usize] = position[p as usize];
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Row structure of every column of the factor by definition: column j passes its rows on to
    /// its first row.
    fn rows_of_columns(n: usize, lower: &[Vec<u32>]) -> Vec<Vec<u32>> {
        let mut rows = lower.to_vec();
        for j in 0..n {
            rows[j].sort_unstable();
            rows[j].dedup();
            if let Some((&first, rest)) = rows[j].clone().split_first() {
                rows[first as usize].extend(rest);
            }
        }
        rows
    }

    #[test]
    fn supernodes_contain_all_fill_in() {
        let n = 300;
        let mut state = 7u64;
        let mut random = move |below: usize| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            ((state >> 33) as usize) % below
        };
        let pairs: Vec<(usize, usize)> = (0..n + n / 3)
            .map(|_| {
                let a = random(n);
                (a, (a + 1 + random(20)).min(n - 1))
            })
            .filter(|(a, b)| a != b)
            .collect();
        let rows = CompressedRows::new(n, pairs.iter().map(|&(a, b)| (b as u32, a as u32)));
        let tree = elimination_tree(&rows);
        let position = postorder(&tree);
        let tree = renumbered(&tree, &position);
        let mut lower = vec![Vec::new(); n];
        for &(a, b) in &pairs {
            let (a, b) = (position[a], position[b]);
            lower[a.min(b) as usize].push(a.max(b));
        }
        for (j, rows) in lower.iter_mut().enumerate() {
            rows.push(j as u32);
            rows.sort_unstable();
            rows.dedup();
        }
        let col_ptr: Vec<u32> = (0..=n).map(|i| lower[..i].iter().map(|r| r.len() as u32).sum()).collect();
        let factor = Supernodes::of(&tree, &col_ptr, &lower.concat()).unwrap();

        let strictly: Vec<Vec<u32>> = lower.iter().map(|rows| rows[1..].to_vec()).collect();
        let exact = rows_of_columns(n, &strictly);
        let mut next = 0;
        for s in 0..factor.count() {
            let columns = factor.columns(s);
            assert_eq!(columns.start, next);
            next = columns.end;
            assert!(factor.rows(s).is_sorted() && factor.rows(s).iter().all(|&r| r as usize >= next));
            let height = columns.len() + factor.rows(s).len();
            assert_eq!(factor.panel(s).len(), columns.len() * height);
            for j in columns.clone() {
                assert_eq!(tree[j], exact[j].first().copied().unwrap_or(NONE), "parent of {j}");
                for &row in &exact[j] {
                    let held = columns.contains(&(row as usize)) || factor.rows(s).contains(&row);
                    assert!(held, "row {row} of column {j}");
                }
            }
            // The structure of the last column is exact: amalgamation adds no rows.
            assert_eq!(exact[columns.end - 1], factor.rows(s));
            match factor.rows(s).first() {
                Some(&row) => assert!(factor.columns(factor.parent[s] as usize).contains(&(row as usize))),
                None => assert_eq!(factor.parent[s], NONE),
            }
        }
        assert_eq!(next, n);
        assert!(factor.count() < n / 2, "{} supernodes", factor.count());
    }
}
