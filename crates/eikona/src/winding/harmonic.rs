//! Steps 3 to 6: the derivative of the jump function, its harmonic part, and that integrated face by face.

use crate::winding::weights::Weights;
use eikona_mesh::{Face, Halfedge, Orientation, TriangleMesh};
use eikona_numeric::{
    Cholesky, Graph, NumericError, Ordering, Symbolic, SymmetricMatrix, nested_dissection_order,
};

/// The Darboux derivative (section 2.4.2) along each halfedge: the difference of a jump function inside the face, which is the
/// same in all faces of an edge; zero at edges with an end where it is not defined.
pub(crate) fn darboux_derivative(mesh: &TriangleMesh, values: &[f64]) -> Vec<f64> {
    let mut form = vec![0.0; mesh.halfedge_count()];
    for e in mesh.edges() {
        let halfedges = mesh.edge_halfedges(e);
        // Once an edge, so that both faces get the same digits.
        let along = difference(values, halfedges[0]);
        if along.is_nan() {
            continue;
        }
        for &h in halfedges {
            let same = mesh.follows_edge(h) == mesh.follows_edge(halfedges[0]);
            form[h.index()] = if same { along } else { -along };
        }
    }
    form
}

fn difference(values: &[f64], h: Halfedge) -> f64 {
    values[tip_corner(h)] - values[h.index()]
}

/// The corner of a halfedge's face at its tip. (That at its origin has the halfedge's own index.)
pub(crate) fn tip_corner(h: Halfedge) -> usize {
    3 * h.face().index() + (h.index() + 1) % 3
}

/// The Hodge system on faces, `d1 *1^-1 d1^T`.
#[derive(Debug)]
pub(crate) struct Hodge {
    factor: Cholesky<f64>,
    /// 1 over the star of each halfedge's edge.
    inverse_star: Vec<f64>,
}

impl Hodge {
    /// The surface is cut open along edges of three or more faces. Closed orientable patches have the constants as kernel: their
    /// first face is held at zero.
    pub fn new(mesh: &TriangleMesh, weights: &Weights) -> Result<Hodge, NumericError> {
        let halfedges = || mesh.faces().flat_map(|f| [0, 1, 2].map(|k| f.halfedge(k)));
        let inverse_star: Vec<f64> = halfedges().map(|h| 1.0 / weights.star(mesh, h)).collect();
        let mut graph = Graph { unknowns: mesh.face_count(), pairs: Vec::new() };
        let mut matrix = SymmetricMatrix { diagonal: vec![0.0; mesh.face_count()], off_diagonal: Vec::new() };
        for h in halfedges() {
            matrix.diagonal[h.face().index()] += inverse_star[h.index()];
        }
        for e in mesh.edges() {
            let &[a, b] = mesh.edge_halfedges(e) else { continue };
            if a.face() == b.face() {
                continue;
            }
            let same = mesh.follows_edge(a) == mesh.follows_edge(b);
            graph.pairs.push([a.face().index() as u32, b.face().index() as u32]);
            matrix.off_diagonal.push(if same { inverse_star[a.index()] } else { -inverse_star[a.index()] });
        }
        for first in closed_patches(mesh) {
            matrix.diagonal[first.index()] *= 2.0;
        }
        let centres: Vec<[f64; 3]> = mesh
            .faces()
            .map(|f| {
                let [a, b, c] = mesh.face_positions(f);
                [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0)
            })
            .collect();
        let order = nested_dissection_order(&graph, &centres)?;
        let symbolic = Symbolic::new(&graph, Ordering::Given(&order))?;
        Ok(Hodge { factor: Cholesky::new(symbolic.into(), &matrix)?, inverse_star })
    }

    /// The harmonic part (section 3.3) of a co-closed form along halfedges, with the relative residual of the solve.
    pub fn harmonic_part(&self, mesh: &TriangleMesh, form: &[f64]) -> Result<(Vec<f64>, f64), NumericError> {
        let curl: Vec<f64> = form.chunks_exact(3).map(|sides| sides.iter().sum()).collect();
        let potential = self.factor.solve(&curl)?;
        let residual = self.factor.residual(&potential, &curl);
        let mut harmonic = form.to_vec();
        for e in mesh.edges() {
            let halfedges = mesh.edge_halfedges(e);
            let sum_along_first: f64 = match halfedges {
                &[a, b] => {
                    let same = mesh.follows_edge(a) == mesh.follows_edge(b);
                    let other = potential[b.face().index()];
                    potential[a.face().index()] + if same { other } else { -other }
                }
                _ => 0.0,
            };
            for &h in halfedges {
                let sum = if halfedges.len() != 2 {
                    potential[h.face().index()]
                } else if mesh.follows_edge(h) == mesh.follows_edge(halfedges[0]) {
                    sum_along_first
                } else {
                    -sum_along_first
                };
                harmonic[h.index()] -= self.inverse_star[h.index()] * sum;
            }
        }
        Ok((harmonic, residual))
    }
}

/// The first face of each patch that is closed and orientable.
fn closed_patches(mesh: &TriangleMesh) -> Vec<Face> {
    let orientation = Orientation::of(mesh);
    let mut closed: Vec<bool> = orientation.patches.iter().map(|p| p.is_orientable()).collect();
    for e in mesh.edges() {
        if let halfedges @ ([_] | [_, _, _, ..]) = mesh.edge_halfedges(e) {
            for h in halfedges {
                closed[orientation.patch_of_face[h.face()] as usize] = false;
            }
        }
    }
    orientation.patches.iter().zip(closed).filter(|(_, closed)| *closed).map(|(p, _)| p.first_face).collect()
}

/// A form without curl as values at the corners of each face, zero at the first.
pub(crate) fn integrated_in_faces(form: &[f64]) -> Vec<f64> {
    form.chunks_exact(3).flat_map(|sides| [0.0, sides[0], sides[0] + sides[1]]).collect()
}

/// For each edge of two faces the value in the first face minus that in the second, at the origin of the first halfedge; 0 at
/// other edges.
pub(crate) fn jumps_of(mesh: &TriangleMesh, values: &[f64]) -> Vec<f64> {
    mesh.edges()
        .map(|e| match mesh.edge_halfedges(e) {
            &[a, b] => {
                let other = if mesh.origin(b) == mesh.origin(a) { b.index() } else { tip_corner(b) };
                values[a.index()] - values[other]
            }
            _ => 0.0,
        })
        .collect()
}
