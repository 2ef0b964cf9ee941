//! Geometric nested dissection: a plane bisects the unknowns, a minimum vertex cover of the cut
//! edges separates the halves, and the separator is ordered after both halves, which are dissected
//! recursively.
//!
//! A plane cuts O(sqrt n) unknowns of a surface, so the factor has O(n log n) entries whatever the
//! numbering of the input (minimum degree orderings lose up to 40 % on shuffled input). Each level
//! costs one sweep over the unknowns.
//!
//! Sweeps read positions in single precision. A piece too small relative to its distance from the
//! origin is rescaled to its own bounding box, so that one distant vertex does no harm. A piece
//! without extent, or of long, thin triangles that planes cut badly, is cut along a breadth-first
//! order instead.

use crate::compressed_rows::CompressedRows;
use crate::error::NumericError;
use crate::observer::check_stopped;
use crate::threads::together;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};

/// Largest piece that is not dissected further. Smaller leaves save too little fill-in to be worth
/// their time: the factorisation merges small supernodes anyway.
const LEAF: usize = 4;

/// Unknown with its position, stored together so that sweeps touch memory in order.
#[derive(Clone, Copy)]
struct Node {
    position: [f32; 3],
    /// Largest coordinate difference to a neighbour: an unknown farther than this from the plane
    /// has no neighbour beyond it.
    reach: f32,
    id: u32,
}

/// Pieces with fewer unknowns are dissected on one thread.
const WORTH_A_THREAD: usize = 10_000;

/// Returns the unknowns in elimination order, the same for any number of threads.
///
/// `positions` affect the quality of the order only, never its validity.
///
/// # Errors
/// [`NumericError::Stopped`].
pub(crate) fn nested_dissection(
    adjacency: &CompressedRows<u32>,
    positions: &[[f64; 3]],
    threads: usize,
) -> Result<Vec<u32>, NumericError> {
    let n = positions.len();
    check_stopped()?;
    let shared = Shared::new(adjacency, positions);
    check_stopped()?;
    let mut nodes: Vec<Node> = (0..n as u32).map(|id| Node { position: [0.0; 3], reach: 0.0, id }).collect();
    let mut order = vec![0u32; n];
    Dissection::new(&shared).order(Piece { nodes: &mut nodes, order: &mut order }, threads)?;
    Ok(order)
}

/// A set of unknowns with its range of the elimination order.
struct Piece<'p> {
    nodes: &'p mut [Node],
    order: &'p mut [u32],
}

/// State of all unknowns.
///
/// A piece writes at its own unknowns only, and reads at those and at separators of larger pieces.
/// Pieces on several threads therefore never meet: the atomics are for the compiler, which cannot
/// know this, and cost nothing.
struct Shared<'a> {
    adjacency: &'a CompressedRows<u32>,
    given: &'a [[f64; 3]],
    /// Single-precision position of each unknown, comparable within a piece only.
    positions: Vec<[Single; 3]>,
    /// Whether an unknown is in a separator already. All other neighbours of an unknown are in its
    /// own piece.
    separated: Vec<AtomicBool>,
    /// Index of an unknown in the list under construction: `right`, or a breadth-first order.
    local: Vec<AtomicU32>,
}

/// Single-precision number that threads share.
#[derive(Default)]
struct Single(AtomicU32);

impl Single {
    fn get(&self) -> f32 {
        f32::from_bits(self.0.load(Relaxed))
    }
    fn set(&self, value: f32) {
        self.0.store(value.to_bits(), Relaxed);
    }
}

impl<'a> Shared<'a> {
    fn new(adjacency: &'a CompressedRows<u32>, given: &'a [[f64; 3]]) -> Self {
        let n = given.len();
        Shared {
            adjacency,
            given,
            positions: std::iter::repeat_with(Default::default).take(n).collect(),
            separated: std::iter::repeat_with(Default::default).take(n).collect(),
            local: std::iter::repeat_with(Default::default).take(n).collect(),
        }
    }

