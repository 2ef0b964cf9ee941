//! Edge operators of step I: Crouzeix-Raviart mass matrix (SHM eq. 7) and connection Laplacian (eq.
//! 9).

use crate::geometry::Triangle;
use eikona_mesh::{Edge, Face, Halfedge, TriangleMesh};
use eikona_numeric::{Complex, Graph, NumericError, Scalar, SymmetricMatrix, check_step};
use std::ops::Range;

/// Representation of the vector at an edge, which its faces share.
///
/// In the frame of a halfedge `h`, a tangent vector is a complex number: its real part runs along
/// `h`, its imaginary part into the face of `h`. Implementations store fewer numbers than one per
/// halfedge: see [`ComplexFrames`] and [`RealFrames`]. A field is a vector of
/// [`Value`](EdgeFrames::Value)s, one per unknown, so that a field of one kind can not be read as
/// the other.
pub trait EdgeFrames {
    /// Type of an unknown.
    type Value: Scalar;
    /// Returns the unknowns of an edge.
    fn of_edge(&self, e: Edge) -> Range<usize>;
    /// Returns the number of unknowns.
    fn unknowns(&self) -> usize;
    /// Returns the vector at a halfedge's edge, in the frame of the halfedge.
    fn read(&self, mesh: &TriangleMesh, x: &[Self::Value], h: Halfedge) -> Complex;
    /// Adds a vector in the frame of a halfedge to the unknowns of its edge (the transpose of
    /// [`read`](Self::read)).
    fn add(&self, mesh: &TriangleMesh, x: &mut [Self::Value], h: Halfedge, value: Complex);
    /// Assembles the mass matrix and the connection Laplacian on these unknowns.
    ///
    /// # Errors
    /// [`NumericError::Stopped`].
    fn connection_laplacian(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
    ) -> Result<ConnectionLaplacian<Self::Value>, NumericError>;

    /// Returns a vector of zeros.
    fn zeros(&self) -> Vec<Self::Value> {
        vec![Self::Value::ZERO; self.unknowns()]
    }
    /// Returns the edge of each unknown.
    fn edge_of_unknown(&self, mesh: &TriangleMesh) -> Vec<Edge> {
        mesh.edges().flat_map(|e| self.of_edge(e).map(move |_| e)).collect()
    }
}

/// Frames with one complex unknown per edge (SHM section 5.2): `z_h = z_e` for the halfedge in the
/// direction of the edge, `-z_e` for the other.
#[derive(Clone, Debug)]
pub struct ComplexFrames {
    edges: usize,
}

impl ComplexFrames {
    /// Returns the frames of a consistently oriented mesh; `None` if some edge has more than two
    /// faces, or two faces that traverse it in the same direction.
    pub fn of(mesh: &TriangleMesh) -> Option<ComplexFrames> {
        mesh.is_consistently_oriented().then(|| ComplexFrames { edges: mesh.edge_count() })
    }
}

impl EdgeFrames for ComplexFrames {
    type Value = Complex;
    fn of_edge(&self, e: Edge) -> Range<usize> {
        e.index()..e.index() + 1
    }
    fn unknowns(&self) -> usize {
        self.edges
    }
    #[inline]
    fn read(&self, mesh: &TriangleMesh, x: &[Complex], h: Halfedge) -> Complex {
        let z = x[mesh.edge(h).index()];
        if mesh.follows_edge(h) { z } else { -z }
    }
    #[inline]
    fn add(&self, mesh: &TriangleMesh, x: &mut [Complex], h: Halfedge, value: Complex) {
        x[mesh.edge(h).index()] += if mesh.follows_edge(h) { value } else { -value };
    }
    fn connection_laplacian(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
    ) -> Result<ConnectionLaplacian<Complex>, NumericError> {
        let edges = self.edges;
        let mut graph = Graph { unknowns: edges, pairs: Vec::with_capacity(3 * mesh.face_count()) };
        let mut mass = vec![0.0; edges];
        let mut matrix = SymmetricMatrix {
            diagonal: vec![0.0; edges],
            off_diagonal: Vec::with_capacity(3 * mesh.face_count()),
        };
        for (face, t) in mesh.faces().zip(triangles) {
            check_step(face.index())?;
            let e = mesh.face_edges(face);
            let follows = [0, 1, 2].map(|k| mesh.follows_edge(face.halfedge(k)));
            for k in 0..3 {
                let next = (k + 1) % 3;
                let (a, b) = (e[k], e[next]);
                mass[a.index()] += t.area / 3.0;
                let weight = 2.0 * t.cotangent(next);
                matrix.diagonal[a.index()] += weight;
                matrix.diagonal[b.index()] += weight;
                // z_b = r z_a with r = -s_a s_b exp(i angle) (eq. 8); entry (a, b) is -weight
                // conj(r).
                let sign = if follows[k] == follows[next] { weight } else { -weight };
                graph.pairs.push([a.0, b.0]);
                matrix.off_diagonal.push(t.angles[next].conj() * sign);
            }
        }
        Ok(ConnectionLaplacian { graph, mass, matrix })
    }
}

