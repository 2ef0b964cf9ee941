//! Step 7: the nonbounding part, the cheapest closed jumps with the same harmonic part (eq. 11).

use crate::geometry::Triangle;
use crate::winding::error::WindingError;
use crate::winding::solution::ProgramReport;
use eikona_mesh::{Edge, TriangleMesh, UnionFind};
use eikona_numeric::{
    InfeasibleCycle, JumpError, JumpOptions, JumpSolution, JumpTerm, check_step, check_stopped,
    minimise_jumps,
};
use std::collections::BTreeSet;

/// The nonbounding part of a curve.
#[derive(Debug)]
pub(crate) struct Nonbounding {
    /// The jump at each edge: first face minus second.
    pub jump: Vec<f64>,
    /// The constant to add to the values in each face.
    pub shift_of_face: Vec<f64>,
    pub report: ProgramReport,
    /// Edges of the curve where the jump could not be kept between zero and the curve's.
    pub relaxed: Vec<Edge>,
}

/// Minimises the length of `shift + D sigma`. Along the curve it costs `epsilon` times its length
/// and must lie between zero and the curve.
///
/// Deviation from eq. 11: edge lengths are increased by up to 1e-4, depending on the edge's key, to
/// break ties between shortest loops deterministically (the paper leaves that to the solver). The
/// report has the cost for true lengths and a lower bound of it.
pub(crate) fn nonbounding_part(
    mesh: &TriangleMesh,
    triangles: &[Triangle],
    curve: &[i32],
    shift: &[f64],
    epsilon: f64,
) -> Result<Nonbounding, WindingError> {
    let keys = Keys::of(mesh);
    let mut edges = Vec::new();
    let mut terms = Vec::new();
    for e in mesh.edges() {
        check_step(e.index())?;
        let &[a, b] = mesh.edge_halfedges(e) else { continue };
        let (from, to) = (a.face().index() as u32, b.face().index() as u32);
        let length = triangles[a.face().index()].lengths[a.index() % 3];
        let (copies, shift, key) = (curve[e.index()], shift[e.index()], keys.of_edge(mesh, e));
        edges.push(e);
        terms.push(match copies {
            0 => JumpTerm { from, to, shift, weight: length, limit: None, key },
            1.. => {
                JumpTerm { from, to, shift, weight: epsilon * length, limit: Some(f64::from(copies)), key }
            }
            _ => JumpTerm {
                from: to,
                to: from,
                shift: -shift,
                weight: epsilon * length,
                limit: Some(-f64::from(copies)),
                key,
            },
        });
    }
    let (solution, attempts, relaxed) = minimise_with_limits(mesh.face_count(), &mut terms, MAX_REPAIRS)
        .map_err(|fault| WindingError::of_program(fault, mesh, &edges))?;
    check_stopped()?;
    let mut jump = vec![0.0; mesh.edge_count()];
    for (&e, &t) in edges.iter().zip(&solution.jumps) {
        jump[e.index()] = if curve[e.index()] < 0 { -t } else { t };
    }
    Ok(Nonbounding {
        jump,
        shift_of_face: solution.potentials,
        report: ProgramReport {
            objective: solution.objective,
            lower_bound: solution.lower_bound,
            certificate: solution.certificate,
            statistics: solution.statistics,
            attempts,
            relaxed: relaxed.len(),
        },
        relaxed: relaxed.into_iter().map(|i| edges[i]).collect(),
    })
}

/// Rounds of raising contradictory limits before dropping them for whole components. Adjacent rings
/// take 3 attempts; 10 000 faces with limits on all edges take up to 70.
const MAX_REPAIRS: usize = 50;