    fn position(&self, id: u32) -> [f32; 3] {
        self.positions[id as usize].each_ref().map(Single::get)
    }
    fn place(&self, id: u32, position: [f32; 3]) {
        for (coordinate, value) in self.positions[id as usize].iter().zip(position) {
            coordinate.set(value);
        }
    }
    fn is_separated(&self, id: u32) -> bool {
        self.separated[id as usize].load(Relaxed)
    }
    fn local(&self, id: u32) -> u32 {
        self.local[id as usize].load(Relaxed)
    }
    fn set_local(&self, id: u32, index: usize) {
        self.local[id as usize].store(index as u32, Relaxed);
    }
}

/// Working state of the dissection on one thread.
struct Dissection<'a> {
    shared: &'a Shared<'a>,
    /// Unknowns of the first half that have neighbours in the second half, and those neighbours.
    left: Vec<u32>,
    right: Vec<u32>,
    /// Neighbours of left unknown `l`, as indices into `right`: `cut[cut_start[l]..cut_start[l +
    /// 1]]`.
    cut_start: Vec<u32>,
    cut: Vec<u32>,
    match_left: Vec<u32>,
    match_right: Vec<u32>,
    visited: Vec<bool>,
    /// Minimum vertex cover of the cut: the separator.
    cover: Vec<u32>,
}

const UNMATCHED: u32 = u32::MAX;

impl<'a> Dissection<'a> {
    fn new(shared: &'a Shared<'a>) -> Self {
        Dissection {
            shared,
            left: Vec::new(),
            right: Vec::new(),
            cut_start: Vec::new(),
            cut: Vec::new(),
            match_left: Vec::new(),
            match_right: Vec::new(),
            visited: Vec::new(),
            cover: Vec::new(),
        }
    }

    /// Orders a piece and all its parts, the halves of large pieces at the same time.
    fn order(&mut self, piece: Piece<'_>, threads: usize) -> Result<(), NumericError> {
        let mut stack = vec![piece];
        while let Some(piece) = stack.pop() {
            check_stopped()?;
            let side_by_side = threads > 1 && piece.nodes.len() >= WORTH_A_THREAD;
            let [first, second] = self.split(piece);
            if side_by_side {
                let shared = self.shared;
                let half = |part, threads| move || Dissection::new(shared).order(part, threads);
                together([half(first, threads.div_ceil(2)), half(second, threads / 2)])
                    .into_iter()
                    .collect::<Result<(), NumericError>>()?;
            } else {
                stack.extend([first, second].into_iter().filter(|half| !half.nodes.is_empty()));
            }
        }
        Ok(())
    }

