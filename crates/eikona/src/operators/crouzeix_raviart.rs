//! The edge operators of step I: Crouzeix-Raviart mass matrix and connection Laplacian.

use crate::geometry::Triangle;
use eikona_mesh::{Edge, Halfedge, TriangleMesh};
use eikona_numeric::{Complex, Graph, Scalar, SymmetricMatrix};

/// How the faces at an edge share the vector that lives there.
///
/// Seen from a halfedge `h`, a tangent vector is a complex number: its real part runs along `h`, its imaginary part into the
/// face of `h`. What is stored is fewer numbers than one a halfedge:
/// * one complex number an edge, if every edge has at most two faces and these run along it in opposite directions
///   (SHM section 5.2): `z_h = z_e` for the halfedge that follows the edge, `-z_e` for the other;
/// * else reals, as many as needed: one along the edge, shared by all faces, and for the part across the edge one at a
///   boundary, one at an edge of two faces (what leaves one face enters the other, whatever their winding), and `k - 1` at an
///   edge of `k > 2` faces, whose parts into the faces add up to zero.
///
/// Deviation: the paper's complex form (and its public code) silently needs consistent winding; the real form needs none, and treats all
/// faces at a nonmanifold edge alike (tests `flipped_faces_change_nothing`, `fin_on_a_strip`).
#[derive(Debug)]
pub enum EdgeFrames {
    /// One complex unknown an edge.
    Complex,
    /// Real unknowns: those of edge `e` are `first[e]..first[e + 1]`, the one along the edge first.
    Real {
        /// First unknown of each edge, and their number at the end.
        first: Vec<u32>,
    },
}

/// A number per unknown of the edges.
#[derive(Clone, Debug)]
pub enum EdgeVector {
    /// For [`EdgeFrames::Complex`].
    Complex(Vec<Complex>),
    /// For [`EdgeFrames::Real`].
    Real(Vec<f64>),
}

impl EdgeFrames {
    /// The frames of a mesh: complex where its winding is consistent, else real.
    pub fn of(mesh: &TriangleMesh) -> EdgeFrames {
        let consistent = mesh.edges().all(|e| match mesh.edge_halfedges(e) {
            [_] => true,
            &[a, b] => mesh.origin(a) != mesh.origin(b),
            _ => false,
        });
        if consistent { EdgeFrames::Complex } else { EdgeFrames::real(mesh) }
    }

    /// The real form, which works for every mesh.
    pub fn real(mesh: &TriangleMesh) -> EdgeFrames {
        let mut first = Vec::with_capacity(mesh.edge_count() + 1);
        let mut next = 0u32;
        for e in mesh.edges() {
            first.push(next);
            next += mesh.edge_halfedges(e).len().max(2) as u32;
        }
        first.push(next);
        EdgeFrames::Real { first }
    }

    /// Number of unknowns.
    pub fn unknowns(&self, mesh: &TriangleMesh) -> usize {
        match self {
            EdgeFrames::Complex => mesh.edge_count(),
            EdgeFrames::Real { first } => first.last().map_or(0, |&n| n as usize),
        }
    }

    /// The edge that each unknown lives on.
    pub fn edge_of_unknown(&self, mesh: &TriangleMesh) -> Vec<Edge> {
        match self {
            EdgeFrames::Complex => mesh.edges().collect(),
            EdgeFrames::Real { first } => {
                mesh.edges().flat_map(|e| (first[e.index()]..first[e.index() + 1]).map(move |_| e)).collect()
            }
        }
    }

    /// A vector of zeros.
    pub fn zeros(&self, mesh: &TriangleMesh) -> EdgeVector {
        let n = self.unknowns(mesh);
        match self {
            EdgeFrames::Complex => EdgeVector::Complex(vec![Complex::ZERO; n]),
            EdgeFrames::Real { .. } => EdgeVector::Real(vec![0.0; n]),
        }
    }

    /// The vector at a halfedge's edge, seen from the halfedge.
    #[inline]
    pub fn read(&self, mesh: &TriangleMesh, x: &EdgeVector, h: Halfedge) -> Complex {
        let e = mesh.edge(h);
        match (self, x) {
            (EdgeFrames::Complex, EdgeVector::Complex(z)) => {
                if mesh.follows_edge(h) {
                    z[e.index()]
                } else {
                    -z[e.index()]
                }
            }
            (EdgeFrames::Real { first }, EdgeVector::Real(x)) => {
                let mut z = Complex::ZERO;
                visit_real(mesh, first, h, |unknown, c| z += c * x[unknown]);
                z
            }
            _ => Complex::ZERO, // a vector of the other frames: never built
        }
    }

    /// Adds a vector seen from a halfedge to the unknowns of its edge (the transpose of [`read`](Self::read)).
    #[inline]
    pub fn add(&self, mesh: &TriangleMesh, x: &mut EdgeVector, h: Halfedge, value: Complex) {
        let e = mesh.edge(h);
        match (self, x) {
            (EdgeFrames::Complex, EdgeVector::Complex(z)) => {
                if mesh.follows_edge(h) {
                    z[e.index()] += value
                } else {
                    z[e.index()] -= value
                }
            }
            (EdgeFrames::Real { first }, EdgeVector::Real(x)) => {
                visit_real(mesh, first, h, |unknown, c| x[unknown] += c.re * value.re + c.im * value.im);
            }
            _ => {}
        }
    }
}

