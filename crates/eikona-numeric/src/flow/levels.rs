//! The primal-dual method: jumps are lowered level by level, with a maximum flow between two
//! levels.
//!
//! Flow on terms that jump is fixed at its bound, which leaves surpluses and deficits at the nodes.
//! Flow that balances them may only use terms whose jump is 0 or at its limit, so much fits as a
//! maximum flow says. Then the potentials that surplus reaches are moved until the next such term
//! opens (shortest paths, Dijkstra), and so on until nothing is left over. Every potential is that
//! of a solution within the limits, the objective never rises, and each level costs O(m log m) and
//! one maximum flow.

use super::State;
use super::Statistics;
use super::maximum_flow::{Half, Halves, MaximumFlow};
use super::network::{Incidence, Network};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

struct Levels<'a> {
    network: &'a Network,
    potentials: Vec<f64>,
    flow: Vec<f64>,
    surplus: Vec<f64>,
    halves: Halves,
    /// What a unit of flow costs over each half; infinite if there is no room at any price.
    costs: Vec<f64>,
    /// The half of each arc that starts at its `from`.
    forward: Vec<u32>,
    tolerance: f64,
}

/// A node that can be reached at a price.
#[derive(PartialEq)]
struct Reached {
    price: f64,
    node: u32,
}

impl Eq for Reached {}
impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Reached {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.price.total_cmp(&other.price).then(self.node.cmp(&other.node))
    }
}

/// Solves by the primal-dual method from potentials that keep all limits. `None` when `work_limit`
/// steps do not suffice.
pub(super) fn solve(
    network: &Network,
    start: Vec<f64>,
    tolerance: f64,
    work_limit: u64,
    statistics: &mut Statistics,
) -> Option<State> {
    let largest = network.arcs.iter().map(|arc| arc.weight).fold(0.0, f64::max);
    let nothing = 1e-14 * largest;
    let mut levels = Levels::new(network, start, tolerance);
    let mut flow = MaximumFlow::new(network.nodes());
    loop {
        levels.open_level(nothing);
        let left = work_limit.saturating_sub(statistics.work);
        let before = flow.work;
        flow.run(&mut levels.halves, &mut levels.surplus, nothing, left);
        statistics.work += flow.work - before + 4 * network.arcs.len() as u64;
        statistics.levels += 1;
        levels.close_level();
        if !levels.raise(nothing) {
            break;
        }
        if statistics.work > work_limit {
            return None;
        }
    }
    let mut flow = levels.flow;
    network.balance(&mut flow);
    Some(State { potentials: levels.potentials, flow })
}

impl<'a> Levels<'a> {
    fn new(network: &'a Network, potentials: Vec<f64>, tolerance: f64) -> Self {
        let (halves, forward) = halves(network);
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
        let costs = vec![0.0; halves.list.len()];
        Levels { network, potentials, flow, surplus, halves, costs, forward, tolerance }
    }

    /// Whether an arc's jump is 0 and whether it is at its limit.
    #[inline]
    fn tight(&self, jump: f64, limit: f64) -> (bool, bool) {
        let low = if limit < f64::INFINITY { jump <= self.tolerance } else { jump.abs() <= self.tolerance };
        (low, jump >= limit - self.tolerance)
    }

    /// Room on the arcs over which flow costs nothing.
    fn open_level(&mut self, nothing: f64) {
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
            let mate = self.halves.list[h].mate as usize;
            self.halves.list[h].room = if more > nothing { more } else { 0.0 };
            self.halves.list[mate].room = if less > nothing { less } else { 0.0 };
        }
    }

    /// Reads the flow off the room that is left, and says what more would cost.
    fn close_level(&mut self) {
        for (a, arc) in self.network.arcs.iter().enumerate() {
            let jump = arc.jump(&self.potentials);
            let (low, high) = self.tight(jump, arc.limit);
            let h = self.forward[a] as usize;
            let mate = self.halves.list[h].mate as usize;
            let (more, less) = (self.halves.list[h].room, self.halves.list[mate].room);
            let open = |room: f64, otherwise: f64| if room > 0.0 { 0.0 } else { otherwise };
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
            self.costs[mate] = cost_less;
        }
    }

    /// Moves the potentials that surplus reaches until it reaches a deficit; false if nothing is
    /// left over or no deficit can be reached.
    fn raise(&mut self, nothing: f64) -> bool {
        let n = self.network.nodes();
        let mut price = vec![f64::INFINITY; n];
        let mut done = vec![false; n];
        let mut heap: BinaryHeap<Reverse<Reached>> = BinaryHeap::new();
        // Nodes to be scanned at the present price.
        let mut stack: Vec<u32> = (0..n as u32).filter(|&v| self.surplus[v as usize] > nothing).collect();
        for &v in &stack {
            price[v as usize] = 0.0;
        }
        let mut found = None;
        'search: loop {
            let v = match stack.pop() {
                Some(v) => v,
                None => match heap.pop() {
                    Some(Reverse(Reached { node, .. })) => node,
                    None => break,
                },
            };
            if std::mem::replace(&mut done[v as usize], true) {
                continue;
            }
            let here = price[v as usize];
            if self.surplus[v as usize] < -nothing {
                found = Some(here);
                break 'search;
            }
            for h in self.halves.range(v) {
                let (head, cost) = (self.halves.list[h].head, self.costs[h]);
                let there = here + cost;
                if there < price[head as usize] {
                    price[head as usize] = there;
                    if cost == 0.0 {
                        stack.push(head);
                    } else {
                        heap.push(Reverse(Reached { price: there, node: head }));
                    }
                }
            }
        }
        let Some(level) = found else { return false };
        for v in 0..n {
            self.potentials[v] -= price[v].min(level);
        }
        true
    }
}

/// Both directions of every arc, and where that from its `from` stands.
fn halves(network: &Network) -> (Halves, Vec<u32>) {
    let arcs = &network.arcs;
    let Incidence { start, arcs: order } =
        Incidence::of(network.nodes(), arcs.iter().enumerate().map(|(a, arc)| (a as u32, arc)));
    let mut places = vec![[0u32; 2]; arcs.len()];
    for v in 0..network.nodes() as u32 {
        for h in start[v as usize]..start[v as usize + 1] {
            let a = order[h as usize] as usize;
            places[a][usize::from(arcs[a].from != v)] = h;
        }
    }
    let mut list = vec![Half { head: 0, mate: 0, room: 0.0 }; order.len()];
    for (arc, &[forward, backward]) in arcs.iter().zip(&places) {
        list[forward as usize] = Half { head: arc.to, mate: backward, room: 0.0 };
        list[backward as usize] = Half { head: arc.from, mate: forward, room: 0.0 };
    }
    (Halves { start, list }, places.iter().map(|place| place[0]).collect())
}