    /// Splits a piece into its halves, and orders its separator after both.
    fn split<'p>(&mut self, Piece { nodes, order }: Piece<'p>) -> [Piece<'p>; 2] {
        let halves = if nodes.len() > LEAF { self.dissect(nodes) } else { None };
        // The nodes are now first half, second half, separator. A piece that cannot be cut is all
        // separator.
        let (first, second) = halves.unwrap_or((0, 0));
        let (first_nodes, rest) = nodes.split_at_mut(first);
        let (second_nodes, separator) = rest.split_at_mut(second);
        let (first_order, rest) = order.split_at_mut(first);
        let (second_order, of_separator) = rest.split_at_mut(second);
        for (slot, node) in of_separator.iter_mut().zip(separator) {
            *slot = node.id;
        }
        [Piece { nodes: first_nodes, order: first_order }, Piece { nodes: second_nodes, order: second_order }]
    }

    /// Reorders a piece into first half, second half, separator. Returns the sizes of the halves,
    /// or `None` if the piece cannot be cut.
    fn dissect(&mut self, piece: &mut [Node]) -> Option<(usize, usize)> {
        let mut bounds = Bounds::of(piece);
        if bounds.lacks_precision() {
            self.rescale(piece);
            bounds = Bounds::of(piece);
        }
        let [longest, others @ ..] = bounds.planes(piece.len());
        let mut chosen = longest?;
        let mut middle = self.cut(piece, chosen)?;
        if self.cover.len() > too_many(piece.len()) {
            // With long, thin triangles, the plane across the longest side of the box may cut many
            // edges. Try all planes, then a breadth-first order.
            let mut fewest = self.cover.len();
            for plane in others.into_iter().flatten() {
                if self.cut(piece, plane).is_some_and(|middle| is_balanced(middle, piece.len()))
                    && self.cover.len() < fewest
                {
                    (fewest, chosen) = (self.cover.len(), plane);
                }
            }
            if fewest > too_many(piece.len()) {
                self.use_search_order(piece);
                let halves = (0, 0.5 * piece.len() as f32);
                if self.cut(piece, halves).is_some() && self.cover.len() < fewest {
                    chosen = halves;
                } else {
                    // `rescale` replaces the coordinates, so the plane must be recomputed.
                    self.rescale(piece);
                    let planes = Bounds::of(piece).planes(piece.len());
                    chosen = planes.into_iter().flatten().find(|plane| plane.0 == chosen.0)?;
                }
            }
            middle = self.cut(piece, chosen)?;
        }
        self.cover.iter().for_each(|&id| self.shared.separated[id as usize].store(true, Relaxed));
        let (axis, plane) = chosen;
        // Separators lie near the plane; skip the look-up for all others.
        let shared = self.shared;
        let stays =
            |node: &Node| (node.position[axis] - plane).abs() > node.reach || !shared.is_separated(node.id);
        let first = partition(&mut piece[..middle], stays);
        let second = partition(&mut piece[middle..], stays);
        // first, separators, second, separators -> first, second, separators
        let gap = middle - first;
        if gap >= second {
            piece[first..middle + second].rotate_left(gap);
        } else {
            // Only the first `gap` nodes of the second half need to move.
            for i in 0..gap {
                piece.swap(first + i, middle + second - gap + i);
            }
        }
        Some((first, second))
    }

    /// Moves nodes below a plane to the front and computes the separator. Returns their number, or
    /// `None` if one side is empty.
    fn cut(&mut self, piece: &mut [Node], (axis, plane): (usize, f32)) -> Option<usize> {
        let middle = partition(piece, |node| node.position[axis] < plane);
        if middle == 0 || middle == piece.len() {
            return None;
        }
        self.collect_cut(&piece[..middle], axis, plane);
        self.cover_cut();
        Some(middle)
    }

    /// Rescales positions to the piece's own bounding box, or uses a breadth-first order if the box
    /// has no extent.
    fn rescale(&mut self, piece: &mut [Node]) {
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        for node in piece.iter() {
            let p = self.shared.given[node.id as usize];
            for k in 0..3 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        let size = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
        if !(size > 0.0 && size.is_finite()) {
            return self.use_search_order(piece);
        }
        for node in piece.iter() {
            let p = self.shared.given[node.id as usize];
            self.shared.place(node.id, [0, 1, 2].map(|k| ((p[k] - low[k]) / size) as f32));
        }
        self.refresh(piece);
    }

    /// Replaces positions by indices in a breadth-first order. It starts at the last node of a
    /// first search, so that its levels are narrow.
    fn use_search_order(&mut self, piece: &mut [Node]) {
        let order = self.breadth_first(piece.iter().map(|node| node.id));
        let order = self.breadth_first(order.into_iter().rev());
        for (number, id) in order.into_iter().enumerate() {
            // The huge second coordinate makes `lacks_precision` true for the halves, so they are
            // rescaled. Cut along this order again, they would become long strips.
            self.shared.place(id, [number as f32, f32::MAX, 0.0]);
        }
        self.refresh(piece);
    }

    fn refresh(&self, piece: &mut [Node]) {
        let shared = self.shared;
        for node in piece {
            node.position = shared.position(node.id);
            node.reach = 0.0;
            let neighbours = shared.adjacency.row(node.id as usize).iter();
            for &j in neighbours.filter(|j| !shared.is_separated(**j)) {
                for (a, b) in node.position.iter().zip(shared.position(j)) {
                    node.reach = node.reach.max((b - a).abs());
                }
            }
        }
    }

    /// Returns the unknowns of a piece in breadth-first order from the first of them.
    fn breadth_first(&mut self, piece: impl Iterator<Item = u32>) -> Vec<u32> {
        let mut order: Vec<u32> = Vec::new();
        for start in piece {
            let mut next = order.len();
            self.visit(start, &mut order);
            while let Some(&id) = order.get(next) {
                next += 1;
                for &j in self.shared.adjacency.row(id as usize) {
                    self.visit(j, &mut order);
                }
            }
        }
        order
    }

    fn visit(&mut self, id: u32, order: &mut Vec<u32>) {
        let visited = order.get(self.shared.local(id) as usize) == Some(&id);
        if !visited && !self.shared.is_separated(id) {
            self.shared.set_local(id, order.len());
            order.push(id);
        }
    }

    /// Collects the edges across the plane as a bipartite graph between `left` and `right`.
    fn collect_cut(&mut self, first_half: &[Node], axis: usize, plane: f32) {
        let shared = self.shared;
        self.left.clear();
        self.right.clear();
        self.cut.clear();
        self.cut_start.clear();
        self.cut_start.push(0);
        for node in first_half {
            if plane - node.position[axis] > node.reach {
                continue;
            }
            let before = self.cut.len();
            for &j in shared.adjacency.row(node.id as usize) {
                if shared.positions[j as usize][axis].get() >= plane && !shared.is_separated(j) {
                    // `local` is valid if it points back to j.
                    let known = self.right.get(shared.local(j) as usize) == Some(&j);
                    if !known {
                        shared.set_local(j, self.right.len());
                        self.right.push(j);
                    }
                    self.cut.push(shared.local(j));
                }
            }
            if self.cut.len() > before {
                self.left.push(node.id);
                self.cut_start.push(self.cut.len() as u32);
            }
        }
    }

    /// Computes a minimum vertex cover of the cut edges, by König's theorem from a maximum matching
    /// (greedy, then augmented by depth-first search).
    fn cover_cut(&mut self) {
        let (nl, nr) = (self.left.len(), self.right.len());
        self.match_left.clear();
        self.match_left.resize(nl, UNMATCHED);
        self.match_right.clear();
        self.match_right.resize(nr, UNMATCHED);
        for l in 0..nl {
            for &r in &self.cut[self.cut_start[l] as usize..self.cut_start[l + 1] as usize] {
                if self.match_right[r as usize] == UNMATCHED {
                    self.match_right[r as usize] = l as u32;
                    self.match_left[l] = r;
                    break;
                }
            }
        }
        self.visited.clear();
        self.visited.resize(nr, false);
        let mut path: Vec<(u32, u32)> = Vec::new(); // (left unknown, next cut entry to try)
        for l in 0..nl {
            if self.match_left[l] == UNMATCHED && self.augment(l as u32, &mut path) {
                self.visited.fill(false);
            }
        }
        // König: follow alternating paths from unmatched left unknowns; cover = left not reached +
        // right reached.
        self.visited.fill(false);
        let mut left_reached = vec![false; nl];
        let mut queue: Vec<u32> =
            (0..nl as u32).filter(|&l| self.match_left[l as usize] == UNMATCHED).collect();
        for &l in &queue {
            left_reached[l as usize] = true;
        }
        while let Some(l) = queue.pop() {
            for &r in &self.cut[self.cut_start[l as usize] as usize..self.cut_start[l as usize + 1] as usize]
            {
                if !self.visited[r as usize] {
                    self.visited[r as usize] = true;
                    let next = self.match_right[r as usize];
                    if next != UNMATCHED && !left_reached[next as usize] {
                        left_reached[next as usize] = true;
                        queue.push(next);
                    }
                }
            }
        }
        let on_left = self.left.iter().zip(left_reached).filter(|(_, reached)| !reached);
        let on_right = self.right.iter().zip(&self.visited).filter(|(_, visited)| **visited);
        self.cover.clear();
        self.cover.extend(on_left.map(|(&id, _)| id).chain(on_right.map(|(&id, _)| id)));
    }

    /// Searches for an augmenting path from an unmatched left unknown. `visited` is kept on
    /// failure: nodes that led nowhere once still lead nowhere.
    fn augment(&mut self, from: u32, path: &mut Vec<(u32, u32)>) -> bool {
        path.clear();
        path.push((from, self.cut_start[from as usize]));
        while let Some(&mut (l, ref mut next)) = path.last_mut() {
            if *next == self.cut_start[l as usize + 1] {
                path.pop();
                continue;
            }
            let r = self.cut[*next as usize];
            *next += 1;
            if self.visited[r as usize] {
                continue;
            }
            self.visited[r as usize] = true;
            let owner = self.match_right[r as usize];
            if owner == UNMATCHED {
                for &(l, next) in path.iter().rev() {
                    let r = self.cut[next as usize - 1];
                    self.match_left[l as usize] = r;
                    self.match_right[r as usize] = l;
                }
                return true;
            }
            path.push((owner, self.cut_start[owner as usize]));
        }
        false
    }
}

