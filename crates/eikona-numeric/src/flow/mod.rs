//! Potentials that make the cheapest jumps: a linear program on a graph, solved by its dual, a flow
//! of least cost.
//!
//! A [`JumpTerm`] compares the potentials of two nodes, `jump = shift + p[from] - p[to]`, and costs
//! `weight * |jump|`. A *boxed* term has a limit: its jump must lie in `[0, limit]`. The multiplier
//! of a jump flows along its term; at the optimum the flow is a circulation, jumps are made only
//! where the flow is at its bound, and both have the same value, which is what the [`Certificate`]
//! checks.
//!
//! The way of an instance: terms -> `network` (what binds, a spanning forest, numbers in its order)
//! -> `boxes` (can the limits be kept?) -> `simplex` (with `tree`) or `levels` (with
//! `maximum_flow`) -> `exact` (zeros that are zero) -> `certificate`.

mod boxes;
mod certificate;
mod error;
mod exact;
mod levels;
mod maximum_flow;
mod network;
mod simplex;
mod tree;

pub use certificate::Certificate;
pub use error::{Contradiction, FlowError};

use network::Network;

/// One term of the objective: `weight * |jump|` of the jump `shift + p[from] - p[to]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JumpTerm {
    /// The node whose potential raises the jump.
    pub from: u32,
    /// The node whose potential lowers it. May be the same: such a jump is always `shift`.
    pub to: u32,
    /// The jump where the potentials are equal.
    pub shift: f64,
    /// What a jump of 1 costs; at least 0.
    pub weight: f64,
    /// `Some(limit)`: the jump must lie in `[0, limit]`, and `limit` must be positive.
    pub limit: Option<f64>,
    /// What the perturbation of the weight is made from. Equal keys give equal perturbations; keys
    /// that come from the geometry rather than from the numbering make answers independent of the
    /// numbering.
    pub key: u64,
}

impl JumpTerm {
    /// The jump that potentials make.
    #[inline]
    pub fn jump(&self, potentials: &[f64]) -> f64 {
        self.shift + potentials[self.from as usize] - potentials[self.to as usize]
    }
}

/// How to minimise jumps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JumpOptions {
    /// Weights are multiplied by `1 + perturbation * r`, where `r` in `[0, 1)` is a hash of the
    /// term's key, so that of several equally cheap answers always the same is found. At most 0.1;
    /// 0 leaves the weights alone.
    pub perturbation: f64,
    /// Which method to use; `None` chooses.
    pub method: Option<JumpMethod>,
    /// The most steps (nodes and terms touched) that may be taken; 2 to 9 times 10^7 take a second.
    pub work_limit: u64,
}

impl Default for JumpOptions {
    fn default() -> Self {
        JumpOptions { perturbation: 1e-4, method: None, work_limit: 100_000_000_000 }
    }
}

/// How a flow of least cost is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JumpMethod {
    /// Network simplex: exchanges one term of a spanning forest at a time. For shifts of many
    /// different values.
    NetworkSimplex,
    /// Primal-dual: a maximum flow for each level of jumps. For shifts of few different values.
    PrimalDual,
}

/// The potentials of least cost and the flow that proves it.
#[derive(Clone, Debug, PartialEq)]
pub struct JumpSolution {
    /// A potential for each node; 0 at the first node of each component.
    pub potentials: Vec<f64>,
    /// The jump of each term. Jumps that are 0 or at their limit are so exactly, and if all shifts
    /// and limits are whole numbers, so are the jumps.
    pub jumps: Vec<f64>,
    /// What flows along each term from `from` to `to`.
    pub flow: Vec<f64>,
    /// The cost of the jumps with the weights as given.
    pub objective: f64,
    /// No potentials cost less than this with the weights as given. The difference to `objective`
    /// is at most `perturbation` times the objective, and rounding.
    pub lower_bound: f64,
    /// The certificate for the perturbed weights: for what was solved.
    pub certificate: Certificate,
    /// How it was found.
    pub statistics: JumpStatistics,
}

/// How jumps were minimised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JumpStatistics {
    /// The method that found the answer.
    pub method: JumpMethod,
    /// Exchanges of the network simplex.
    pub pivots: u64,
    /// Levels of the primal-dual method.
    pub levels: u64,
    /// Steps taken (nodes and terms touched).
    pub work: u64,
}
use JumpStatistics as Statistics;

/// Potentials and flow in the numbering of a network.
struct State {
    potentials: Vec<f64>,
    flow: Vec<f64>,
}

/// Jumps below this, relative to the largest that the start makes, are no jumps.
const TOLERANCE: f64 = 1e-9;
/// What shifts, limits and potentials are off by, relatively.
const ROUNDING: f64 = 1e-12;
/// Up to so many different sizes of jumps the primal-dual method is tried first.
const FEW_SIZES: usize = 64;
/// Steps a node and term after which the network simplex takes over from the primal-dual method.
/// Broken curves need about 100, 160 levels of noise 6000; the network simplex 1500 for noise on 25
/// 000 cells.
const PATIENCE: u64 = 2000;
/// The largest relative gap, excess of flow or violation of a limit that is accepted.
const ACCEPTED_GAP: f64 = 1e-6;

