//! Network simplex method with bounded flow and without artificial arcs.
//!
//! The initial basis is the spanning forest with zero flow: its arcs have no jump and residual
//! capacity in both directions, so the first pivots are not degenerate. Nonbasic arcs start at flow
//! 0 between their bounds ("superbasic"); only arcs with a jump may enter. The jump of an arc is
//! minus its reduced cost. The leaving arc is the last blocking arc along the cycle from the apex
//! (Cunningham 1976), so the basis stays strongly feasible and never repeats.

use super::error::{InfeasibleCycle, JumpError};
use super::network::{NONE, Network};
use super::tree::Tree;
use super::{State, Statistics};
use crate::error::NumericError;
use crate::observer::check_stopped;

/// Arc data for pricing and cycle traversal, in one cache line.
#[derive(Clone, Copy)]
struct SimplexArc {
    from: u32,
    to: u32,
    shift: f64,
    lower: f64,
    upper: f64,
    flow: f64,
}

struct Simplex<'a> {
    network: &'a Network,
    arcs: Vec<SimplexArc>,
    tree: Tree,
    tolerance: f64,
    /// Candidate list for pricing: arcs that violated optimality when last checked.
    candidates: Vec<u32>,
    /// Number of candidates after the last sweep.
    collected: usize,
    /// Arc at which the next sweep starts.
    cursor: usize,
}

/// Number of candidates that a sweep collects.
const CANDIDATES: usize = 400;

/// Solves by the network simplex method. Returns `None` if `work_limit` steps do not suffice.
///
/// A boxed term is two parallel arcs: one for flow up to its weight, at cost `-shift`, and one for
/// flow above it, at cost `limit - shift`.
pub(super) fn solve(
    network: &Network,
    tolerance: f64,
    work_limit: u64,
    statistics: &mut Statistics,
) -> Result<Option<State>, JumpError> {
    check_stopped()?;
    let mut simplex = Simplex::new(network, tolerance)?;
    check_stopped()?;
    simplex.integrate();
    check_stopped()?;
    let mut work = 0u64;
    loop {
        let finished = simplex.run(work_limit, &mut work, statistics)?;
        statistics.work += std::mem::take(&mut work);
        if !finished || statistics.work > work_limit {
            return Ok(None);
        }
        // Remove the rounding accumulated in the potentials, which could hide a violation.
        simplex.integrate();
        check_stopped()?;
        if simplex.violations() == 0 {
            break;
        }
    }
    simplex.rebalance();
    let terms = network.arcs.len();
    let mut flow: Vec<f64> = simplex.arcs[..terms].iter().map(|arc| arc.flow).collect();
    let boxed = network.arcs.iter().enumerate().filter(|(_, arc)| arc.is_boxed());
    for ((a, _), above) in boxed.zip(&simplex.arcs[terms..]) {
        flow[a] += above.flow;
    }
    let potentials = (0..network.nodes() as u32).map(|v| simplex.tree.potential(v)).collect();
    Ok(Some(State { potentials, flow }))
}

impl<'a> Simplex<'a> {
    fn new(network: &'a Network, tolerance: f64) -> Result<Self, NumericError> {
        let below = network.arcs.iter().map(|arc| SimplexArc {
            from: arc.from,
            to: arc.to,
            shift: arc.shift,
            lower: if arc.is_boxed() { f64::NEG_INFINITY } else { -arc.weight },
            upper: arc.weight,
            flow: 0.0,
        });
        let above = network.arcs.iter().filter(|arc| arc.is_boxed()).map(|arc| SimplexArc {
            from: arc.from,
            to: arc.to,
            shift: arc.shift - arc.limit,
            lower: 0.0,
            upper: f64::INFINITY,
            flow: 0.0,
        });
        let arcs = below.chain(above).collect();
        check_stopped()?;
        Ok(Simplex {
            network,
            arcs,
            tree: Tree::new(network)?,
            tolerance,
            candidates: Vec::new(),
            collected: 0,
            cursor: 0,
        })
    }