/// Calls back with each real unknown at a halfedge's edge and its coefficient in `z_h`.
#[inline]
fn visit_real(mesh: &TriangleMesh, first: &[u32], h: Halfedge, mut visit: impl FnMut(usize, Complex)) {
    let e = mesh.edge(h);
    let start = first[e.index()] as usize;
    visit(start, Complex { re: if mesh.follows_edge(h) { 1.0 } else { -1.0 }, im: 0.0 });
    let halfedges = mesh.edge_halfedges(e);
    let k = halfedges.len();
    let place = halfedges.iter().position(|&x| x == h).unwrap_or(0);
    match k {
        1 => visit(start + 1, Complex { re: 0.0, im: 1.0 }),
        2 => visit(start + 1, Complex { re: 0.0, im: if place == 0 { 1.0 } else { -1.0 } }),
        _ => {
            // Haar's orthonormal basis of the vectors whose entries add up to zero: the faces are halved again and again,
            // and each cut has a vector that is positive on one half and negative on the other. A face meets only the
            // log k cuts that it lies in, and the cut before face `middle` is unknown `middle`.
            let (mut low, mut high) = (0, k);
            while high - low > 1 {
                let middle = (low + high) / 2;
                let (left, right) = ((middle - low) as f64, (high - middle) as f64);
                let entry = if place < middle {
                    (right / (left * (left + right))).sqrt()
                } else {
                    -(left / (right * (left + right))).sqrt()
                };
                visit(start + middle, Complex { re: 0.0, im: entry });
                if place < middle {
                    high = middle;
                } else {
                    low = middle;
                }
            }
        }
    }
}

/// Mass matrix `M` (SHM eq. 7) and connection Laplacian `L` (eq. 9) on the unknowns of [`EdgeFrames`].
///
/// `L` is the Hessian of the Dirichlet energy of the vector field that is linear in each face, hence Hermitian (symmetric) and
/// positive semidefinite for triangles of any shape; its null space are the parallel fields.
#[derive(Debug)]
pub struct ConnectionLaplacian {
    /// Which unknowns meet.
    pub graph: Graph,
    /// Diagonal of the mass matrix: a third of the area of the faces at the edge. (At a nonmanifold edge the parts across
    /// it are coupled by differences of these areas; that coupling is left out, as in any lumped mass matrix.)
    pub mass: Vec<f64>,
    /// The entries of `L`.
    pub laplacian: LaplacianEntries,
}

/// The entries of `L`, in the order of the graph.
#[derive(Debug)]
pub enum LaplacianEntries {
    /// For [`EdgeFrames::Complex`].
    Complex(SymmetricMatrix<Complex>),
    /// For [`EdgeFrames::Real`].
    Real(SymmetricMatrix<f64>),
}

impl ConnectionLaplacian {
    /// Assembles both operators.
    pub fn new(mesh: &TriangleMesh, frames: &EdgeFrames, triangles: &[Triangle]) -> ConnectionLaplacian {
        match frames {
            EdgeFrames::Complex => Self::complex(mesh, triangles),
            EdgeFrames::Real { first } => Self::real(mesh, first, triangles),
        }
    }

    fn complex(mesh: &TriangleMesh, triangles: &[Triangle]) -> ConnectionLaplacian {
        let edges = mesh.edge_count();
        let mut graph = Graph { unknowns: edges, pairs: Vec::with_capacity(3 * mesh.face_count()) };
        let mut mass = vec![0.0; edges];
        let mut matrix = SymmetricMatrix {
            diagonal: vec![0.0; edges],
            off_diagonal: Vec::with_capacity(3 * mesh.face_count()),
        };
        for (face, t) in mesh.faces().zip(triangles) {
            let e = mesh.face_edges(face);
            let follows = [0, 1, 2].map(|k| mesh.follows_edge(face.halfedge(k)));
            for k in 0..3 {
                let next = (k + 1) % 3;
                let (a, b) = (e[k], e[next]);
                mass[a.index()] += t.area / 3.0;
                let weight = 2.0 * t.cotangent(next);
                matrix.diagonal[a.index()] += weight;
                matrix.diagonal[b.index()] += weight;
                // z_b = r z_a with r = -s_a s_b exp(i angle) (eq. 8); entry (a, b) is -weight conj(r).
                let sign = if follows[k] == follows[next] { weight } else { -weight };
                graph.pairs.push([a.0, b.0]);
                matrix.off_diagonal.push(t.angles[next].conj() * sign);
            }
        }
        ConnectionLaplacian { graph, mass, laplacian: LaplacianEntries::Complex(matrix) }
    }

    fn real(mesh: &TriangleMesh, first: &[u32], triangles: &[Triangle]) -> ConnectionLaplacian {
        let unknowns = first.last().map_or(0, |&n| n as usize);
        let mut graph = Graph { unknowns, pairs: Vec::new() };
        let mut mass = vec![0.0; unknowns];
        let mut matrix = SymmetricMatrix { diagonal: vec![0.0; unknowns], off_diagonal: Vec::new() };
        let mut terms: Vec<(usize, Complex)> = Vec::new();
        for (face, t) in mesh.faces().zip(triangles) {
            for k in 0..3 {
                let (h, next) = (face.halfedge(k), face.halfedge((k + 1) % 3));
                visit_real(mesh, first, h, |unknown, c| mass[unknown] += t.area / 3.0 * c.abs_sq());
                // The energy of this corner is weight |z_next - r z_h|^2 with r = -exp(i angle).
                let weight = 2.0 * t.cotangent((k + 1) % 3);
                let r = -t.angles[(k + 1) % 3];
                terms.clear();
                visit_real(mesh, first, next, |unknown, c| terms.push((unknown, c)));
                visit_real(mesh, first, h, |unknown, c| terms.push((unknown, -(r * c))));
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
        ConnectionLaplacian { graph, mass, laplacian: LaplacianEntries::Real(matrix) }
    }
}
