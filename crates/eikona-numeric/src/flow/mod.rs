//! Weighted L1 fitting of jumps on a graph, the dual of minimum-cost flow.
//!
//! A [`JumpTerm`] compares the potentials of two nodes: it has the jump `shift + p[from] - p[to]`
//! and costs `weight * |jump|`. A *boxed* term has a limit: its jump must lie in `[0, limit]`. The
//! dual variable of a jump is the flow along its term. At the optimum the flow is a circulation,
//! jumps occur only where the flow is at its bound, and primal and dual objective agree, which the
//! [`Certificate`] checks.
//!
//! The steps are `network` (drops irrelevant terms, builds a spanning forest, renumbers nodes) ->
//! `boxes` (feasibility of the limits) -> `simplex` (with `tree`) or `levels` (with `maximum_flow`)
//! -> `exact` (snaps jumps to 0 and to limits) -> `certificate`.

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
pub use error::{InfeasibleCycle, JumpError};

use crate::observer::check_stopped;
use network::Network;

/// Term of the objective: `weight * |jump|` with the jump `shift + p[from] - p[to]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JumpTerm {
    /// Node whose potential raises the jump.
    pub from: u32,
    /// Node whose potential lowers the jump. If it equals `from`, the jump is always `shift`.
    pub to: u32,
    /// Jump at equal potentials.
    pub shift: f64,
    /// Cost of a jump of 1; at least 0.
    pub weight: f64,
    /// `Some(limit)` constrains the jump to `[0, limit]`; `limit` must be positive.
    pub limit: Option<f64>,
    /// Seed of the weight's perturbation. Equal keys give equal perturbations; keys derived from
    /// the geometry instead of the numbering make the solution independent of the numbering.
    pub key: u64,
}

impl JumpTerm {
    /// Returns the jump for given potentials.
    #[inline]
    pub fn jump(&self, potentials: &[f64]) -> f64 {
        self.shift + potentials[self.from as usize] - potentials[self.to as usize]
    }
}

/// Options of [`minimise_jumps`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JumpOptions {
    /// Relative perturbation of the weights, to break ties deterministically: each weight is
    /// multiplied by `1 + perturbation * r`, where `r` in `[0, 1)` is a hash of the term's key. At
    /// most 0.1; 0 leaves the weights alone.
    pub perturbation: f64,
    /// Solution method; `None` selects it automatically.
    pub method: Option<JumpMethod>,
    /// Largest number of steps (nodes and terms visited); 2 to 9 times 10^7 take a second.
    pub work_limit: u64,
}

impl Default for JumpOptions {
    fn default() -> Self {
        JumpOptions { perturbation: 1e-4, method: None, work_limit: 100_000_000_000 }
    }
}

/// Minimum-cost flow method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JumpMethod {
    /// Network simplex: exchanges one arc of a spanning-tree basis per pivot. For shifts with many
    /// distinct values.
    NetworkSimplex,
    /// Primal-dual: one maximum flow per level of jumps. For shifts with few distinct values.
    PrimalDual,
}

/// Optimal potentials, and the flow that certifies them.
#[derive(Clone, Debug, PartialEq)]
pub struct JumpSolution {
    /// One potential per node; 0 at the first node of each component.
    pub potentials: Vec<f64>,
    /// One jump per term. Jumps at 0 or at their limit are exact, and if all shifts and limits are
    /// integers, so are the jumps.
    pub jumps: Vec<f64>,
    /// Flow along each term from `from` to `to`.
    pub flow: Vec<f64>,
    /// Cost of the jumps with the unperturbed weights.
    pub objective: f64,
    /// Lower bound on the optimal cost with the unperturbed weights. `objective` exceeds it by at
    /// most `perturbation` times `objective`, plus rounding.
    pub lower_bound: f64,
    /// Certificate for the perturbed weights, which are those of the problem solved.
    pub certificate: Certificate,
    /// Method and effort.
    pub statistics: JumpStatistics,
}

