//! Union-find.

/// Disjoint sets of the numbers 0, 1, ..., each known by its smallest number.
///
/// ```
/// use eikona_mesh::DisjointSets;
/// let mut sets = DisjointSets::new(5);
/// sets.join(4, 1);
/// sets.join(3, 4);
/// assert_eq!((sets.find(3), sets.find(2)), (1, 2));
/// assert_eq!(sets.numbers(), ([0, 1, 2, 1, 1].to_vec(), 3));
/// ```
#[derive(Clone, Debug)]
pub struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    /// So many sets of one number each.
    pub fn new(count: usize) -> Self {
        DisjointSets { parent: (0..count as u32).collect() }
    }

    /// The smallest number in the set of `x`.
    ///
    /// # Cost
    /// O(1) as a rule: the path is halved on the way, so that later searches are short.
    ///
    /// # Panics
    /// If there is no such number; so does [`join`](DisjointSets::join).
    pub fn find(&mut self, mut x: u32) -> u32 {
        while self.parent[x as usize] != x {
            let up = self.parent[self.parent[x as usize] as usize];
            self.parent[x as usize] = up;
            x = up;
        }
        x
    }

    /// Makes the sets of two numbers one.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }

    /// For every number the number of its set, and how many sets there are, counted in the order of
    /// their smallest numbers.
    pub fn numbers(&mut self) -> (Vec<u32>, usize) {
        self.number(0..self.parent.len() as u32)
    }

    /// Numbers the sets in the order in which `members` first names them: the number of each
    /// member, and how many there are.
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
