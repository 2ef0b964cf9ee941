//! Why jumps could not be minimised.

use thiserror::Error;

/// Boxed terms that form a cycle, around which the jumps can not all lie within their limits.
#[derive(Clone, Debug, PartialEq)]
pub struct Contradiction {
    /// The terms of the cycle, in its order.
    pub terms: Vec<usize>,
    /// By how much the jumps around the cycle exceed what the limits allow.
    pub excess: f64,
}

/// Why jumps could not be minimised. Terms are named by their index in the caller's list.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FlowError {
    /// A term names a node that does not exist.
    #[error("term {term} names node {node}, but there are {nodes} nodes")]
    NoSuchNode {
        /// The term.
        term: usize,
        /// The node it names.
        node: u32,
        /// The number of nodes.
        nodes: usize,
    },
    /// A shift, weight or limit is NaN or infinite. A term without upper limit is one with `limit:
    /// None`.
    #[error("the {what} of term {term} is not finite")]
    NonFinite {
        /// The term.
        term: usize,
        /// "shift", "weight" or "limit".
        what: &'static str,
    },
    /// A weight is negative: the term would pay for jumps. Give its reverse (nodes exchanged, shift
    /// negated) or leave it out.
    #[error("the weight {weight} of term {term} is negative; weights must be at least 0")]
    NegativeWeight {
        /// The term.
        term: usize,
        /// Its weight.
        weight: f64,
    },
    /// A limit is zero or negative. To forbid a jump altogether, make its two nodes one.
    #[error("the limit {limit} of term {term} is not positive")]
    NonPositiveLimit {
        /// The term.
        term: usize,
        /// Its limit.
        limit: f64,
    },
    /// The relative perturbation is not in [0, 0.1].
    #[error("a perturbation of {perturbation} is not in [0, 0.1]")]
    BadPerturbation {
        /// What was given.
        perturbation: f64,
    },
    /// No potentials keep all limits. Raise a limit of each cycle, or make one of its terms free
    /// (`limit: None`).
    #[error("no potentials keep all limits: {}", several(cycles))]
    Infeasible {
        /// At least one cycle in each part that boxed terms join and in which limits contradict
        /// each other; no two have a node in common. Where these are mended, others may show.
        cycles: Vec<Contradiction>,
        /// Steps taken until they were found.
        work: u64,
    },
    /// The work limit was reached first. Raise
    /// [`JumpOptions::work_limit`](super::JumpOptions::work_limit).
    #[error("not solved within {work} steps; raise the work limit")]
    WorkLimit {
        /// The steps that were allowed.
        work: u64,
    },
    /// The method stopped, but its answer does not pass its own check: the numbers span too many
    /// orders of magnitude.
    #[error(
        "the answer is not certified (gap {gap:e}, worst residual {worst:e}); scale weights and shifts to fewer orders of magnitude"
    )]
    Uncertified {
        /// The relative gap between the objective and its lower bound.
        gap: f64,
        /// The largest of the gap and the other residuals of the certificate.
        worst: f64,
    },
    /// More nodes or terms than 32-bit indices can name.
    #[error("{nodes} nodes and {terms} terms exceed 32-bit indices; split the mesh")]
    TooLarge {
        /// Number of nodes.
        nodes: usize,
        /// Number of terms.
        terms: usize,
    },
}

/// The first of some cycles in words; a cycle may have any number of terms.
fn several(cycles: &[Contradiction]) -> String {
    const MOST: usize = 8;
    let Some(first) = cycles.first() else { return "their terms are not known".into() };
    let terms: Vec<String> = first.terms.iter().take(MOST).map(|e| e.to_string()).collect();
    let more = match first.terms.len().saturating_sub(MOST) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let others = match cycles.len() - 1 {
        0 => String::new(),
        others => format!("; so do {others} more"),
    };
    format!(
        "the terms {}{more} form a cycle that jumps by {} too much{others}",
        terms.join(", "),
        first.excess
    )
}
