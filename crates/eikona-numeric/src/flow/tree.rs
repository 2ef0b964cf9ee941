//! Spanning-tree basis of the network simplex.

use super::network::{NONE, Network};
use crate::error::NumericError;
use crate::observer::check_step;

/// Spanning forest in preorder: one doubly linked ring per component, so that a subtree and its
/// complement are contiguous in the ring and either can be traversed.
pub(super) struct Tree {
    nodes: Vec<Node>,
    /// Root of each node's component. Roots never change.
    root: Vec<u32>,
    /// Path reversed by `reattach`; with each node, the node after its subtree in the ring.
    stem: Vec<(u32, u32)>,
}

#[derive(Clone, Copy)]
struct Node {
    parent: u32,
    /// Twice the parent arc, plus 1 if it leads from the parent to this node.
    link: u32,
    next: u32,
    previous: u32,
    /// Last node of the subtree in preorder.
    last: u32,
    /// Number of nodes in the subtree.
    size: u32,
    /// Stored here because subtree traversals are bound by memory latency.
    potential: f64,
}

impl Tree {
    /// Builds the forest of a network.
    ///
    /// # Errors
    /// [`NumericError::Stopped`].
    pub(super) fn new(network: &Network) -> Result<Tree, NumericError> {
        let n = network.nodes();
        let mut root: Vec<u32> = (0..n as u32).collect();
        let mut nodes: Vec<Node> = (0..n as u32)
            .map(|v| Node {
                parent: NONE,
                link: NONE,
                next: v,
                previous: v,
                last: v,
                size: 1,
                potential: 0.0,
            })
            .collect();
        // Parents have smaller indices than their children.
        for v in 0..n {
            check_step(v)?;
            let a = network.forest[v];
            if a != NONE {
                let parent = network.across(a, v as u32);
                nodes[v].parent = parent;
                nodes[v].link = 2 * a + u32::from(network.arcs[a as usize].from == parent);
                root[v] = root[parent as usize];
            }
        }
        let mut tree = Tree { nodes, root, stem: Vec::new() };
        // Insert each finished subtree right after its parent, before subtrees inserted earlier.
        for v in (0..n as u32).rev() {
            check_step(v as usize)?;
            let Node { parent, size, last, .. } = tree.nodes[v as usize];
            if parent != NONE {
                let after = tree.nodes[parent as usize].next;
                tree.join(parent, v);
                tree.join(last, after);
                if tree.nodes[parent as usize].size == 1 {
                    tree.nodes[parent as usize].last = last;
                }
                tree.nodes[parent as usize].size += size;
            }
        }
        Ok(tree)
    }

    #[inline]
    pub(super) fn parent(&self, v: u32) -> u32 {
        self.nodes[v as usize].parent
    }
    /// Returns the arc to the parent, and whether it leads from the parent down to `v`.
    #[inline]
    pub(super) fn link(&self, v: u32) -> (usize, bool) {
        let link = self.nodes[v as usize].link;
        ((link >> 1) as usize, link & 1 == 1)
    }
    #[inline]
    pub(super) fn size(&self, v: u32) -> u32 {
        self.nodes[v as usize].size
    }
    #[inline]
    pub(super) fn root(&self, v: u32) -> u32 {
        self.root[v as usize]
    }
    #[inline]
    pub(super) fn potential(&self, v: u32) -> f64 {
        self.nodes[v as usize].potential
    }
    #[inline]
    pub(super) fn set_potential(&mut self, v: u32, potential: f64) {
        self.nodes[v as usize].potential = potential;
    }
    #[inline]
    fn join(&mut self, a: u32, b: u32) {
        self.nodes[a as usize].next = b;
        self.nodes[b as usize].previous = a;
    }

    /// Returns the lowest common ancestor of two nodes.
    pub(super) fn apex(&self, mut u: u32, mut v: u32) -> u32 {
        // A node with the smaller subtree is no ancestor of the other.
        while u != v {
            if self.size(u) < self.size(v) {
                u = self.parent(u);
            } else {
                v = self.parent(v);
            }
        }
        u
    }