/// Method and effort of one solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JumpStatistics {
    /// Method that found the solution.
    pub method: JumpMethod,
    /// Pivots of the network simplex.
    pub pivots: u64,
    /// Levels of the primal-dual method.
    pub levels: u64,
    /// Steps taken (nodes and terms visited).
    pub work: u64,
}
use JumpStatistics as Statistics;

/// Potentials and flow in a network's numbering.
struct State {
    potentials: Vec<f64>,
    flow: Vec<f64>,
}

/// Jumps below this, relative to the largest jump of the starting potentials, count as zero at
/// first.
const TOLERANCE: f64 = 1e-9;
/// Relative rounding error of shifts, limits and potentials.
const ROUNDING: f64 = 1e-12;
/// Largest number of distinct jump sizes for which the primal-dual method is tried first.
const FEW_SIZES: usize = 64;
/// Steps per node and term after which the network simplex takes over from the primal-dual method.
/// Broken curves need about 100, noise with 160 levels 6000; the network simplex needs 1500 for
/// noise on 25,000 cells.
const PATIENCE: u64 = 2000;

/// Computes potentials that minimise the total cost `sum of weight * |jump|` subject to the limits
/// of boxed terms, with a certificate of optimality.
///
/// `terms` may repeat and may join a node to itself; the graph may have any number of components. A
/// free term of weight 0 has no effect.
///
/// # Which method
/// Unless `options.method` is set: the primal-dual method if the jumps of the starting potentials
/// have at most 64 distinct sizes, else the network simplex. If the former needs more than 2000
/// steps per node and term, the latter takes over. The rule counts steps instead of time, so the
/// same input always uses the same method.
///
/// The starting potentials jump on boxed terms and straight across the gaps between them, so the
/// jump sizes are the periods of the curves: few on a surface of small genus (4 to 11 levels were
/// needed), as many as terms if every shift is noisy.
///
/// # Accuracy
/// Jumps below a billionth of the largest starting jump first count as zero, so that rounding
/// errors of the shifts add no levels or pivots. Where the optimum is so small that these jumps
/// keep it from being certified, the problem is solved once more without any tolerance. Shifts and
/// limits are then rounded at about 2^-50 of the largest number, which makes all potentials exact.
///
/// # Errors
/// A [`JumpError`] that names the term: indices out of range, numbers that are not finite, negative
/// weights, limits that are not positive. [`JumpError::Infeasible`] with cycles of terms whose
/// limits contradict each other. [`JumpError::WorkLimit`] if `options.work_limit` is too small.
/// [`JumpError::Uncertified`] if the solution fails its optimality check.
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
/// The linear program is that of Feng, Gillespie and Crane, *Winding Numbers on Discrete Surfaces*
/// (2023), eq. 11. Network simplex: Cunningham, *A network simplex method* (1976). Primal-dual:
/// Ford and Fulkerson, *Flows in Networks* (1962), ch. III. Duality: Rockafellar, *Network Flows
/// and Monotropic Optimization* (1984).
///
/// # Example
/// ```
/// use eikona_numeric::{JumpOptions, JumpTerm, minimise_jumps};
/// // A cycle of three nodes whose shifts add up to 1. The cheapest term jumps by its limit, 0.25.
/// let term = |from, to, shift, weight, limit| {
///     JumpTerm { from, to, shift, weight, limit, key: from as u64 }
/// };
/// let terms =
///     [term(0, 1, 1.0, 3.0, None), term(1, 2, 0.0, 1.0, Some(0.25)), term(2, 0, 0.0, 2.0, None)];
/// let solution = minimise_jumps(3, &terms, &JumpOptions::default())?;
/// assert_eq!(solution.jumps, [0.0, 0.25, 0.75]);
/// assert_eq!(solution.objective, 0.25 * 1.0 + 0.75 * 2.0);
/// assert!(solution.certificate.gap.abs() < 1e-9);
/// # Ok::<(), eikona_numeric::JumpError>(())
/// ```
pub fn minimise_jumps(
    nodes: usize,
    terms: &[JumpTerm],
    options: &JumpOptions,
) -> Result<JumpSolution, JumpError> {
    check(nodes, terms, options)?;
    check_stopped()?;
    let perturb = |term: &JumpTerm| term.weight * (1.0 + options.perturbation * fraction(term.key));
    let weights: Vec<f64> = terms.iter().map(perturb).collect();
    check_stopped()?;
    let network = Network::new(nodes, terms, &weights)?;
    let mut start = network.forest_potentials();
    check_stopped()?;
    let tolerance = tolerance(&network, &start);
    let mut work = 0;
    let mut cycles = infeasible_loops(terms);
    cycles.extend(boxes::enforce_limits(
        &network,
        &mut start,
        1e-3 * tolerance,
        options.work_limit,
        &mut work,
    )?);
    if !cycles.is_empty() {
        return Err(JumpError::Infeasible { cycles, work });
    }
    let mut program = Program { nodes, terms, weights, network, start, options };
    let mut statistics = Statistics { method: JumpMethod::PrimalDual, pivots: 0, levels: 0, work };
    let solution = program.solve(tolerance, &mut statistics)?;
    if solution.certificate.is_accepted() {
        return Ok(solution);
    }
    // The jumps that counted as zero matter, because the optimum is small. With rounded shifts
    // potentials are exact and no jump needs to count as zero. A free term adds at most its weight
    // times the rounding unit, some 1e-15 of the numbers, to the gap; 1e-12 is accepted.
    program.network.round(&mut program.start);
    let solution = program.solve(0.0, &mut statistics)?;
    match solution.certificate.is_accepted() {
        true => Ok(solution),
        false => {
            Err(JumpError::Uncertified { gap: solution.certificate.gap, worst: solution.certificate.worst() })
        }
    }
}