/// Frames with real unknowns, for every mesh.
///
/// The component along an edge has one unknown, shared by all faces. The component across has one
/// unknown at a boundary edge; one at an edge of two faces (what leaves one face enters the other,
/// whatever their orientation); and `k - 1` at an edge of `k > 2` faces, whose components into the
/// faces sum to zero.
///
/// Deviation: the paper's complex form (and its public code) silently assumes a consistent
/// orientation. This form does not, and treats all faces at a nonmanifold edge alike (tests
/// `flipped_faces_change_nothing`, `fin_on_a_strip`).
#[derive(Clone, Debug)]
pub struct RealFrames {
    /// First unknown of each edge, then the number of unknowns.
    first: Vec<u32>,
}

impl RealFrames {
    /// Returns the frames of any mesh.
    pub fn of(mesh: &TriangleMesh) -> RealFrames {
        RealFrames::where_edges(mesh, |_| true)
    }
    /// Returns the frames of a part of a mesh: only the edges of these faces have unknowns.
    pub fn of_part(mesh: &TriangleMesh, faces: &[Face]) -> RealFrames {
        let mut inside = vec![false; mesh.edge_count()];
        faces.iter().flat_map(|&f| mesh.face_edges(f)).for_each(|e| inside[e.index()] = true);
        RealFrames::where_edges(mesh, |e| inside[e.index()])
    }

    fn where_edges(mesh: &TriangleMesh, wanted: impl Fn(Edge) -> bool) -> RealFrames {
        let mut first = Vec::with_capacity(mesh.edge_count() + 1);
        let mut next = 0u32;
        for e in mesh.edges() {
            first.push(next);
            if wanted(e) {
                next += mesh.edge_halfedges(e).len().max(2) as u32;
            }
        }
        first.push(next);
        RealFrames { first }
    }

    /// Assembles the mass matrix and the connection Laplacian of some faces, whose edges have
    /// unknowns. If only some of the faces at a nonmanifold edge are among these, an unknown may
    /// occur in no equation; its mass and diagonal entry are then zero.
    pub fn connection_laplacian_of(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        faces: impl Iterator<Item = Face>,
    ) -> Result<ConnectionLaplacian<f64>, NumericError> {
        let unknowns = self.unknowns();
        let mut graph = Graph { unknowns, pairs: Vec::new() };
        let mut mass = vec![0.0; unknowns];
        let mut matrix = SymmetricMatrix { diagonal: vec![0.0; unknowns], off_diagonal: Vec::new() };
        let mut terms: Vec<(usize, Complex)> = Vec::new();
        for face in faces {
            check_step(face.index())?;
            let t = &triangles[face.index()];
            for k in 0..3 {
                let (h, next) = (face.halfedge(k), face.halfedge((k + 1) % 3));
                visit_real(mesh, &self.first, h, |unknown, c| mass[unknown] += t.area / 3.0 * c.abs_sq());
                // The energy of this corner is weight |z_next - r z_h|^2 with r = -exp(i angle).
                let weight = 2.0 * t.cotangent((k + 1) % 3);
                let r = -t.angles[(k + 1) % 3];
                terms.clear();
                visit_real(mesh, &self.first, next, |unknown, c| terms.push((unknown, c)));
                visit_real(mesh, &self.first, h, |unknown, c| terms.push((unknown, -(r * c))));
                for (m, &(a, ca)) in terms.iter().enumerate() {
                    matrix.diagonal[a] += weight * ca.abs_sq();
                    for &(b, cb) in &terms[m + 1..] {
                        if a == b {
                            // Both sides of this corner lie on one edge (a face glued to itself).
                            matrix.diagonal[a] += 2.0 * weight * (ca.re * cb.re + ca.im * cb.im);
                        } else {
                            graph.pairs.push([a as u32, b as u32]);
                            matrix.off_diagonal.push(weight * (ca.re * cb.re + ca.im * cb.im));
                        }
                    }
                }
            }
        }
        Ok(ConnectionLaplacian { graph, mass, matrix })
    }
}

