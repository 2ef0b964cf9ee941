//! Primal-dual method: lowers jumps level by level, with one maximum flow per level.
//!
//! Terms with a nonzero jump have their flow at a bound, which creates surpluses and deficits at
//! the nodes. A maximum flow over tight terms, whose jump is 0 or at its limit, balances as many of
//! these as possible. Then the potentials of the nodes reachable from surpluses change until
//! another term becomes tight (shortest paths, Dijkstra). This repeats until no surplus is left.
//! The potentials always satisfy the limits, the objective never increases, and each level costs
//! O(m log m) plus one maximum flow.

use super::State;
use super::Statistics;
use super::maximum_flow::{HalfArc, MaximumFlow, ResidualGraph};
use super::network::{Network, incidence};
use crate::error::NumericError;
use crate::observer::check_stopped;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

struct Levels<'a> {
    network: &'a Network,
    potentials: Vec<f64>,
    flow: Vec<f64>,
    surplus: Vec<f64>,
    residual: ResidualGraph,
    /// Cost per unit of flow over each half-arc; infinite if it has no capacity at any cost.
    costs: Vec<f64>,
    /// The half-arc of each arc that starts at its `from`.
    forward: Vec<u32>,
    tolerance: f64,
}

/// Heap entry: a node with its tentative distance.
#[derive(PartialEq)]
struct Labelled {
    distance: f64,
    node: u32,
}

impl Eq for Labelled {}
impl PartialOrd for Labelled {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Labelled {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.distance.total_cmp(&other.distance).then(self.node.cmp(&other.node))
    }
}

/// Solves by the primal-dual method from potentials that satisfy all limits. Returns `None` if
/// `work_limit` steps do not suffice.
pub(super) fn solve(
    network: &Network,
    start: Vec<f64>,
    tolerance: f64,
    work_limit: u64,
    statistics: &mut Statistics,
) -> Result<Option<State>, NumericError> {
    let largest = network.arcs.iter().map(|arc| arc.weight).fold(0.0, f64::max);
    let negligible = 1e-14 * largest;
    let mut levels = Levels::new(network, start, tolerance)?;
    check_stopped()?;
    let mut flow = MaximumFlow::new(network.nodes());
    loop {
        levels.open_level(negligible);
        check_stopped()?;
        let left = work_limit.saturating_sub(statistics.work);
        let before = flow.work;
        flow.run(&mut levels.residual, &mut levels.surplus, negligible, left)?;
        statistics.work += flow.work - before + 4 * network.arcs.len() as u64;
        statistics.levels += 1;
        check_stopped()?;
        levels.close_level();
        check_stopped()?;
        if !levels.update_potentials(negligible) {
            break;
        }
        if statistics.work > work_limit {
            return Ok(None);
        }
    }
    let mut flow = levels.flow;
    network.balance(&mut flow);
    Ok(Some(State { potentials: levels.potentials, flow }))
}

impl<'a> Levels<'a> {
    fn new(network: &'a Network, potentials: Vec<f64>, tolerance: f64) -> Result<Self, NumericError> {
        let (residual, forward) = residual_graph(network)?;
        check_stopped()?;
        let mut flow = vec![0.0; network.arcs.len()];
        let mut surplus = vec![0.0; network.nodes()];
        for (arc, y) in network.arcs.iter().zip(&mut flow) {
            let jump = arc.jump(&potentials);
            *y = match (jump > tolerance, jump < -tolerance && !arc.is_boxed()) {
                (true, _) => arc.weight,
                (_, true) => -arc.weight,
                _ => 0.0,
            };
            surplus[arc.from as usize] -= *y;
            surplus[arc.to as usize] += *y;
        }
        let costs = vec![0.0; residual.arcs.len()];
        Ok(Levels { network, potentials, flow, surplus, residual, costs, forward, tolerance })
    }

    /// Whether an arc's jump is 0, and whether it is at its limit.
    #[inline]
    fn tight(&self, jump: f64, limit: f64) -> (bool, bool) {
        let low = if limit < f64::INFINITY { jump <= self.tolerance } else { jump.abs() <= self.tolerance };
        (low, jump >= limit - self.tolerance)
    }

