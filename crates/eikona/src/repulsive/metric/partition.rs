//! The block cluster tree: all pairs of faces, divided into near blocks of two leaves and far
//! blocks of two clusters.

use crate::geometry::vector::distance;
use crate::repulsive::moments::Moments;
use crate::spatial::ClusterTree;
use eikona_numeric::{CompressedRows, NumericError, check_step, for_chunks, side_by_side};

/// Blocks into which the pairs are divided before threads share them.
const BLOCKS: usize = 256;

/// The leaves of the block cluster tree, in both directions.
pub(super) struct Partition {
    /// The near leaves of each leaf, itself among them, by number of leaf.
    pub near: CompressedRows<u32>,
    /// The far clusters of each cluster, by node.
    pub far: CompressedRows<u32>,
    /// The node of each leaf.
    pub leaves: Vec<u32>,
}

impl Partition {
    /// Divides the pairs. Two clusters are far from each other if the sum of their radii is less
    /// than `separation` times the distance of their centres.
    pub fn new(
        tree: &ClusterTree,
        moments: &[Moments],
        radii: &[f64],
        separation: f64,
        threads: usize,
    ) -> Result<Partition, NumericError> {
        let leaves: Vec<u32> = tree.leaves().map(|n| n as u32).collect();
        let search = Search { tree, moments, radii, separation };
        let mut blocks = search.blocks();
        for_chunks(threads, &mut blocks, 1, |_, block| block[0].divide(&search))?;
        let (near, far): (Vec<_>, Vec<_>) = blocks.into_iter().map(|block| (block.near, block.far)).unzip();
        let mut number = vec![0u32; tree.nodes().len()];
        leaves.iter().zip(0..).for_each(|(&node, i)| number[node as usize] = i);
        let (near, far) = side_by_side(
            threads,
            || both(&near, leaves.len(), |node| number[node as usize]),
            || both(&far, tree.nodes().len(), |node| node),
        );
        Ok(Partition { near: near?, far: far?, leaves })
    }
}

type Pair = (u32, u32);

/// Groups pairs of numbered nodes by both of their nodes.
fn both(
    blocks: &[Vec<Pair>],
    rows: usize,
    number: impl Fn(u32) -> u32 + Copy,
) -> Result<CompressedRows<u32>, NumericError> {
    let pairs = || blocks.iter().flatten().map(move |&(a, b)| (number(a), number(b)));
    let backward = pairs().filter(|(a, b)| a != b).map(|(a, b)| (b, a));
    CompressedRows::unless_stopped(rows, pairs().chain(backward))
}

/// What decides which pairs of clusters are far.
struct Search<'a> {
    tree: &'a ClusterTree,
    moments: &'a [Moments],
    radii: &'a [f64],
    separation: f64,
}

/// The pairs that come from one pair of clusters.
#[derive(Default)]
struct Block {
    /// Pairs that have not been decided yet, the first one last.
    stack: Vec<Pair>,
    /// Pairs of leaves, by node.
    near: Vec<Pair>,
    far: Vec<Pair>,
}

impl Block {
    /// Decides the first pair, or replaces it by pairs of parts.
    fn step(&mut self, search: &Search) -> bool {
        let Some((a, b)) = self.stack.pop() else { return false };
        let Search { tree, moments, radii, separation } = search;
        let [i, j] = [a, b].map(|node| node as usize);
        if radii[i] + radii[j] < separation * distance(moments[i].centre, moments[j].centre) {
            self.far.push((a, b));
            return true;
        }
        let split_first = |children: [usize; 2]| children.map(|child| (child as u32, b));
        let split_second = |children: [usize; 2]| children.map(|child| (a, child as u32));
        match (tree.children(i), tree.children(j)) {
            (None, None) => self.near.push((a, b)),
            (Some([first, second]), Some(_)) if a == b => {
                let [first, second] = [first as u32, second as u32];
                self.stack.extend([(second, second), (first, second), (first, first)]);
            }
            (Some(children), None) => self.stack.extend(split_first(children)),
            (None, Some(children)) => self.stack.extend(split_second(children)),
            // The larger cluster is split.
            (Some(first), Some(_)) if radii[i] >= radii[j] => self.stack.extend(split_first(first)),
            (Some(_), Some(second)) => self.stack.extend(split_second(second)),
        }
        true
    }

    /// Decides all pairs.
    fn divide(&mut self, search: &Search) -> Result<(), NumericError> {
        let mut step = 0;
        while self.step(search) {
            check_step(step)?;
            step += 1;
        }
        Ok(())
    }
}

impl Search<'_> {
    /// Divides the pairs into blocks. Those of all blocks, one after the other, are in the same
    /// order as those of a single one.
    fn blocks(&self) -> Vec<Block> {
        let mut blocks = vec![Block { stack: vec![(0, 0)], ..Block::default() }];
        while blocks.len() < BLOCKS && blocks.iter().any(|block| !block.stack.is_empty()) {
            blocks.iter_mut().for_each(|block| _ = block.step(self));
            let apart = |block: Block| {
                let alone = |pair| Block { stack: vec![pair], ..Block::default() };
                let decided = Block { stack: Vec::new(), ..block };
                [decided].into_iter().chain(block.stack.into_iter().rev().map(alone))
            };
            blocks = blocks.into_iter().flat_map(apart).collect();
        }
        blocks
    }
}