impl EdgeFrames for RealFrames {
    type Value = f64;
    fn of_edge(&self, e: Edge) -> Range<usize> {
        self.first[e.index()] as usize..self.first[e.index() + 1] as usize
    }
    fn unknowns(&self) -> usize {
        self.first.last().map_or(0, |&n| n as usize)
    }
    #[inline]
    fn read(&self, mesh: &TriangleMesh, x: &[f64], h: Halfedge) -> Complex {
        let mut z = Complex::ZERO;
        visit_real(mesh, &self.first, h, |unknown, c| z += c * x[unknown]);
        z
    }
    #[inline]
    fn add(&self, mesh: &TriangleMesh, x: &mut [f64], h: Halfedge, value: Complex) {
        visit_real(mesh, &self.first, h, |unknown, c| x[unknown] += c.re * value.re + c.im * value.im);
    }
    fn connection_laplacian(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
    ) -> Result<ConnectionLaplacian<f64>, NumericError> {
        self.connection_laplacian_of(mesh, triangles, mesh.faces())
    }
}

/// Calls `visit` with each real unknown at a halfedge's edge and its coefficient in `z_h`.
#[inline]
fn visit_real(mesh: &TriangleMesh, first: &[u32], h: Halfedge, mut visit: impl FnMut(usize, Complex)) {
    let e = mesh.edge(h);
    let start = first[e.index()] as usize;
    let along = Complex { re: if mesh.follows_edge(h) { 1.0 } else { -1.0 }, im: 0.0 };
    match mesh.edge_halfedges(e) {
        [_] => {
            visit(start, along);
            visit(start + 1, Complex { re: 0.0, im: 1.0 });
        }
        &[a, _] => {
            visit(start, along);
            visit(start + 1, Complex { re: 0.0, im: if a == h { 1.0 } else { -1.0 } });
        }
        halfedges => {
            // Haar's orthonormal basis of the vectors with entries that sum to zero. The faces are
            // bisected recursively, and each bisection has a vector that is positive on one half
            // and negative on the other, so a face occurs in log k bisections only. Unknowns of an
            // edge are eliminated in their order, so there is no fill-in if each bisection is
            // numbered after those of its halves and the unknown along the edge comes last.
            let (place, k) = (halfedges.partition_point(|x| *x < h), halfedges.len());
            let (mut low, mut high, mut number) = (0, k, start);
            while high - low > 1 {
                let middle = (low + high) / 2;
                let (left, right) = ((middle - low) as f64, (high - middle) as f64);
                let entry = if place < middle {
                    (right / (left * (left + right))).sqrt()
                } else {
                    -(left / (right * (left + right))).sqrt()
                };
                visit(number + (high - low) - 2, Complex { re: 0.0, im: entry });
                if place < middle {
                    high = middle;
                } else {
                    number += middle - low - 1;
                    low = middle;
                }
            }
            visit(start + k - 1, along);
        }
    }
}

/// Mass matrix `M` (SHM eq. 7) and connection Laplacian `L` (eq. 9) on the unknowns of
/// [`EdgeFrames`].
///
/// `L` is the Hessian of the Dirichlet energy of a vector field that is linear in each face. It is
/// Hermitian (or symmetric) and positive semidefinite for triangles of any shape; its null space
/// consists of the parallel fields.
#[derive(Debug)]
pub struct ConnectionLaplacian<T> {
    /// Pairs of unknowns with an entry.
    pub graph: Graph,
    /// Diagonal of the mass matrix: a third of the area of the faces at the edge. (At a nonmanifold
    /// edge, differences of these areas couple the components across it; that coupling is dropped,
    /// as in any lumped mass matrix.)
    pub mass: Vec<f64>,
    /// Entries of `L`.
    pub matrix: SymmetricMatrix<T>,
}
