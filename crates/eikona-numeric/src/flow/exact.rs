//! Snaps jumps to exactly 0 or to their limit.

use super::State;
use super::network::{NONE, Network, incidence};
use crate::error::NumericError;
use crate::observer::{check_step, check_stopped};

/// Integrates the potentials along tight terms, those whose jump is 0 or at its limit within the
/// tolerance, so that these jumps become exact.
///
/// The first node of a component gets potential 0; integers stay integers. Returns the jumps, which
/// on tight terms are exactly 0 or the limit.
pub(super) fn snap_jumps(
    network: &Network,
    state: &mut State,
    tolerance: f64,
) -> Result<Vec<f64>, NumericError> {
    let n = network.nodes();
    let old = &state.potentials;
    let tight = |a: usize| {
        let arc = &network.arcs[a];
        let jump = arc.jump(old);
        if jump.abs() <= tolerance {
            Some(0.0)
        } else if (jump - arc.limit).abs() <= tolerance {
            Some(arc.limit)
        } else {
            None
        }
    };
    let targets: Vec<Option<f64>> = (0..network.arcs.len()).map(tight).collect();
    check_stopped()?;
    let joins = |a: usize| targets[a].is_some();
    let incidence = incidence(
        n,
        network.arcs.iter().enumerate().filter(|(a, _)| joins(*a)).map(|(a, arc)| (a as u32, arc)),
    );
    check_stopped()?;
    let whole = |x: f64| x.fract() == 0.0 && x.abs() < 2f64.powi(50);
    let all_whole = network.arcs.iter().all(|arc| whole(arc.shift) && (!arc.is_boxed() || whole(arc.limit)));
    check_stopped()?;
    let base = first_potentials(network, old);
    check_stopped()?;
    let mut new = vec![f64::NAN; n];
    let mut queue = Vec::new();
    for root in 0..n {
        check_step(root)?;
        if !new[root].is_nan() {
            continue;
        }
        let relative = old[root] - base[root];
        new[root] = if all_whole { relative.round() } else { relative };
        queue.push(root as u32);
        while let Some(v) = queue.pop() {
            for &a in incidence.row(v as usize) {
                let w = network.across(a, v);
                if new[w as usize].is_nan() {
                    let arc = &network.arcs[a as usize];
                    let jump = targets[a as usize].unwrap_or(0.0);
                    new[w as usize] = match arc.from == v {
                        true => (arc.shift + new[v as usize]) - jump,
                        false => (new[v as usize] - arc.shift) + jump,
                    };
                    queue.push(w);
                }
            }
        }
    }
    state.potentials = new;
    check_stopped()?;
    let jumps = network.arcs.iter().zip(&targets);
    Ok(jumps.map(|(arc, target)| target.unwrap_or_else(|| arc.jump(&state.potentials))).collect())
}

/// For each node, the potential of the first node of its component in the caller's numbering.
fn first_potentials(network: &Network, potentials: &[f64]) -> Vec<f64> {
    let n = network.nodes();
    let mut root: Vec<u32> = (0..n as u32).collect();
    let mut first = root.clone();
    for v in 0..n {
        if network.forest[v] != NONE {
            root[v] = root[network.across(network.forest[v], v as u32) as usize];
        }
        let first = &mut first[root[v] as usize];
        if network.callers[v] < network.callers[*first as usize] {
            *first = v as u32;
        }
    }
    root.iter().map(|&r| potentials[first[r as usize] as usize]).collect()
}
