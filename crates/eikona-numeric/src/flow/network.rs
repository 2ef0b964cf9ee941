//! Network on which both methods work: relevant terms only, nodes in preorder of a spanning forest.

use super::JumpTerm;
use crate::CompressedRows;
use crate::error::NumericError;
use crate::observer::{check_step, check_stopped};

/// Marks the absence of a node or an arc.
pub(super) const NONE: u32 = u32::MAX;

/// Term between two different nodes. Its flow from `from` to `to` is the dual variable of its jump.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arc {
    pub(super) from: u32,
    pub(super) to: u32,
    pub(super) shift: f64,
    pub(super) weight: f64,
    /// Upper limit of the jump. Infinite for a free term, whose jump has no lower limit either.
    pub(super) limit: f64,
}

impl Arc {
    #[inline]
    pub(super) fn is_boxed(&self) -> bool {
        self.limit < f64::INFINITY
    }
    #[inline]
    pub(super) fn jump(&self, potentials: &[f64]) -> f64 {
        self.shift + potentials[self.from as usize] - potentials[self.to as usize]
    }
    /// Returns the other end.
    #[inline]
    pub(super) fn across(&self, node: u32) -> u32 {
        if self.from == node { self.to } else { self.from }
    }
}

/// Relevant terms, with a spanning forest. Nodes are numbered in preorder of the forest, so that
/// parents precede their children and subtrees are contiguous in memory, for any numbering of the
/// input.
pub(super) struct Network {
    pub(super) arcs: Vec<Arc>,
    /// Term of each arc.
    pub(super) terms: Vec<u32>,
    /// The caller's index of each node.
    pub(super) callers: Vec<u32>,
    /// Arc to the parent in the forest; `NONE` for roots.
    pub(super) forest: Vec<u32>,
    /// Largest |shift| or limit.
    pub(super) scale: f64,
}

impl Network {
    /// Builds the network, with `weights[e]` instead of the weight of term `e`. Terms with neither
    /// weight nor limit, and terms that join a node to itself, have no effect on the potentials and
    /// are left out.
    pub(super) fn new(nodes: usize, terms: &[JumpTerm], weights: &[f64]) -> Result<Network, NumericError> {
        check_stopped()?;
        let mut scale = 0.0f64;
        let mut arcs = Vec::with_capacity(terms.len());
        let mut term_of = Vec::with_capacity(terms.len());
        for (e, term) in terms.iter().enumerate() {
            check_step(e)?;
            scale = scale.max(term.shift.abs()).max(term.limit.unwrap_or(0.0));
            if term.from != term.to && (weights[e] > 0.0 || term.limit.is_some()) {
                arcs.push(Arc {
                    from: term.from,
                    to: term.to,
                    shift: term.shift,
                    weight: weights[e],
                    limit: term.limit.unwrap_or(f64::INFINITY),
                });
                term_of.push(e as u32);
            }
        }
        check_stopped()?;
        let (reached, links) = spanning_forest(nodes, &arcs)?;
        check_stopped()?;
        let (callers, forest) = in_preorder(&arcs, &reached, &links);
        check_stopped()?;
        let mut number = vec![0u32; nodes];
        for (new, old) in callers.iter().enumerate() {
            number[*old as usize] = new as u32;
        }
        for arc in &mut arcs {
            arc.from = number[arc.from as usize];
            arc.to = number[arc.to as usize];
        }
        check_stopped()?;
        // Sort arcs by their first node.
        let firsts = arcs.iter().enumerate().map(|(a, arc)| (arc.from.min(arc.to), a as u32));
        let (_, order) = CompressedRows::new(nodes, firsts).into_parts();
        let sorted = order.iter().map(|&a| arcs[a as usize]).collect();
        let sorted_terms = order.iter().map(|&a| term_of[a as usize]).collect();
        let mut place = vec![0u32; arcs.len()];
        for (k, a) in order.iter().enumerate() {
            place[*a as usize] = k as u32;
        }
        let forest = forest.iter().map(|&a| if a == NONE { NONE } else { place[a as usize] }).collect();
        Ok(Network { arcs: sorted, terms: sorted_terms, callers, forest, scale })
    }