    /// Iterates over the component of `root` in preorder.
    pub(super) fn component(&self, root: u32) -> impl Iterator<Item = u32> {
        let mut at = root;
        (0..self.size(root)).map(move |_| {
            let here = at;
            at = self.nodes[here as usize].next;
            here
        })
    }

    /// Adds to the potentials of the subtree of `top`, or subtracts from the rest of its component
    /// if that is smaller, which has the same effect on differences. Returns the number of nodes
    /// visited.
    pub(super) fn shift_potentials(&mut self, top: u32, change: f64) -> u32 {
        let node = self.nodes[top as usize];
        let others = self.size(self.root(top)) - node.size;
        let (mut at, count, change) = match node.size <= others {
            true => (top, node.size, change),
            false => (self.nodes[node.last as usize].next, others, -change),
        };
        for _ in 0..count {
            let node = &mut self.nodes[at as usize];
            node.potential += change;
            at = node.next;
        }
        count
    }

    /// Detaches the subtree of `top`, makes its node `inner` the root, and attaches it below
    /// `outer` by an arc; `down` says that the arc leads from `outer` to `inner`. `apex` is a
    /// common ancestor of `top` and `outer`.
    pub(super) fn reattach(&mut self, top: u32, inner: u32, outer: u32, apex: u32, arc: u32, down: bool) {
        let Node { size: total, last: top_last, previous: before, parent: old_parent, .. } =
            self.nodes[top as usize];
        // Remove the subtree from the ring and from the counts of its ancestors.
        let after = self.nodes[top_last as usize].next;
        self.join(before, after);
        let mut v = old_parent;
        while v != NONE && self.nodes[v as usize].last == top_last {
            self.nodes[v as usize].last = before;
            v = self.parent(v);
        }
        let mut v = old_parent;
        while v != apex {
            self.nodes[v as usize].size -= total;
            v = self.parent(v);
        }
        // Reverse the stem from `inner` to `top`: in preorder, the subtree of each stem node,
        // without that of its predecessor on the stem, follows its predecessor's.
        let mut stem = std::mem::take(&mut self.stem);
        stem.clear();
        let mut v = inner;
        loop {
            let last = self.nodes[v as usize].last;
            stem.push((v, self.nodes[last as usize].next));
            if v == top {
                break;
            }
            v = self.parent(v);
        }
        let successor = self.nodes[outer as usize].next;
        let mut tail = outer;
        let mut block_end = self.nodes[inner as usize].last;
        for (i, &(v, behind)) in stem.iter().enumerate() {
            let Node { previous: ahead, last, .. } = self.nodes[v as usize];
            self.join(tail, v);
            tail = block_end;
            if let Some(&(up, _)) = stem.get(i + 1) {
                let up_last = self.nodes[up as usize].last;
                block_end = if last == up_last { ahead } else { up_last };
                if last != up_last {
                    self.join(ahead, behind);
                }
            }
        }
        self.join(tail, successor);
        // Update parents, links and sizes along the stem, from `top` down, since each node takes
        // the former link of its predecessor.
        for i in (1..stem.len()).rev() {
            let child = self.nodes[stem[i - 1].0 as usize];
            let node = &mut self.nodes[stem[i].0 as usize];
            node.parent = stem[i - 1].0;
            node.link = child.link ^ 1;
            node.size = total - child.size;
            node.last = tail;
        }
        let node = &mut self.nodes[inner as usize];
        node.parent = outer;
        node.link = 2 * arc + u32::from(down);
        node.size = total;
        node.last = tail;
        self.stem = stem;
        let mut v = outer;
        while v != NONE && self.nodes[v as usize].last == outer {
            self.nodes[v as usize].last = tail;
            v = self.parent(v);
        }
        let mut v = outer;
        while v != apex {
            self.nodes[v as usize].size += total;
            v = self.parent(v);
        }
    }
}