    /// Pivots until no arc can enter. Returns false if the work limit was reached.
    fn run(
        &mut self,
        work_limit: u64,
        work: &mut u64,
        statistics: &mut Statistics,
    ) -> Result<bool, JumpError> {
        loop {
            let Some(arc) = self.price(work) else { return Ok(true) };
            if let Err(contradiction) = self.pivot(arc, work) {
                let work = statistics.work + *work;
                return Err(JumpError::Infeasible { cycles: vec![contradiction], work });
            }
            statistics.pivots += 1;
            check_stopped()?;
            if statistics.work + *work > work_limit {
                return Ok(false);
            }
        }
    }

    /// Size of an arc's jump if its flow may change in that direction, else 0.
    #[inline]
    fn violation(&self, arc: &SimplexArc) -> f64 {
        let jump = arc.shift + self.tree.potential(arc.from) - self.tree.potential(arc.to);
        let open = (jump > self.tolerance && arc.flow < arc.upper)
            || (jump < -self.tolerance && arc.flow > arc.lower);
        if open { jump.abs() } else { 0.0 }
    }

    fn violations(&self) -> usize {
        self.arcs.iter().filter(|arc| self.violation(arc) > 0.0).count()
    }

    /// Returns the candidate with the largest jump. When half of the candidates are used up, a
    /// sweep over the arcs collects more.
    fn price(&mut self, work: &mut u64) -> Option<usize> {
        let mut best = None;
        let mut best_violation = 0.0;
        let mut candidates = std::mem::take(&mut self.candidates);
        *work += candidates.len() as u64;
        candidates.retain(|&a| {
            let violation = self.violation(&self.arcs[a as usize]);
            if violation > best_violation {
                (best_violation, best) = (violation, Some(a as usize));
            }
            violation > 0.0
        });
        if 2 * candidates.len() <= self.collected {
            // Arcs may enter the list twice; they are dropped once they no longer violate
            // optimality.
            let mut swept = 0;
            while swept < self.arcs.len() && candidates.len() < CANDIDATES {
                let a = self.cursor;
                self.cursor = if a + 1 == self.arcs.len() { 0 } else { a + 1 };
                swept += 1;
                let violation = self.violation(&self.arcs[a]);
                if violation > 0.0 {
                    candidates.push(a as u32);
                    if violation > best_violation {
                        (best_violation, best) = (violation, Some(a));
                    }
                }
            }
            *work += swept as u64;
            self.collected = candidates.len();
        }
        self.candidates = candidates;
        best
    }