/// Finds potentials of least total cost `sum of weight * |jump|` such that all boxed jumps lie
/// within their limits, with a proof.
///
/// `terms` may repeat, join a node to itself, and leave the graph in any number of components. A
/// free term of weight 0 costs and binds nothing.
///
/// # Which method
/// Unless `options.method` says so: the primal-dual method if the jumps of the start have at most
/// 64 different sizes, else the network simplex. Should the former need more than 2000 steps a node
/// and term, the latter takes over. The rule counts, it does not clock: the same input always takes
/// the same way.
///
/// The start makes jumps on boxed terms and straight across the gaps between them, so their sizes
/// are the periods of the curves: few on a surface of small genus (4 to 11 levels were needed), as
/// many as terms where every shift is noisy.
///
/// # Errors
/// A [`FlowError`] that names the term: indices out of range, numbers that are not finite, negative
/// weights, limits that are not positive; [`FlowError::Infeasible`] with cycles of terms whose
/// limits contradict each other; [`FlowError::WorkLimit`] if `options.work_limit` does not suffice.
///
/// # Cost
/// On graphs dual to a triangulated torus, one thread of a shared machine (`examples/jumps.rs`):
///
/// | instance | nodes | terms | levels or pivots | seconds |
/// |---|---|---|---|---|
/// | closed curves | 500 800 | 751 200 | 1 level | 0.7 to 1.8 |
/// | broken curves | 50 000 | 75 000 | 5 levels | 0.1 to 0.2 |
/// | broken curves | 200 000 | 300 000 | 6 levels | 1 to 2 |
/// | broken curves | 500 800 | 751 200 | 6 levels | 3 to 6 |
/// | broken curves on a double torus | 35 040 | 50 850 | 10 levels | 0.1 to 0.2 |
/// | noise on every term | 50 000 | 75 000 | 43 867 pivots | 2 to 3 |
/// | noise on every term | 200 000 | 300 000 | 182 094 pivots | 69 |
///
/// # Reference
/// The program is that of Feng, Gillespie and Crane, *Winding Numbers on Discrete Surfaces* (2023),
/// eq. 11. Network simplex: Cunningham, *A network simplex method* (1976); primal-dual: Ford and
/// Fulkerson, *Flows in Networks* (1962), ch. III; in both the duality of Rockafellar, *Network
/// Flows and Monotropic Optimization* (1984).
///
/// # Example
/// ```
/// use eikona_numeric::{JumpOptions, JumpTerm, minimise_jumps};
/// // Three nodes in a cycle whose shifts add up to 1. The cheapest term takes 0.25, its limit.
/// let door = |from, to, shift, weight, limit| {
///     JumpTerm { from, to, shift, weight, limit, key: from as u64 }
/// };
/// let terms =
///     [door(0, 1, 1.0, 3.0, None), door(1, 2, 0.0, 1.0, Some(0.25)), door(2, 0, 0.0, 2.0, None)];
/// let solution = minimise_jumps(3, &terms, &JumpOptions::default())?;
/// assert_eq!(solution.jumps, [0.0, 0.25, 0.75]);
/// assert_eq!(solution.objective, 0.25 * 1.0 + 0.75 * 2.0);
/// assert!(solution.certificate.gap.abs() < 1e-9);
/// # Ok::<(), eikona_numeric::FlowError>(())
/// ```
pub fn minimise_jumps(
    nodes: usize,
    terms: &[JumpTerm],
    options: &JumpOptions,
) -> Result<JumpSolution, FlowError> {
    check(nodes, terms, options)?;
    let perturb = |term: &JumpTerm| term.weight * (1.0 + options.perturbation * fraction(term.key));
    let weights: Vec<f64> = terms.iter().map(perturb).collect();
    let network = Network::new(nodes, terms, &weights);
    let mut start = network.forest_potentials();
    let tolerance = tolerance(&network, &start);
    let mut work = 0;
    let mut cycles = contradicting_loops(terms);
    cycles.extend(boxes::keep_limits(&network, &mut start, 1e-3 * tolerance, options.work_limit, &mut work)?);
    if !cycles.is_empty() {
        return Err(FlowError::Infeasible { cycles, work });
    }
    let few = || different_jumps(&network, &start, tolerance) <= FEW_SIZES;
    let first = options.method.unwrap_or_else(|| match few() {
        true => JumpMethod::PrimalDual,
        false => JumpMethod::NetworkSimplex,
    });
    let mut statistics = Statistics { method: first, pivots: 0, levels: 0, work };
    let mut found = None;
    if first == JumpMethod::PrimalDual {
        let patience = PATIENCE * (nodes + terms.len()) as u64;
        let limit =
            if options.method.is_none() { patience.min(options.work_limit) } else { options.work_limit };
        found = levels::solve(&network, start, tolerance, limit, &mut statistics);
    }
    if found.is_none() && options.method != Some(JumpMethod::PrimalDual) {
        statistics.method = JumpMethod::NetworkSimplex;
        found = simplex::solve(&network, tolerance, options.work_limit, &mut statistics)?;
    }
    let mut state = found.ok_or(FlowError::WorkLimit { work: options.work_limit })?;
    let arc_jumps = exact::purify(&network, &mut state, tolerance);

    let mut potentials = vec![0.0; nodes];
    for (v, p) in state.potentials.iter().enumerate() {
        potentials[network.callers[v] as usize] = *p;
    }
    // Terms that are not in the network: their flow has the sign of their jump.
    let mut jumps: Vec<f64> = terms.iter().map(|term| term.jump(&potentials)).collect();
    let mut flow: Vec<f64> = jumps
        .iter()
        .zip(&weights)
        .map(|(jump, w)| if jump.abs() > tolerance { jump.signum() * w } else { 0.0 })
        .collect();
    for (a, &e) in network.terms.iter().enumerate() {
        jumps[e as usize] = arc_jumps[a];
        flow[e as usize] = state.flow[a];
    }
    let certificate = certificate::certify(nodes, terms, &weights, &potentials, &flow);
    let c = &certificate;
    let worst = [c.conservation, c.overflow, c.violation].into_iter().fold(c.gap.abs(), f64::max);
    if c.gap.is_nan() || worst > ACCEPTED_GAP {
        return Err(FlowError::Uncertified { gap: c.gap, worst });
    }
    let objective: f64 = terms.iter().zip(&jumps).map(|(term, jump)| term.weight * jump.abs()).sum();
    Ok(JumpSolution {
        objective,
        // Above it by rounding only.
        lower_bound: certificate::lower_bound(terms, &flow, options.perturbation).min(objective),
        potentials,
        jumps,
        flow,
        certificate,
        statistics,
    })
}

