//! Step 7: the cheapest closed jumps with the same harmonic part, which are what bounds nothing (eq. 11).

use crate::geometry::Triangle;
use crate::winding::error::WindingError;
use crate::winding::solution::ProgramReport;
use eikona_mesh::{Edge, TriangleMesh};
use eikona_numeric::{FlowError, JumpOptions, JumpTerm, minimise_jumps};
use std::collections::BTreeSet;

/// The nonbounding part of a curve.
#[derive(Debug)]
pub(crate) struct Nonbounding {
    /// The jump at each edge: first face minus second.
    pub jump: Vec<f64>,
    /// What is to be added to the values in each face.
    pub shift_of_face: Vec<f64>,
    pub report: ProgramReport,
    /// Edges of the curve where the jump could not be kept between nothing and the curve.
    pub freed: Vec<Edge>,
}

/// So many limits are raised; after that they are dropped at once.
const MOST_RAISED: usize = 1000;

/// Minimises the length of `shift + D sigma`, which costs `epsilon` times its length along the curve and must lie between nothing
/// and the curve there.
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
    // Where rings of faces hang together by edges of the curve alone, the limits of those edges can contradict each other. Deviation:
    // the paper says nothing of them; they are raised by what is missing, and dropped where that does not help.
    let mut raised: BTreeSet<usize> = BTreeSet::new();
    let solution = loop {
        match minimise_jumps(mesh.face_count(), &terms, &JumpOptions::default()) {
            Err(FlowError::Infeasible { terms: ring, excess })
                if ring.iter().any(|&i| terms[i].limit.is_some()) =>
            {
                let too_many = raised.len() > MOST_RAISED;
                for i in ring {
                    let again = !raised.insert(i) || too_many;
                    terms[i].limit =
                        terms[i].limit.filter(|_| !again).map(|limit| limit + 1.001 * excess + 1e-9);
                }
            }
            solved => break solved?,
        }
    };
    let mut jump = vec![0.0; mesh.edge_count()];
    for (&e, &t) in edges.iter().zip(&solution.jumps) {
        jump[e.index()] = if curve[e.index()] < 0 { -t } else { t };
    }
    Ok(Nonbounding {
        jump,
        shift_of_face: solution.potentials,
        report: ProgramReport {
            objective: solution.objective,
            certificate: solution.certificate,
            statistics: solution.statistics,
        },
        freed: raised.into_iter().map(|i| edges[i]).collect(),
    })
}

/// Keys that decide between loops of the same length: from where an edge lies in the box of the mesh, so that numbering, scale
/// and place of the mesh do not matter.
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
