//! The block cluster tree: all pairs of faces, divided into near blocks of two leaves and far
//! blocks of two clusters.

use crate::geometry::vector::distance;
use crate::repulsive::moments::Moments;
use crate::spatial::ClusterTree;
use eikona_numeric::{CompressedRows, NumericError, check_step, check_stopped};

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
    ) -> Result<Partition, NumericError> {
        let nodes = tree.nodes();
        let leaves: Vec<u32> = (0..nodes.len()).filter(|&n| nodes[n].is_leaf()).map(|n| n as u32).collect();
        let mut number = vec![0u32; nodes.len()];
        leaves.iter().zip(0..).for_each(|(&node, i)| number[node as usize] = i);
        let (mut near, mut far) = (Vec::new(), Vec::new());
        let mut stack = vec![(0u32, 0u32)];
        let mut step = 0;
        while let Some((a, b)) = stack.pop() {
            check_step(step)?;
            step += 1;
            let [i, j] = [a, b].map(|node| node as usize);
            let between = distance(moments[i].centre, moments[j].centre);
            if radii[i] + radii[j] < separation * between {
                far.push((a, b));
                continue;
            }
            let split_first = |children: [usize; 2]| children.map(|child| (child as u32, b));
            let split_second = |children: [usize; 2]| children.map(|child| (a, child as u32));
            match (tree.children(i), tree.children(j)) {
                (None, None) => near.push((number[i], number[j])),
                (Some([first, second]), Some(_)) if a == b => {
                    let [first, second] = [first as u32, second as u32];
                    stack.extend([(second, second), (first, second), (first, first)]);
                }
                (Some(children), None) => stack.extend(split_first(children)),
                (None, Some(children)) => stack.extend(split_second(children)),
                // The larger cluster is split.
                (Some(first), Some(_)) if radii[i] >= radii[j] => stack.extend(split_first(first)),
                (Some(_), Some(second)) => stack.extend(split_second(second)),
            }
        }
        check_stopped()?;
        let both = |pairs: Vec<(u32, u32)>, rows: usize| {
            let forward = pairs.iter().copied();
            let backward = pairs.iter().filter(|(a, b)| a != b).map(|&(a, b)| (b, a));
            CompressedRows::unless_stopped(rows, forward.chain(backward))
        };
        Ok(Partition { near: both(near, leaves.len())?, far: both(far, nodes.len())?, leaves })
    }
}