/// Minimises jumps, relaxes infeasible limits, and returns the number of attempts and the relaxed
/// terms.
///
/// Where edges of the curve are the only edges connecting a ring of faces, their limits can
/// contradict each other. Deviation: the paper does not treat this case. Such limits are raised by
/// the infeasibility, and dropped where that does not help; if infeasible_cycles remain, all limits
/// are dropped in the components joined by edges with limits.
fn minimise_with_limits(
    faces: usize,
    terms: &mut [JumpTerm],
    most_repairs: usize,
) -> Result<(JumpSolution, usize, BTreeSet<usize>), JumpError> {
    let options = JumpOptions { work_limit: work_limit(faces, terms.len()), ..JumpOptions::default() };
    let mut relaxed = BTreeSet::new();
    let mut work_before = 0;
    let mut attempts = 0;
    loop {
        attempts += 1;
        match minimise_jumps(faces, terms, &options) {
            Ok(mut solution) => {
                solution.statistics.work += work_before;
                return Ok((solution, attempts, relaxed));
            }
            Err(JumpError::Infeasible { cycles, work }) if attempts <= most_repairs + 2 => {
                work_before += work;
                if attempts <= most_repairs {
                    raise_limits(terms, &cycles, &mut relaxed);
                } else {
                    // Contradictions from rounding may show up later: then drop all limits.
                    let everything = attempts > most_repairs + 1;
                    drop_limits(faces, terms, &cycles, everything, &mut relaxed);
                }
            }
            Err(fault) => return Err(fault),
        }
    }
}

/// Returns the step limit, proportional to faces and edges. Broken curves on half a million faces
/// need 120 steps per face or edge; the network simplex alone would need 33 000 on 200 000 faces,
/// three minutes.
fn work_limit(faces: usize, terms: usize) -> u64 {
    50_000 * (1 + faces + terms) as u64
}

/// Raises the limits of cycles by their infeasibility; drops those already raised.
fn raise_limits(terms: &mut [JumpTerm], cycles: &[InfeasibleCycle], relaxed: &mut BTreeSet<usize>) {
    for InfeasibleCycle { terms: cycle, excess } in cycles {
        for &i in cycle {
            let first_time = relaxed.insert(i);
            terms[i].limit = terms[i].limit.filter(|_| first_time).map(|limit| limit + 1.001 * excess + 1e-9);
        }
    }
}

/// Drops all limits in the components of the cycles, joined by edges with limits, or everywhere.
fn drop_limits(
    faces: usize,
    terms: &mut [JumpTerm],
    cycles: &[InfeasibleCycle],
    everything: bool,
    relaxed: &mut BTreeSet<usize>,
) {
    let mut parts = UnionFind::new(faces);
    terms.iter().filter(|term| term.limit.is_some()).for_each(|term| parts.join(term.from, term.to));
    let mut concerned = vec![everything; faces];
    for &i in cycles.iter().flat_map(|cycle| &cycle.terms) {
        concerned[parts.find(terms[i].from) as usize] = true;
    }
    for (i, term) in terms.iter_mut().enumerate().filter(|(_, term)| term.limit.is_some()) {
        if concerned[parts.find(term.from) as usize] {
            term.limit = None;
            relaxed.insert(i);
        }
    }
}

/// Keys that break ties between loops of equal length. They depend on where an edge lies in the
/// mesh's bounding box, so that numbering, scale and position of the mesh do not matter.
struct Keys {
    centre: [f64; 3],
    scale: f64,
}

