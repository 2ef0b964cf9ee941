//! The elimination tree of the supernodes.

use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;

const NONE: u32 = u32::MAX;

/// Who waits for whom, and how much memory that takes.
///
/// The updates of the numeric phase wait for their parents on two stacks, one for supernodes at even and one for those at odd
/// depth: the children of a front lie on top of one while its own update is made on top of the other.
#[derive(Debug)]
pub(crate) struct Tree {
    parent: Vec<u32>,
    odd: Vec<bool>,
    /// Largest number of entries on each stack.
    stack_entries: [usize; 2],
}

impl Tree {
    pub(crate) fn of(shape: &SymbolicSupernodalCholesky<u32>) -> Tree {
        let count = shape.n_supernodes();
        let (row_ptr, end) = (shape.col_ptr_for_row_idx(), shape.supernode_end());
        let mut owner = vec![0u32; end.last().map_or(0, |&n| n as usize)];
        for s in 0..count {
            owner[shape.supernode_begin()[s] as usize..end[s] as usize].fill(s as u32);
        }
        // The first row below its columns is a column of the parent.
        let parent: Vec<u32> = (0..count)
            .map(|s| match shape.nnz_per_super()[s] {
                0 => NONE,
                _ => owner[shape.row_idx()[row_ptr[s] as usize] as usize],
            })
            .collect();
        let mut odd = vec![false; count];
        for s in (0..count).rev().filter(|&s| parent[s] != NONE) {
            odd[s] = !odd[parent[s] as usize];
        }
        let mut waiting: [Vec<(u32, usize)>; 2] = [Vec::new(), Vec::new()];
        let mut stack_entries = [0; 2];
        for s in 0..count {
            let own = usize::from(odd[s]);
            if parent[s] != NONE {
                let size = shape.nnz_per_super()[s] as usize;
                let top = waiting[own].last().map_or(0, |top| top.1) + size * size;
                waiting[own].push((parent[s], top));
                stack_entries[own] = stack_entries[own].max(top);
            }
            while waiting[1 - own].pop_if(|(parent, _)| *parent == s as u32).is_some() {}
        }
        Tree { parent, odd, stack_entries }
    }

    /// Whether the update of a supernode waits on the second stack.
    pub(crate) fn is_odd(&self, supernode: usize) -> bool {
        self.odd[supernode]
    }

    /// Largest number of entries on each stack.
    pub(crate) fn stack_entries(&self) -> [usize; 2] {
        self.stack_entries
    }

    /// Adds all ancestors of the marked supernodes.
    pub(crate) fn mark_ancestors(&self, marked: &mut [bool]) {
        for s in 0..marked.len() {
            if marked[s] && self.parent[s] != NONE {
                marked[self.parent[s] as usize] = true;
            }
        }
    }
}