    /// Sets the residual capacities of tight arcs, over which flow costs nothing.
    fn open_level(&mut self, negligible: f64) {
        for (a, arc) in self.network.arcs.iter().enumerate() {
            let y = self.flow[a];
            let (low, high) = self.tight(arc.jump(&self.potentials), arc.limit);
            let (more, less) = match (low, high) {
                (true, _) if arc.is_boxed() => (arc.weight - y, f64::INFINITY),
                (true, _) => (arc.weight - y, arc.weight + y),
                (_, true) => (f64::INFINITY, y - arc.weight),
                _ => (0.0, 0.0),
            };
            let h = self.forward[a] as usize;
            let reverse = self.residual.arcs[h].reverse as usize;
            self.residual.arcs[h].capacity = if more > negligible { more } else { 0.0 };
            self.residual.arcs[reverse].capacity = if less > negligible { less } else { 0.0 };
        }
    }

    /// Reads the flow off the residual capacities, and sets the cost of further flow.
    fn close_level(&mut self) {
        for (a, arc) in self.network.arcs.iter().enumerate() {
            let jump = arc.jump(&self.potentials);
            let (low, high) = self.tight(jump, arc.limit);
            let h = self.forward[a] as usize;
            let reverse = self.residual.arcs[h].reverse as usize;
            let (more, less) = (self.residual.arcs[h].capacity, self.residual.arcs[reverse].capacity);
            let open = |capacity: f64, otherwise: f64| if capacity > 0.0 { 0.0 } else { otherwise };
            let (cost_more, cost_less) = match (low, high) {
                (true, _) => {
                    self.flow[a] = arc.weight - more;
                    (open(more, (arc.limit - jump).max(0.0)), open(less, f64::INFINITY))
                }
                (_, true) => {
                    self.flow[a] = arc.weight + less;
                    (0.0, open(less, jump.max(0.0)))
                }
                _ if arc.is_boxed() => (arc.limit - jump, jump),
                _ if jump > 0.0 => (f64::INFINITY, jump),
                _ => (-jump, f64::INFINITY),
            };
            self.costs[h] = cost_more;
            self.costs[reverse] = cost_less;
        }
    }

    /// Changes the potentials by the shortest distances from surpluses to the nearest deficit.
    /// Returns false if no surplus is left or no deficit can be reached.
    fn update_potentials(&mut self, negligible: f64) -> bool {
        let n = self.network.nodes();
        let mut distance = vec![f64::INFINITY; n];
        let mut done = vec![false; n];
        let mut heap: BinaryHeap<Reverse<Labelled>> = BinaryHeap::new();
        // Nodes to be scanned at the current distance.
        let mut stack: Vec<u32> = (0..n as u32).filter(|&v| self.surplus[v as usize] > negligible).collect();
        for &v in &stack {
            distance[v as usize] = 0.0;
        }
        let mut found = None;
        'search: loop {
            let v = match stack.pop() {
                Some(v) => v,
                None => match heap.pop() {
                    Some(Reverse(Labelled { node, .. })) => node,
                    None => break,
                },
            };
            if std::mem::replace(&mut done[v as usize], true) {
                continue;
            }
            let here = distance[v as usize];
            if self.surplus[v as usize] < -negligible {
                found = Some(here);
                break 'search;
            }
            for h in self.residual.range(v) {
                let (head, cost) = (self.residual.arcs[h].head, self.costs[h]);
                let there = here + cost;
                if there < distance[head as usize] {
                    distance[head as usize] = there;
                    if cost == 0.0 {
                        stack.push(head);
                    } else {
                        heap.push(Reverse(Labelled { distance: there, node: head }));
                    }
                }
            }
        }
        let Some(level) = found else { return false };
        for v in 0..n {
            self.potentials[v] -= distance[v].min(level);
        }
        true
    }
}

/// Builds the residual graph. Also returns the index of each arc's forward half-arc.
fn residual_graph(network: &Network) -> Result<(ResidualGraph, Vec<u32>), NumericError> {
    let arcs = &network.arcs;
    let all = arcs.iter().enumerate().map(|(a, arc)| (a as u32, arc));
    let (start, order) = incidence(network.nodes(), all).into_parts();
    check_stopped()?;
    let mut places = vec![[0u32; 2]; arcs.len()];
    for v in 0..network.nodes() as u32 {
        for h in start[v as usize]..start[v as usize + 1] {
            let a = order[h as usize] as usize;
            places[a][usize::from(arcs[a].from != v)] = h;
        }
    }
    check_stopped()?;
    let mut list = vec![HalfArc { head: 0, reverse: 0, capacity: 0.0 }; order.len()];
    for (arc, &[forward, backward]) in arcs.iter().zip(&places) {
        list[forward as usize] = HalfArc { head: arc.to, reverse: backward, capacity: 0.0 };
        list[backward as usize] = HalfArc { head: arc.from, reverse: forward, capacity: 0.0 };
    }
    Ok((ResidualGraph { start, arcs: list }, places.iter().map(|place| place[0]).collect()))
}