impl Keys {
    fn of(mesh: &TriangleMesh) -> Keys {
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        for p in mesh.positions() {
            for k in 0..3 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        let size = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
        let centre = [0, 1, 2].map(|k| low[k] + 0.5 * (high[k] - low[k]));
        Keys { centre, scale: if size > 0.0 { 1e6 / size } else { 0.0 } }
    }

    fn of_edge(&self, mesh: &TriangleMesh, e: Edge) -> u64 {
        let [a, b] = mesh.edge_vertices(e).map(|v| mesh.position(v));
        (0..3).fold(0, |key, k| {
            let middle = 0.5 * (a[k] - self.centre[k]) + 0.5 * (b[k] - self.centre[k]);
            let cell = (middle * self.scale).round() as i64 as u64;
            (key ^ cell).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(23)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rings of three terms with limits; the second of each pair of rings is infeasible. Terms
    /// without limits connect the pairs, terms with limits the rings of a pair.
    fn pairs_of_rings(pairs: u32) -> (usize, Vec<JumpTerm>) {
        let mut terms = Vec::new();
        let mut add = |from, to, shift, limit| {
            let key = terms.len() as u64;
            terms.push(JumpTerm { from, to, shift, weight: 1.0, limit, key });
        };
        for ring in 0..2 * pairs {
            let at = |k: u32| 3 * ring + k % 3;
            let shift = if ring % 4 == 1 { 5.0 } else { 0.0 };
            add(at(0), at(1), shift, Some(1.0));
            add(at(1), at(2), 0.0, Some(1.0));
            add(at(2), at(0), 0.0, Some(1.0));
            add(at(2), at(0) + 3, 0.0, (ring % 2 == 0).then_some(1.0));
        }
        terms.last_mut().unwrap().to = 0;
        (6 * pairs as usize, terms)
    }

    #[test]
    fn limits_are_raised_and_finally_dropped_in_the_affected_components() {
        let (faces, terms) = pairs_of_rings(6);
        let mut raised = terms.clone();
        let (solution, attempts, relaxed) = minimise_with_limits(faces, &mut raised, MAX_REPAIRS).unwrap();
        assert_eq!((attempts, relaxed.len()), (2, 3 * 3));
        // Three rings jump by 5.
        assert!((solution.objective - 3.0 * 5.0).abs() < 1e-9);
        for (i, (before, after)) in terms.iter().zip(&raised).enumerate() {
            assert_eq!(before.limit != after.limit, relaxed.contains(&i));
            assert_eq!(before.limit.is_some(), after.limit.is_some());
        }
        // Both rings of every second pair, and the terms connecting them.
        let mut dropped = terms.clone();
        let (solution, attempts, relaxed) = minimise_with_limits(faces, &mut dropped, 0).unwrap();
        assert_eq!((attempts, relaxed.len()), (2, 3 * 7));
        assert!((solution.objective - 3.0 * 5.0).abs() < 1e-9);
        assert!(dropped.iter().enumerate().all(|(i, term)| term.limit.is_none() || !relaxed.contains(&i)));
        let free = |terms: &[JumpTerm]| terms.iter().filter(|term| term.limit.is_none()).count();
        assert_eq!(free(&dropped), free(&terms) + 3 * 7);
        let mut relaxed = BTreeSet::new();
        let mut all = terms;
        drop_limits(faces, &mut all, &[], true, &mut relaxed);
        assert_eq!(free(&all), all.len());
    }

    #[test]
    fn the_work_counts_all_attempts() {
        let (faces, mut terms) = pairs_of_rings(6);
        let first = minimise_jumps(faces, &terms, &JumpOptions::default()).unwrap_err();
        let JumpError::Infeasible { work: before, .. } = first else { panic!("{first}") };
        let (solution, ..) = minimise_with_limits(faces, &mut terms, MAX_REPAIRS).unwrap();
        let last = minimise_jumps(faces, &terms, &JumpOptions::default()).unwrap();
        assert_eq!(solution.statistics.work, before + last.statistics.work);
    }

    /// Ten times what the largest instances of `eikona-numeric/examples/jumps.rs` with curves need,
    /// and less than an hour at 2 10^7 steps a second.
    #[test]
    fn the_work_limit_is_proportional_to_the_mesh() {
        let limit = work_limit(500_800, 751_200);
        assert!(limit > 10 * 151_000_000 && limit < 3600 * 20_000_000);
        assert!(work_limit(200_000, 300_000) > 16_400_000_000);
        assert!(work_limit(0, 0) > 0);
    }
}