    /// Augments the cycle closed by the entering arc as far as possible, then exchanges it for the
    /// leaving arc.
    fn pivot(&mut self, entering: usize, work: &mut u64) -> Result<(), InfeasibleCycle> {
        let arc = self.arcs[entering];
        let jump = arc.shift + self.tree.potential(arc.from) - self.tree.potential(arc.to);
        let more = jump > 0.0;
        // Flow runs from the apex down to `tail`, over the arc to `head`, and back up.
        let (tail, head) = if more { (arc.from, arc.to) } else { (arc.to, arc.from) };
        let apex = self.tree.apex(tail, head);
        let capacity =
            |arc: &SimplexArc, more: bool| if more { arc.upper - arc.flow } else { arc.flow - arc.lower };
        let mut step = f64::INFINITY;
        let mut leaving = None;
        let mut v = tail;
        while v != apex {
            let (a, down) = self.tree.link(v);
            let here = capacity(&self.arcs[a], down);
            if here < step {
                (step, leaving) = (here, Some((v, a, down, true)));
            }
            v = self.tree.parent(v);
            *work += 1;
        }
        let here = capacity(&arc, more);
        if here <= step {
            (step, leaving) = (here, None);
        }
        let mut v = head;
        while v != apex {
            let (a, down) = self.tree.link(v);
            let here = capacity(&self.arcs[a], !down);
            if here <= step {
                (step, leaving) = (here, Some((v, a, !down, false)));
            }
            v = self.tree.parent(v);
            *work += 1;
        }
        if step == f64::INFINITY {
            // The limits are infeasible by barely more than the tolerance of `boxes`.
            return Err(self.contradiction(entering, tail, head, apex, jump.abs()));
        }
        let step = step.max(0.0);
        if step > 0.0 {
            for (mut v, way) in [(tail, true), (head, false)] {
                while v != apex {
                    let (a, down) = self.tree.link(v);
                    self.arcs[a].flow += if down == way { step } else { -step };
                    v = self.tree.parent(v);
                }
            }
            self.arcs[entering].flow += if more { step } else { -step };
        }
        let Some((top, a, up_bound, tail_side)) = leaving else {
            self.arcs[entering].flow = if more { arc.upper } else { arc.lower };
            return Ok(());
        };
        self.arcs[a].flow = if up_bound { self.arcs[a].upper } else { self.arcs[a].lower };
        let (inner, outer) = if tail_side { (tail, head) } else { (head, tail) };
        // The jump of the entering arc vanishes: one side of the cut is shifted by it.
        let change = if inner == arc.from { -jump } else { jump };
        *work += u64::from(self.tree.shift_potentials(top, change));
        self.tree.reattach(top, inner, outer, apex, entering as u32, arc.from == outer);
        Ok(())
    }

    /// Returns the cycle closed by an arc as an infeasible cycle of terms.
    fn contradiction(
        &self,
        entering: usize,
        tail: u32,
        head: u32,
        apex: u32,
        excess: f64,
    ) -> InfeasibleCycle {
        let mut cycle = vec![entering];
        for mut v in [tail, head] {
            while v != apex {
                cycle.push(self.tree.link(v).0);
                v = self.tree.parent(v);
            }
        }
        let boxed: Vec<usize> =
            (0..self.network.arcs.len()).filter(|&a| self.network.arcs[a].is_boxed()).collect();
        let arc_of = |a: usize| a.checked_sub(self.network.arcs.len()).map_or(a, |above| boxed[above]);
        InfeasibleCycle {
            terms: cycle.into_iter().map(|a| self.network.terms[arc_of(a)] as usize).collect(),
            excess,
        }
    }

    /// Returns all nodes, parents before children.
    fn preorder(&self) -> Vec<u32> {
        let roots = (0..self.network.nodes() as u32).filter(|&v| self.tree.root(v) == v);
        roots.flat_map(|root| self.tree.component(root)).collect()
    }

    /// Recomputes the potentials from the tree, without accumulated rounding.
    fn integrate(&mut self) {
        for v in self.preorder() {
            if self.tree.parent(v) == NONE {
                continue;
            }
            let (a, down) = self.tree.link(v);
            let shift = self.arcs[a].shift;
            let above = self.tree.potential(self.tree.parent(v));
            self.tree.set_potential(v, if down { above + shift } else { above - shift });
        }
    }

    /// Recomputes the flow of tree arcs from that of the others, without accumulated rounding.
    fn rebalance(&mut self) {
        let order = self.preorder();
        for &v in &order {
            if self.tree.parent(v) != NONE {
                self.arcs[self.tree.link(v).0].flow = 0.0;
            }
        }
        let mut surplus = vec![0.0; order.len()];
        for arc in &self.arcs {
            surplus[arc.from as usize] -= arc.flow;
            surplus[arc.to as usize] += arc.flow;
        }
        for &v in order.iter().rev() {
            let parent = self.tree.parent(v);
            if parent != NONE {
                let (a, down) = self.tree.link(v);
                self.arcs[a].flow = if down { -surplus[v as usize] } else { surplus[v as usize] };
                surplus[parent as usize] += surplus[v as usize];
            }
        }
    }
}