    pub(super) fn nodes(&self) -> usize {
        self.callers.len()
    }

    /// Returns the other end of an arc.
    #[inline]
    pub(super) fn across(&self, arc: u32, node: u32) -> u32 {
        self.arcs[arc as usize].across(node)
    }

    /// Returns the potentials without jumps on the forest; 0 at its roots.
    pub(super) fn forest_potentials(&self) -> Vec<f64> {
        let mut potentials = vec![0.0; self.nodes()];
        for v in 0..self.nodes() {
            if self.forest[v] != NONE {
                let arc = &self.arcs[self.forest[v] as usize];
                potentials[v] = match arc.to as usize == v {
                    true => arc.shift + potentials[arc.from as usize],
                    false => potentials[arc.to as usize] - arc.shift,
                };
            }
        }
        potentials
    }

    /// Returns the largest absolute value of the shifts, limits and given potentials.
    pub(super) fn largest_number(&self, potentials: &[f64]) -> f64 {
        potentials.iter().fold(self.scale, |m, p| m.max(p.abs()))
    }

    /// Rounds shifts, limits and the given potentials to multiples of a power of two, so that sums
    /// of up to 8 times the largest number are exact. Limits are rounded up, and extended where the
    /// potentials violate them.
    ///
    /// Each number changes by less than 2^-49 of the largest.
    pub(super) fn round(&mut self, potentials: &mut [f64]) {
        let exponent = self.largest_number(potentials).log2().ceil().max(-960.0) as i32;
        let unit = 2f64.powi(exponent - 50);
        potentials.iter_mut().for_each(|p| *p = (*p / unit).round() * unit);
        for arc in &mut self.arcs {
            arc.shift = (arc.shift / unit).round() * unit;
            arc.limit = (arc.limit / unit).ceil() * unit;
            if arc.is_boxed() {
                let jump = arc.jump(potentials);
                arc.limit = arc.limit.max(jump) - jump.min(0.0);
                arc.shift -= jump.min(0.0);
            }
        }
    }

    /// Sends the imbalance of each node (rounding, for a flow that should be a circulation) along
    /// the forest to its roots.
    pub(super) fn balance(&self, flow: &mut [f64]) {
        let mut surplus = vec![0.0; self.nodes()];
        for (arc, y) in self.arcs.iter().zip(flow.iter()) {
            surplus[arc.from as usize] -= y;
            surplus[arc.to as usize] += y;
        }
        for v in (0..self.nodes()).rev() {
            let a = self.forest[v];
            if a != NONE {
                let sign = if self.arcs[a as usize].from as usize == v { 1.0 } else { -1.0 };
                flow[a as usize] += sign * surplus[v];
                surplus[self.across(a, v as u32) as usize] += surplus[v];
            }
        }
    }
}

/// Returns the arcs incident to each node.
pub(super) fn incidence<'a>(
    nodes: usize,
    arcs: impl Iterator<Item = (u32, &'a Arc)> + Clone,
) -> CompressedRows<u32> {
    CompressedRows::new(nodes, arcs.flat_map(|(a, arc)| [(arc.from, a), (arc.to, a)]))
}