/// A feasible problem, ready to be solved.
struct Program<'a> {
    nodes: usize,
    terms: &'a [JumpTerm],
    /// The perturbed weights.
    weights: Vec<f64>,
    network: Network,
    /// Potentials that satisfy all limits, in the network's numbering.
    start: Vec<f64>,
    options: &'a JumpOptions,
}

impl Program<'_> {
    /// Solves with the method selected by the options, or by the rule of [`minimise_jumps`]. Jumps
    /// up to `tolerance` count as zero. The certificate is yet to be checked.
    fn solve(&self, tolerance: f64, statistics: &mut Statistics) -> Result<JumpSolution, JumpError> {
        let Program { nodes, terms, weights, network, start, options } = self;
        let few = || distinct_jump_sizes(network, start, tolerance) <= FEW_SIZES;
        statistics.method = options.method.unwrap_or_else(|| match few() {
            true => JumpMethod::PrimalDual,
            false => JumpMethod::NetworkSimplex,
        });
        check_stopped()?;
        let mut found = None;
        if statistics.method == JumpMethod::PrimalDual {
            let patience = statistics.work + PATIENCE * (nodes + terms.len()) as u64;
            let limit =
                if options.method.is_none() { patience.min(options.work_limit) } else { options.work_limit };
            found = levels::solve(network, start.clone(), tolerance, limit, statistics)?;
        }
        if found.is_none() && options.method != Some(JumpMethod::PrimalDual) {
            statistics.method = JumpMethod::NetworkSimplex;
            found = simplex::solve(network, tolerance, options.work_limit, statistics)?;
        }
        let mut state = found.ok_or(JumpError::WorkLimit { work: options.work_limit })?;
        check_stopped()?;
        let arc_jumps = exact::snap_jumps(network, &mut state, tolerance)?;
        check_stopped()?;

        let mut potentials = vec![0.0; *nodes];
        for (v, p) in state.potentials.iter().enumerate() {
            potentials[network.callers[v] as usize] = *p;
        }
        // Terms outside the network: their flow has the sign of their jump.
        let mut jumps: Vec<f64> = terms.iter().map(|term| term.jump(&potentials)).collect();
        let mut flow: Vec<f64> = jumps
            .iter()
            .zip(weights)
            .map(|(jump, w)| if jump.abs() > tolerance { jump.signum() * w } else { 0.0 })
            .collect();
        for (a, &e) in network.terms.iter().enumerate() {
            jumps[e as usize] = arc_jumps[a].min(terms[e as usize].limit.unwrap_or(f64::INFINITY));
            flow[e as usize] = state.flow[a];
        }
        check_stopped()?;
        let objective: f64 = terms.iter().zip(&jumps).map(|(term, jump)| term.weight * jump.abs()).sum();
        Ok(JumpSolution {
            objective,
            // It exceeds the objective by rounding only.
            lower_bound: certificate::lower_bound(terms, &flow, options.perturbation).min(objective),
            certificate: certificate::certify(*nodes, terms, weights, &potentials, &flow),
            potentials,
            jumps,
            flow,
            statistics: *statistics,
        })
    }
}