/// Below this a jump is none. The forest takes all but the periods of the shifts away, so what
/// jumps at the start says how large jumps are; limits may be far larger, and count by their
/// rounding only.
fn tolerance(network: &Network, start: &[f64]) -> f64 {
    let jumps = network.arcs.iter().map(|arc| arc.jump(start).abs()).fold(0.0, f64::max);
    let numbers = start.iter().fold(network.scale, |m, p| m.max(p.abs()));
    (TOLERANCE * jumps).max(ROUNDING * numbers)
}

fn check(nodes: usize, terms: &[JumpTerm], options: &JumpOptions) -> Result<(), FlowError> {
    let perturbation = options.perturbation;
    if !(0.0..=0.1).contains(&perturbation) {
        return Err(FlowError::BadPerturbation { perturbation });
    }
    if nodes >= u32::MAX as usize || 2 * terms.len() >= u32::MAX as usize / 2 {
        return Err(FlowError::TooLarge { nodes, terms: terms.len() });
    }
    for (e, term) in terms.iter().enumerate() {
        for node in [term.from, term.to] {
            if node as usize >= nodes {
                return Err(FlowError::NoSuchNode { term: e, node, nodes });
            }
        }
        let limit = term.limit.unwrap_or(1.0);
        for (what, value) in [("shift", term.shift), ("weight", term.weight), ("limit", limit)] {
            if !value.is_finite() {
                return Err(FlowError::NonFinite { term: e, what });
            }
        }
        if term.weight < 0.0 {
            return Err(FlowError::NegativeWeight { term: e, weight: term.weight });
        }
        if limit <= 0.0 {
            return Err(FlowError::NonPositiveLimit { term: e, limit });
        }
    }
    Ok(())
}

/// Boxed terms that join a node to itself, so that their jump is their shift, and this is outside
/// of their limits.
fn contradicting_loops(terms: &[JumpTerm]) -> Vec<Contradiction> {
    let outside = |(e, term): (usize, &JumpTerm)| {
        let limit = term.limit.filter(|_| term.from == term.to)?;
        let excess = (-term.shift).max(term.shift - limit);
        (excess > 0.0).then(|| Contradiction { terms: vec![e], excess })
    };
    terms.iter().enumerate().filter_map(outside).collect()
}

/// How many different sizes the jumps have; stops counting at `FEW_SIZES + 1`.
fn different_jumps(network: &Network, potentials: &[f64], tolerance: f64) -> usize {
    let mut sizes: Vec<f64> = Vec::new();
    for arc in &network.arcs {
        let size = arc.jump(potentials).abs();
        if size <= tolerance {
            continue;
        }
        let at = sizes.partition_point(|s| *s < size - tolerance);
        if sizes.get(at).is_none_or(|s| *s > size + tolerance) {
            sizes.insert(at, size);
            if sizes.len() > FEW_SIZES {
                break;
            }
        }
    }
    sizes.len()
}

/// A number in [0, 1) that looks random (the finaliser of SplitMix64).
fn fraction(key: u64) -> f64 {
    let mut x = key.wrapping_add(0x9E37_79B9_7F4A_7C15);
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}
