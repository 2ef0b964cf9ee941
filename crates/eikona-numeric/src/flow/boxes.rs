//! Whether potentials can keep all limits, and which do.

use super::error::FlowError;
use super::network::{Arc, Incidence, NONE, Network};

/// Lowers potentials until every boxed jump lies within its limits, to a tolerance.
///
/// A limit bounds a difference of two potentials, so this is a shortest path problem (Bellman and Ford) on the boxed terms only;
/// a negative cycle of it is a cycle of terms whose limits contradict each other.
///
/// # Cost
/// O(boxed terms) when few are violated; O(nodes x terms) of the boxed part at worst.
pub(super) fn keep_limits(
    network: &Network,
    potentials: &mut [f64],
    tolerance: f64,
) -> Result<(), FlowError> {
    let arcs = &network.arcs;
    let boxed = || arcs.iter().enumerate().filter(|(_, arc)| arc.is_boxed()).map(|(a, arc)| (a as u32, arc));
    if boxed().all(|(_, arc)| within(arc, arc.jump(potentials), tolerance)) {
        return Ok(());
    }
    let incidence = Incidence::of(network.nodes(), boxed());
    // The arc that bounds a node's potential now.
    let mut bound_by = vec![NONE; network.nodes()];
    let mut queue: Vec<u32> =
        (0..network.nodes() as u32).filter(|&v| !incidence.at(v as usize).is_empty()).collect();
    let members = queue.len();
    let mut queued = vec![false; network.nodes()];
    let mut lowered = 0;
    let mut next = Vec::new();
    for round in 0..=members {
        for &v in &queue {
            queued[v as usize] = false;
            for &a in incidence.at(v as usize) {
                let arc = &arcs[a as usize];
                let (w, bound) = bound(arc, v, potentials);
                if potentials[w as usize] > bound + tolerance {
                    potentials[w as usize] = bound;
                    bound_by[w as usize] = a;
                    lowered += 1;
                    if !queued[w as usize] {
                        queued[w as usize] = true;
                        next.push(w);
                    }
                }
            }
        }
        std::mem::swap(&mut queue, &mut next);
        next.clear();
        if queue.is_empty() {
            return Ok(());
        }
        if lowered >= members || round == members {
            lowered = 0;
            if let Some(error) = contradiction(network, &bound_by) {
                return Err(error);
            }
        }
    }
    // Only rounding can bring us here: a cycle that contradicts itself by about the tolerance.
    Ok(())
}

fn within(arc: &Arc, jump: f64, tolerance: f64) -> bool {
    jump >= -tolerance && jump <= arc.limit + tolerance
}

/// What the potential of `v` allows at the other end of a boxed arc.
fn bound(arc: &Arc, v: u32, potentials: &[f64]) -> (u32, f64) {
    let here = potentials[v as usize];
    match arc.from == v {
        true => (arc.to, here + arc.shift),
        false => (arc.from, here + (arc.limit - arc.shift)),
    }
}

/// A cycle among the arcs that bound the potentials.
fn contradiction(network: &Network, bound_by: &[u32]) -> Option<FlowError> {
    const NEW: u32 = 0;
    let mut seen = vec![NEW; bound_by.len()];
    for start in 0..bound_by.len() as u32 {
        let mut v = start;
        while seen[v as usize] == NEW && bound_by[v as usize] != NONE {
            seen[v as usize] = start + 1;
            v = network.across(bound_by[v as usize], v);
        }
        if bound_by[v as usize] == NONE || seen[v as usize] != start + 1 {
            continue;
        }
        // Round once more, adding up.
        let (first, mut total, mut terms) = (v, 0.0, Vec::new());
        loop {
            let a = bound_by[v as usize] as usize;
            let arc = &network.arcs[a];
            total += if arc.to == v { arc.shift } else { arc.limit - arc.shift };
            terms.push(network.terms[a] as usize);
            v = network.across(a as u32, v);
            if v == first {
                break;
            }
        }
        if total < 0.0 {
            terms.reverse();
            return Some(FlowError::Infeasible { terms, excess: -total });
        }
    }
    None
}