/// Bounding box of a piece, and the sum of its positions.
struct Bounds {
    low: [f32; 3],
    high: [f32; 3],
    sum: [f64; 3],
}

impl Bounds {
    fn of(piece: &[Node]) -> Bounds {
        let mut bounds = Bounds { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3], sum: [0.0; 3] };
        for node in piece {
            for k in 0..3 {
                bounds.low[k] = bounds.low[k].min(node.position[k]);
                bounds.high[k] = bounds.high[k].max(node.position[k]);
                bounds.sum[k] += f64::from(node.position[k]);
            }
        }
        bounds
    }

    /// Whether fewer than 14 of the 24 bits of a position resolve it within the box; also true of a
    /// box without extent.
    fn lacks_precision(&self) -> bool {
        let size = (0..3).map(|k| self.high[k] - self.low[k]).fold(0.0, f32::max);
        // Positions are never negative.
        let far = self.high.into_iter().fold(0.0, f32::max);
        size <= far / 1024.0
    }

    /// Returns the planes through the mean, normal to the axes along which the box has an extent,
    /// longest axis first.
    fn planes(&self, count: usize) -> [Option<(usize, f32)>; 3] {
        let size = |axis: usize| self.high[axis] - self.low[axis];
        let mut axes = [0, 1, 2];
        axes.sort_by(|&a, &b| size(b).total_cmp(&size(a)));
        axes.map(|axis| {
            // Above the minimum, so that neither side is empty.
            let mean = (self.sum[axis] / count as f64) as f32;
            let plane = if mean > self.low[axis] { mean } else { self.high[axis] };
            (size(axis) > 0.0).then_some((axis, plane))
        })
    }
}

/// Number of cut unknowns above which a plane counts as bad. A plane meets less than twice the root
/// of their number on a sphere whose triangles are about as wide as long.
fn too_many(unknowns: usize) -> usize {
    2 * (unknowns.isqrt() + 1)
}

/// Whether the smaller half has at least an eighth of the unknowns.
fn is_balanced(half: usize, whole: usize) -> bool {
    half.min(whole - half) >= whole / 8
}

/// Moves the nodes that satisfy a condition to the front; returns their number.
fn partition(piece: &mut [Node], condition: impl Fn(&Node) -> bool) -> usize {
    let mut kept = 0;
    for i in 0..piece.len() {
        let node = piece[i];
        let keep = condition(&node);
        piece[i] = piece[kept];
        piece[kept] = node;
        kept += usize::from(keep);
    }
    kept
}