/// Returns the size below which a jump counts as zero. The forest removes all but the periods of
/// the shifts, so the jumps of the starting potentials set the scale. Limits may be far larger and
/// contribute by their rounding only.
fn tolerance(network: &Network, start: &[f64]) -> f64 {
    let jumps = network.arcs.iter().map(|arc| arc.jump(start).abs()).fold(0.0, f64::max);
    (TOLERANCE * jumps).max(ROUNDING * network.largest_number(start))
}

fn check(nodes: usize, terms: &[JumpTerm], options: &JumpOptions) -> Result<(), JumpError> {
    let perturbation = options.perturbation;
    if !(0.0..=0.1).contains(&perturbation) {
        return Err(JumpError::BadPerturbation { perturbation });
    }
    if nodes >= u32::MAX as usize || 2 * terms.len() >= u32::MAX as usize / 2 {
        return Err(JumpError::TooLarge { nodes, terms: terms.len() });
    }
    for (e, term) in terms.iter().enumerate() {
        for node in [term.from, term.to] {
            if node as usize >= nodes {
                return Err(JumpError::NoSuchNode { term: e, node, nodes });
            }
        }
        let limit = term.limit.unwrap_or(1.0);
        for (what, value) in [("shift", term.shift), ("weight", term.weight), ("limit", limit)] {
            if !value.is_finite() {
                return Err(JumpError::NonFinite { term: e, what });
            }
        }
        if term.weight < 0.0 {
            return Err(JumpError::NegativeWeight { term: e, weight: term.weight });
        }
        if limit <= 0.0 {
            return Err(JumpError::NonPositiveLimit { term: e, limit });
        }
    }
    Ok(())
}

/// Boxed terms that join a node to itself and whose jump, which is their shift, is outside their
/// limits.
fn infeasible_loops(terms: &[JumpTerm]) -> Vec<InfeasibleCycle> {
    let outside = |(e, term): (usize, &JumpTerm)| {
        let limit = term.limit.filter(|_| term.from == term.to)?;
        let excess = (-term.shift).max(term.shift - limit);
        (excess > 0.0).then(|| InfeasibleCycle { terms: vec![e], excess })
    };
    terms.iter().enumerate().filter_map(outside).collect()
}

/// Number of distinct sizes of the jumps; stops counting at `FEW_SIZES + 1`.
fn distinct_jump_sizes(network: &Network, potentials: &[f64], tolerance: f64) -> usize {
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

/// Pseudorandom number in [0, 1) (the finaliser of SplitMix64).
fn fraction(key: u64) -> f64 {
    let mut x = key.wrapping_add(0x9E37_79B9_7F4A_7C15);
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}
