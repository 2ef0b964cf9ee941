//! How good an answer is, from the answer alone.

use super::JumpTerm;

/// What can be said about potentials and a flow without trusting who found them.
///
/// For any potentials `primal` is at least the optimum, and for any flow within its bounds that is
/// conserved at all nodes `dual` is at most the optimum (weak duality): where the two agree, both
/// are optimal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Certificate {
    /// The sum of the costs of the jumps that the potentials make. Boxed jumps count as if they lay
    /// within their limits.
    pub primal: f64,
    /// The sum over the terms of `shift * flow`, less `limit * (flow - weight)` where the flow of a
    /// boxed term exceeds its weight.
    pub dual: f64,
    /// `(primal - dual) / max(primal, dual)`; where the optimum is less than a millionth of what
    /// shifts and limits would cost as jumps, or less than if every term jumped by a millionth of
    /// the largest of them, relative to that, since rounding is in proportion to them.
    pub gap: f64,
    /// The largest |inflow - outflow| of a node, relative to the largest weight.
    pub conservation: f64,
    /// By how much the flow of a free term exceeds its weight, at most; relative to the largest
    /// weight.
    pub overflow: f64,
    /// By how much a boxed jump lies outside its limits, at most; relative to the largest shift or
    /// limit.
    pub violation: f64,
}

/// The certificate of potentials and flow for given weights.
pub(super) fn certify(
    nodes: usize,
    terms: &[JumpTerm],
    weights: &[f64],
    potentials: &[f64],
    flow: &[f64],
) -> Certificate {
    let mut net = vec![0.0; nodes];
    let mut c = Certificate::default();
    let (mut largest, mut scale, mut reach, mut all) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    for ((term, &w), &y) in terms.iter().zip(weights).zip(flow) {
        largest = largest.max(w);
        scale = scale.max(term.shift.abs()).max(term.limit.unwrap_or(0.0));
        net[term.from as usize] -= y;
        net[term.to as usize] += y;
        let jump = term.jump(potentials);
        reach += w * term.shift.abs().max(term.limit.unwrap_or(0.0));
        all += w;
        match term.limit {
            None => {
                c.primal += w * jump.abs();
                c.dual += term.shift * y;
                c.overflow = c.overflow.max(y.abs() - w);
            }
            Some(limit) => {
                c.primal += w * jump.clamp(0.0, limit);
                c.dual += term.shift * y - limit * (y - w).max(0.0);
                c.violation = c.violation.max(-jump).max(jump - limit);
            }
        }
    }
    c.conservation = net.iter().fold(0.0, |m: f64, n| m.max(n.abs()));
    let relative = |value: f64, to: f64| if to > 0.0 { value / to } else { value };
    c.conservation = relative(c.conservation, largest);
    c.overflow = relative(c.overflow, largest);
    c.violation = relative(c.violation, scale);
    c.gap = relative(c.primal - c.dual, c.primal.max(c.dual).max(1e-6 * reach).max(1e-6 * scale * all));
    c
}

/// A lower bound of the optimum for the terms' own weights, from a flow for weights that are up to
/// `1 + excess` times as large.
pub(super) fn lower_bound(terms: &[JumpTerm], flow: &[f64], excess: f64) -> f64 {
    let bound = |(term, y): (&JumpTerm, &f64)| {
        let y = y / (1.0 + excess);
        term.shift * y - term.limit.map_or(0.0, |limit| limit * (y - term.weight).max(0.0))
    };
    terms.iter().zip(flow).map(bound).sum()
}
