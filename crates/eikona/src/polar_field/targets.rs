//! What a rotation should be next to a singularity: that of a linear field around the singular
//! point, stretched to the prescribed index (PLPF appendix B.1).

use crate::geometry::Triangle;
use crate::polar_field::bevel::{BeveledMesh, Cycle, Rotation};
use crate::polar_field::singularity::Prescribed;
use crate::polar_field::smoothness::Target;
use crate::polar_field::terms::Term;
use eikona_mesh::{Face, Halfedge, Located, Vertex};
use eikona_numeric::Complex;
use std::f64::consts::{PI, TAU};

/// Returns the targets of all singularities. `needed` is the sum of the rotation around each vertex
/// cycle.
pub(crate) fn targets(
    bevel: &BeveledMesh,
    singularities: &[Prescribed],
    needed: impl Fn(Vertex) -> f64,
) -> Vec<Target> {
    let mut targets = Vec::new();
    let mut local = bevel.zero();
    for s in singularities.iter().filter(|s| s.turns != 0) {
        let index = s.turns as f64;
        let terms = match (s.cycle, s.point) {
            (Cycle::Face(f), Some(Located::Face(_, weights))) => {
                around_face(bevel, f, weights, index, &mut local)
            }
            (Cycle::Edge(e), Some(Located::Edge(_, t))) => {
                let h = bevel.mesh.edge_halfedges(e)[0];
                let t = if bevel.mesh.follows_edge(h) { t } else { 1.0 - t };
                around_edge(bevel, h, t, index, &mut local)
            }
            (Cycle::Vertex(v), _) => around_vertex(bevel, v, needed(v), &mut local),
            _ => continue,
        };
        for &term in &terms {
            targets.push(Target { term, values: bevel.term(term, &local) });
        }
        // Only what was written is cleared.
        for term in terms {
            clear(bevel, term, &mut local);
        }
    }
    targets
}

fn clear(bevel: &BeveledMesh, term: Term, local: &mut Rotation) {
    match term {
        Term::Face(f) => (0..3).for_each(|k| local.split[f.halfedge(k)] = 0.0),
        Term::Edge(h) => {
            local.jump[h] = 0.0;
            if let Some(twin) = bevel.twin[h] {
                local.jump[twin] = 0.0;
            }
        }
        Term::Flap(_) | Term::Side(_) | Term::Jump(_) => {}
    }
}

/// Angle under which a point sees each side of a triangle.
fn seen_angles(triangle: &Triangle, point: Complex) -> [f64; 3] {
    let from = triangle.corners().map(|z| z - point);
    [0, 1, 2].map(|k| (from[(k + 1) % 3] * from[k].conj()).arg())
}

fn around_face(
    bevel: &BeveledMesh,
    face: Face,
    weights: [f64; 3],
    index: f64,
    local: &mut Rotation,
) -> Vec<Term> {
    let triangle = &bevel.triangles[face.index()];
    let angles = seen_angles(triangle, triangle.point(weights));
    (0..3).for_each(|k| local.split[face.halfedge(k)] = index * angles[k]);
    vec![Term::Face(face)]
}

/// `t` is the place along `h`.
fn around_edge(bevel: &BeveledMesh, h: Halfedge, t: f64, index: f64, local: &mut Rotation) -> Vec<Term> {
    let mut terms = vec![Term::Edge(h)];
    for (h, t) in [(Some(h), t), (bevel.twin[h], 1.0 - t)] {
        let Some(h) = h else { continue };
        let mut weights = [0.0; 3];
        weights[h.side()] = 1.0 - t;
        weights[(h.side() + 1) % 3] = t;
        let triangle = &bevel.triangles[h.face().index()];
        let angles = seen_angles(triangle, triangle.point(weights));
        local.split[h.next()] = index * angles[h.next().side()];
        local.split[h.previous()] = index * angles[h.previous().side()];
        local.split[h] = -PI * index;
        terms.push(Term::Face(h.face()));
    }
    terms
}

/// Spreads the sum over the corners in proportion to their angles.
fn around_vertex(bevel: &BeveledMesh, v: Vertex, sum: f64, local: &mut Rotation) -> Vec<Term> {
    let corners: Vec<Halfedge> = bevel.mesh.vertex_corners(v).iter().map(|c| c.halfedge()).collect();
    let total: f64 = corners.iter().map(|&c| bevel.angle(c)).sum();
    let mut terms = Vec::with_capacity(2 * corners.len());
    for &c in &corners {
        let share = bevel.angle(c) / total * sum;
        local.split[c.next()] = share;
        local.split[c] = -0.5 * share;
        local.split[c.previous()] = -0.5 * share;
        terms.push(Term::Face(c.face()));
        if let Some(twin) = bevel.twin[c] {
            // The corner on the other side of the spoke.
            let other = bevel.angle(twin.next());
            local.jump[c] = 0.5 * (bevel.angle(c) + other) / total * sum;
            terms.push(Term::Edge(c));
        }
    }
    terms
}

/// Returns the turns that a vertex needs: the prescribed ones less N times its curvature.
pub(crate) fn needed_sum(turns: i64, degree: u32, curvature: f64) -> f64 {
    TAU * turns as f64 - f64::from(degree) * curvature
}