/// Grows a spanning forest. Returns the nodes in the order reached, and the arc over which each was
/// reached.
///
/// The forest grows from the nodes farthest from boxed terms towards these, and crosses boxed terms
/// last. Its branches therefore meet at boxed terms, where jumps are cheap, or along a valley of
/// the distance between two of them, which for a broken curve is straight across the gap. The jumps
/// of the starting potentials lie there.
fn spanning_forest(nodes: usize, arcs: &[Arc]) -> Result<(Vec<u32>, Vec<u32>), NumericError> {
    let incidence = incidence(nodes, arcs.iter().enumerate().map(|(a, arc)| (a as u32, arc)));
    check_stopped()?;
    let distance = distance_to_boxed(nodes, arcs, &incidence);
    check_stopped()?;
    let mut reached = vec![false; nodes];
    let mut order: Vec<u32> = Vec::with_capacity(nodes);
    let mut forest = Vec::with_capacity(nodes);
    // Bucket queue of arcs to unreached nodes, by the distance of these plus 1; boxed arcs in
    // bucket 0.
    let highest = distance.iter().max().map_or(0, |d| *d as usize);
    let mut waiting: Vec<std::collections::VecDeque<(u32, u32)>> = vec![Default::default(); highest + 2];
    let mut roots: Vec<Vec<u32>> = vec![Vec::new(); highest + 1];
    for (v, d) in distance.iter().enumerate() {
        roots[*d as usize].push(v as u32);
    }
    for &root in roots.iter().rev().flatten() {
        check_step(order.len())?;
        if reached[root as usize] {
            continue;
        }
        let mut level = distance[root as usize] as usize + 1;
        waiting[level].push_back((NONE, root));
        loop {
            let Some((a, v)) = waiting[level].pop_front() else {
                if level == 0 {
                    break;
                }
                level -= 1;
                continue;
            };
            if std::mem::replace(&mut reached[v as usize], true) {
                continue;
            }
            check_step(order.len())?;
            order.push(v);
            forest.push(a);
            for &a in incidence.row(v as usize) {
                let arc = &arcs[a as usize];
                let w = arc.across(v);
                if !reached[w as usize] {
                    let key = if arc.is_boxed() { 0 } else { distance[w as usize] as usize + 1 };
                    waiting[key].push_back((a, w));
                    level = level.max(key);
                }
            }
        }
    }
    Ok((order, forest))
}

/// Renumbers the forest in preorder, so that subtrees are contiguous in memory.
fn in_preorder(arcs: &[Arc], order: &[u32], forest: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let n = order.len();
    let mut place = vec![0u32; n];
    for (k, v) in order.iter().enumerate() {
        place[*v as usize] = k as u32;
    }
    let parent = |k: usize| place[arcs[forest[k] as usize].across(order[k]) as usize] as usize;
    let mut size = vec![1u32; n];
    for k in (0..n).rev().filter(|&k| forest[k] != NONE) {
        size[parent(k)] += size[k];
    }
    // Position of the next child of a node, and of the next root.
    let mut free = vec![0u32; n];
    let mut next_root = 0;
    let (mut callers, mut links) = (vec![0u32; n], vec![NONE; n]);
    for k in 0..n {
        let next = if forest[k] == NONE { &mut next_root } else { &mut free[parent(k)] };
        let at = *next;
        *next += size[k];
        free[k] = at + 1;
        callers[at as usize] = order[k];
        links[at as usize] = forest[k];
    }
    (callers, links)
}

/// Number of free terms between each node and the nearest boxed one; 0 if there is none.
fn distance_to_boxed(nodes: usize, arcs: &[Arc], incidence: &CompressedRows<u32>) -> Vec<u32> {
    let mut distance = vec![NONE; nodes];
    let mut queue: Vec<u32> = Vec::new();
    for arc in arcs.iter().filter(|arc| arc.is_boxed()) {
        for v in [arc.from, arc.to] {
            if std::mem::replace(&mut distance[v as usize], 0) != 0 {
                queue.push(v);
            }
        }
    }
    let mut at = 0;
    while let Some(&v) = queue.get(at) {
        at += 1;
        for &a in incidence.row(v as usize) {
            let w = arcs[a as usize].across(v);
            if distance[w as usize] == NONE {
                distance[w as usize] = distance[v as usize] + 1;
                queue.push(w);
            }
        }
    }
    for d in distance.iter_mut().filter(|d| **d == NONE) {
        *d = 0;
    }
    distance
}
