//! Union-find.

/// Union-find on the numbers 0, 1, ...; the representative of a set is its smallest member.
///
/// ```
/// use eikona_mesh::UnionFind;
/// let mut sets = UnionFind::new(5);
/// sets.join(4, 1);
/// sets.join(3, 4);
/// assert_eq!((sets.find(3), sets.find(2)), (1, 2));
/// assert_eq!(sets.numbers(), ([0, 1, 2, 1, 1].to_vec(), 3));
/// ```
#[derive(Clone, Debug)]
pub struct UnionFind {
    parent: Vec<u32>,
}

impl UnionFind {
    /// Creates `count` singletons.
    pub fn new(count: usize) -> Self {
        UnionFind { parent: (0..count as u32).collect() }
    }

    /// Returns the smallest member of the set of `x`.
    ///
    /// # Cost
    /// Usually O(1): path halving shortens later searches.
    ///
    /// # Panics
    /// If `x` is not below the count. [`join`](UnionFind::join) panics likewise.
    pub fn find(&mut self, mut x: u32) -> u32 {
        while self.parent[x as usize] != x {
            let up = self.parent[self.parent[x as usize] as usize];
            self.parent[x as usize] = up;
            x = up;
        }
        x
    }

    /// Merges the sets of two numbers.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }

    /// Returns the index of the set of each number, and the number of sets. Sets are indexed in the
    /// order of their smallest members.
    pub fn numbers(&mut self) -> (Vec<u32>, usize) {
        self.number(0..self.parent.len() as u32)
    }

    /// Indexes the sets in the order in which `members` first refers to them. Returns the index for
    /// each member, and the number of sets.
    pub(crate) fn number(&mut self, members: impl Iterator<Item = u32>) -> (Vec<u32>, usize) {
        let mut number_of_set: Vec<Option<u32>> = vec![None; self.parent.len()];
        let mut count = 0;
        let numbers = members
            .map(|x| {
                let set = self.find(x) as usize;
                *number_of_set[set].get_or_insert_with(|| {
                    count += 1;
                    count - 1
                })
            })
            .collect();
        (numbers, count as usize)
    }
}
