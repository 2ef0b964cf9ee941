//! Errors of jump minimisation.

use crate::NumericError;
use thiserror::Error;

/// Cycle of boxed terms whose jumps cannot all lie within their limits.
#[derive(Clone, Debug, PartialEq)]
pub struct InfeasibleCycle {
    /// Terms of the cycle, in cyclic order.
    pub terms: Vec<usize>,
    /// Amount by which the jumps around the cycle exceed what the limits allow.
    pub excess: f64,
}

/// Error of jump minimisation. Terms are named by their index in the caller's list.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum JumpError {
    /// A term refers to a node that does not exist.
    #[error("term {term} refers to node {node}, but there are only {nodes} nodes")]
    NoSuchNode {
        /// The term.
        term: usize,
        /// The missing node.
        node: u32,
        /// Number of nodes.
        nodes: usize,
    },
    /// A shift, weight or limit is NaN or infinite. For no upper limit, use `limit: None`.
    #[error("the {what} of term {term} is not finite")]
    NonFinite {
        /// The term.
        term: usize,
        /// "shift", "weight" or "limit".
        what: &'static str,
    },
    /// A weight is negative, which would reward jumps.
    #[error("the weight {weight} of term {term} is negative; weights must be at least 0")]
    NegativeWeight {
        /// The term.
        term: usize,
        /// Its weight.
        weight: f64,
    },
    /// A limit is zero or negative. To forbid a jump altogether, merge its two nodes.
    #[error("the limit {limit} of term {term} is not positive; limits must be greater than 0")]
    NonPositiveLimit {
        /// The term.
        term: usize,
        /// Its limit.
        limit: f64,
    },
    /// The relative perturbation is not in [0, 0.1].
    #[error("the perturbation {perturbation} is not in [0, 0.1]")]
    BadPerturbation {
        /// The perturbation given.
        perturbation: f64,
    },
    /// No potentials satisfy all limits. Make one term of each cycle free (`limit: None`).
    #[error("the limits are infeasible: {}", describe(cycles))]
    Infeasible {
        /// At least one infeasible cycle for each infeasible component of the graph of boxed terms;
        /// no two share a node. In addition, each infeasible term that joins a node to itself.
        /// Further cycles may appear once these are resolved.
        cycles: Vec<InfeasibleCycle>,
        /// Steps taken to find them.
        work: u64,
    },
    /// The work limit was reached before the optimum. Raise
    /// [`JumpOptions::work_limit`](super::JumpOptions::work_limit).
    #[error("no solution within {work} steps; raise the work limit")]
    WorkLimit {
        /// Steps allowed.
        work: u64,
    },
    /// The solution fails its optimality check: the numbers span too many orders of magnitude.
    #[error(
        "the solution fails its optimality check (gap {gap:e}, worst residual {worst:e}); scale weights and shifts to fewer orders of magnitude"
    )]
    Uncertified {
        /// Relative duality gap.
        gap: f64,
        /// Largest of the gap and the other residuals of the certificate.
        worst: f64,
    },
    /// The observer stopped the computation.
    #[error(transparent)]
    Stopped(#[from] NumericError),
    /// There are more nodes or terms than 32-bit indices allow.
    #[error("{nodes} nodes and {terms} terms are too many for 32-bit indices; split the mesh")]
    TooLarge {
        /// Number of nodes.
        nodes: usize,
        /// Number of terms.
        terms: usize,
    },
}

/// Describes the first cycle, of which only some terms are listed, and counts the others.
fn describe(cycles: &[InfeasibleCycle]) -> String {
    const MOST: usize = 8;
    let Some(first) = cycles.first() else { return "no cycle is known".into() };
    let noun = if first.terms.len() == 1 { "term" } else { "terms" };
    let terms: Vec<String> = first.terms.iter().take(MOST).map(|e| e.to_string()).collect();
    let more = match first.terms.len().saturating_sub(MOST) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let others = match cycles.len() - 1 {
        0 => String::new(),
        1 => "; 1 more cycle is infeasible".into(),
        others => format!("; {others} more cycles are infeasible"),
    };
    format!(
        "the jumps around the cycle of {noun} {}{more} violate their limits by {}{others}; make a term of each cycle free",
        terms.join(", "),
        first.excess
    )
}
