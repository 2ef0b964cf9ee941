//! Certificates of optimality, computed from potentials and flow alone.

use super::JumpTerm;

/// Certificate of optimality of potentials and a flow, independent of how they were found.
///
/// Weak duality: for any potentials `primal` is at least the optimum, and for any circulation
/// within its bounds `dual` is at most the optimum. Where the two agree, both are optimal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Certificate {
    /// Total cost of the jumps of the potentials. Boxed jumps are clamped to their limits.
    pub primal: f64,
    /// Sum over the terms of `shift * flow`, less `limit * (flow - weight)` where the flow of a
    /// boxed term exceeds its weight.
    pub dual: f64,
    /// Relative duality gap `(primal - dual) / max(primal, dual)`. Rounding is proportional to the
    /// data, so the denominator is at least a millionth of the sum of `weight * max(|shift|,
    /// limit)`, and of the sum of the weights times the largest shift or limit.
    pub gap: f64,
    /// Largest |inflow - outflow| of a node, relative to the largest weight.
    pub conservation: f64,
    /// Largest excess of a free term's flow over its weight, relative to the largest weight.
    pub overflow: f64,
    /// Largest violation of the limits of a boxed jump, relative to the largest shift or limit.
    pub violation: f64,
}

/// Largest relative duality gap, flow excess or limit violation that is accepted.
const ACCEPTED: f64 = 1e-6;

impl Certificate {
    /// The largest of the gap and the other residuals.
    pub(super) fn worst(&self) -> f64 {
        [self.conservation, self.overflow, self.violation].into_iter().fold(self.gap.abs(), f64::max)
    }

    pub(super) fn is_accepted(&self) -> bool {
        !self.gap.is_nan() && self.worst() <= ACCEPTED
    }
}

/// Computes the certificate of potentials and flow for given weights.
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

/// Lower bound on the optimum for the terms' own weights, from a flow for weights that are at most
/// `1 + excess` times as large.
pub(super) fn lower_bound(terms: &[JumpTerm], flow: &[f64], excess: f64) -> f64 {
    let bound = |(term, y): (&JumpTerm, &f64)| {
        let y = y / (1.0 + excess);
        term.shift * y - term.limit.map_or(0.0, |limit| limit * (y - term.weight).max(0.0))
    };
    terms.iter().zip(flow).map(bound).sum()
}
