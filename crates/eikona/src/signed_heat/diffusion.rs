//! Steps I and II: diffuse the normals (SHM eq. 12) and make them unit vectors a face, as far from the source as the mesh goes.

use crate::geometry::Triangle;
use crate::operators::{ConnectionLaplacian, EdgeFrames, EdgeVector, LaplacianEntries};
use crate::signed_heat::error::SignedHeatError;
use crate::signed_heat::source::Source;
use eikona_mesh::{CurveKind, Edge, Face, SegmentHost, TriangleMesh};
use eikona_numeric::{Cholesky, Complex, Graph, NumericError, Ordering, Scalar, Symbolic, SymmetricMatrix};

/// The factored operator `M + t L` with the frames of its unknowns.
#[derive(Debug)]
pub(crate) struct Diffusion {
    pub frames: EdgeFrames,
    factor: Factor,
    mass: Vec<f64>,
    edge_of_unknown: Vec<Edge>,
}

#[derive(Debug)]
enum Factor {
    Complex(Cholesky<Complex>),
    Real(Cholesky<f64>),
}

/// The analysed, not yet factored operator.
pub(crate) struct PreparedDiffusion {
    frames: EdgeFrames,
    operator: ConnectionLaplacian,
    symbolic: Symbolic,
    edge_of_unknown: Vec<Edge>,
}

impl PreparedDiffusion {
    /// `vertex_order` is an order of elimination of the vertices.
    pub fn new(
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        vertex_order: &[u32],
    ) -> Result<Self, NumericError> {
        let frames = EdgeFrames::of(mesh);
        let operator = ConnectionLaplacian::new(mesh, &frames, triangles);
        let edge_of_unknown = frames.edge_of_unknown(mesh);
        let order = induced_order(mesh, &edge_of_unknown, vertex_order);
        let symbolic = Symbolic::new(&operator.graph, Ordering::Given(&order))?;
        Ok(PreparedDiffusion { frames, operator, symbolic, edge_of_unknown })
    }

    pub fn predicted_bytes(&self) -> usize {
        match self.operator.laplacian {
            LaplacianEntries::Complex(_) => self.symbolic.predicted_bytes::<Complex>(),
            LaplacianEntries::Real(_) => self.symbolic.predicted_bytes::<f64>(),
        }
    }

    pub fn factor(self, time: f64) -> Result<Diffusion, SignedHeatError> {
        let PreparedDiffusion { frames, operator, symbolic, edge_of_unknown } = self;
        let ConnectionLaplacian { graph, mass, laplacian } = operator;
        drop::<Graph>(graph);
        let at_edge = |fault| at_edge(&edge_of_unknown, fault);
        let factor = match laplacian {
            LaplacianEntries::Complex(entries) => Factor::Complex(
                Cholesky::new(symbolic.into(), &mass_plus(&mass, time, entries)).map_err(at_edge)?,
            ),
            LaplacianEntries::Real(entries) => Factor::Real(
                Cholesky::new(symbolic.into(), &mass_plus(&mass, time, entries)).map_err(at_edge)?,
            ),
        };
        Ok(Diffusion { frames, factor, mass, edge_of_unknown })
    }
}

/// An order of elimination for unknowns on edges from one for vertices: by the end that comes first, then by the other.
///
/// If a set of vertices separates two parts of the mesh, the edges between these vertices separate the edges of the parts: a
/// face has no corners in both parts, so two of its edges in different parts can not meet. So the separators of nested
/// dissection carry over, no larger than before, at a third of the cost of dissecting the edges.
fn induced_order(mesh: &TriangleMesh, edge_of_unknown: &[Edge], vertex_order: &[u32]) -> Vec<u32> {
    let mut place = vec![0u32; vertex_order.len()];
    for (p, &v) in vertex_order.iter().enumerate() {
        place[v as usize] = p as u32;
    }
    let mut keys: Vec<(u32, u32, u32)> = edge_of_unknown
        .iter()
        .enumerate()
        .map(|(unknown, &e)| {
            let [a, b] = mesh.edge_vertices(e).map(|v| place[v.index()]);
            (a.min(b), a.max(b), unknown as u32)
        })
        .collect();
    keys.sort_unstable();
    keys.into_iter().map(|(_, _, unknown)| unknown).collect()
}

/// `M + t L`, in place.
fn mass_plus<T: Scalar>(mass: &[f64], time: f64, mut laplacian: SymmetricMatrix<T>) -> SymmetricMatrix<T> {
    for (d, m) in laplacian.diagonal.iter_mut().zip(mass) {
        *d = m + time * *d;
    }
    for v in &mut laplacian.off_diagonal {
        *v = v.scale(time);
    }
    laplacian
}

fn at_edge(edge_of_unknown: &[Edge], fault: NumericError) -> SignedHeatError {
    match fault {
        NumericError::NonPositivePivot { unknown } | NumericError::NonFinite { unknown, .. } => {
            SignedHeatError::Diffusion { edge: edge_of_unknown[unknown], fault }
        }
        other => other.into(),
    }
}

/// The field of unit vectors that the distance's gradient is fitted to.
#[derive(Debug)]
pub(crate) struct UnitField {
    /// In the layout of each face; zero where no source reaches.
    pub vectors: Vec<Complex>,
    /// Which faces a source reaches.
    pub reached: Vec<bool>,
    /// For each face, length of the sum of its three edges' vectors over the sum of their lengths: 1 where they agree.
    pub agreement: Vec<f64>,
    /// Faces whose vectors were so short that what lies beyond them may not be reached yet.
    frontier: Vec<Face>,
    /// Number of solves.
    pub stages: usize,
    /// Largest relative residual of the solves over the whole mesh; later stages use the same factor.
    pub residual: f64,
}

/// Vectors shorter than this share of the longest have lost their relative accuracy, or are about to: the factor leaves out
/// fill-in below 1e-150.
const SHORTEST: f64 = 1e-130;

/// The next stage starts from faces whose vectors are at most this many times longer than the shortest. What it leaves out is
/// smaller than what it takes by this factor wherever it matters, far below rounding.
const FRONTIER: f64 = 1e25;

impl Diffusion {
    /// `(M + t L) x = b`
    fn solve(&self, b: &EdgeVector) -> Result<EdgeVector, SignedHeatError> {
        let at_edge = |fault| at_edge(&self.edge_of_unknown, fault);
        match (&self.factor, b) {
            (Factor::Complex(factor), EdgeVector::Complex(b)) => {
                factor.solve(b).map(EdgeVector::Complex).map_err(at_edge)
            }
            (Factor::Real(factor), EdgeVector::Real(b)) => {
                factor.solve(b).map(EdgeVector::Real).map_err(at_edge)
            }
            _ => Err(NumericError::WrongLength { found: 0, expected: self.mass.len() }.into()),
        }
    }

    /// The same at the edges of some faces.
    fn solve_at(
        &self,
        mesh: &TriangleMesh,
        b: &EdgeVector,
        faces: &[Face],
    ) -> Result<EdgeVector, SignedHeatError> {
        let mut wanted = vec![false; mesh.edge_count()];
        for halfedge in faces.iter().flat_map(|f| [0, 1, 2].map(|k| f.halfedge(k))) {
            wanted[mesh.edge(halfedge).index()] = true;
        }
        let at_edge = |fault| at_edge(&self.edge_of_unknown, fault);
        let wanted = |unknown: usize| wanted[self.edge_of_unknown[unknown].index()];
        match (&self.factor, b) {
            (Factor::Complex(factor), EdgeVector::Complex(b)) => {
                factor.solve_where(b, wanted).map(EdgeVector::Complex).map_err(at_edge)
            }
            (Factor::Real(factor), EdgeVector::Real(b)) => {
                factor.solve_where(b, wanted).map(EdgeVector::Real).map_err(at_edge)
            }
            _ => Err(NumericError::WrongLength { found: 0, expected: self.mass.len() }.into()),
        }
    }

    fn residual(&self, x: &EdgeVector, b: &EdgeVector) -> f64 {
        match (&self.factor, x, b) {
            (Factor::Complex(factor), EdgeVector::Complex(x), EdgeVector::Complex(b)) => {
                factor.residual(x, b)
            }
            (Factor::Real(factor), EdgeVector::Real(x), EdgeVector::Real(b)) => factor.residual(x, b),
            _ => f64::NAN,
        }
    }

    /// Steps I and II, in stages.
    ///
    /// The diffused vectors shrink by about a factor 7 an edge (at coefficient 1) and vanish in double precision a few hundred
    /// edges away. So after each solve the faces that got a vector are known for good, and the unit vectors of the farthest of
    /// them are the source of the next solve, with the same factor, which reaches as far again. Later solves touch only what
    /// lies beyond.
    ///
    /// Deviation: the paper solves once, and is silently flat beyond (test `strip_of_20000_columns`).
    pub fn unit_field(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        source: &Source,
        values: EdgeVector,
        preserve_normals: bool,
    ) -> Result<UnitField, SignedHeatError> {
        let mut field = UnitField {
            vectors: vec![Complex::ZERO; mesh.face_count()],
            reached: vec![false; mesh.face_count()],
            agreement: vec![0.0; mesh.face_count()],
            frontier: Vec::new(),
            stages: 0,
            residual: 0.0,
        };
        self.continue_field(mesh, triangles, values, &mut field, preserve_normals.then_some(source))?;
        Ok(field)
    }

    /// Extends a field from new values at some edges to all faces that they reach and that are not reached yet.
    pub fn continue_field(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        mut values: EdgeVector,
        field: &mut UnitField,
        preserve: Option<&Source>,
    ) -> Result<(), SignedHeatError> {
        let mut unknown: Vec<Face> = mesh.faces().filter(|f| !field.reached[f.index()]).collect();
        normalise(&mut values);
        let mut x = self.solve(&values)?;
        field.residual = field.residual.max(self.residual(&x, &values));
        if let (0, Some(source)) = (field.stages, preserve) {
            x = self.preserve_normals(mesh, triangles, source, &values, x)?;
        }
        loop {
            field.stages += 1;
            field.frontier.clear();
            let before = unknown.len();
            let shortest = SHORTEST * largest_part(&x);
            unknown.retain(|&face| !self.read_face(mesh, triangles, &x, face, shortest, field));
            if unknown.is_empty() || unknown.len() == before {
                return Ok(());
            }
            values = self.next_stage(mesh, triangles, field);
            normalise(&mut values);
            x = self.solve_at(mesh, &values, &unknown)?;
        }
    }

    /// Averages the vectors at a face's edges and makes them a unit vector, if they are long enough to be told from zero.
    fn read_face(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        x: &EdgeVector,
        face: Face,
        shortest: f64,
        field: &mut UnitField,
    ) -> bool {
        let z = [0, 1, 2].map(|k| self.frames.read(mesh, x, face.halfedge(k)));
        let parts = z.map(|z| z.max_part());
        let longest = parts.into_iter().fold(0.0, f64::max);
        if longest <= shortest {
            return false;
        }
        if parts.into_iter().any(|part| part <= FRONTIER * shortest) {
            field.frontier.push(face);
        }
        let directions = triangles[face.index()].directions();
        let (mut sum, mut lengths) = (Complex::ZERO, 0.0);
        for k in 0..3 {
            // Scaled before squaring, which would underflow.
            let z = z[k].scale(1.0 / longest);
            sum += directions[k] * z;
            lengths += z.abs_sq().sqrt();
        }
        let norm = sum.abs_sq().sqrt();
        field.reached[face.index()] = true;
        if norm > f64::EPSILON * lengths {
            field.vectors[face.index()] = sum.scale(1.0 / norm);
            field.agreement[face.index()] = norm / lengths;
        }
        true
    }

    /// Unit vectors on the edges of the frontier, times the mass.
    fn next_stage(&self, mesh: &TriangleMesh, triangles: &[Triangle], field: &UnitField) -> EdgeVector {
        let mut values = self.frames.zeros(mesh);
        for &face in &field.frontier {
            let directions = triangles[face.index()].directions();
            for k in 0..3 {
                let seen = directions[k].conj() * field.vectors[face.index()];
                self.frames.add(mesh, &mut values, face.halfedge(k), seen);
            }
        }
        match (&mut values, &self.frames) {
            (EdgeVector::Complex(z), _) => {
                for (z, &mass) in z.iter_mut().zip(&self.mass) {
                    let norm = z.abs_sq().sqrt();
                    if norm > 0.0 {
                        *z = z.scale(mass / norm);
                    }
                }
            }
            (EdgeVector::Real(x), EdgeFrames::Real { first }) => {
                for range in first.windows(2).map(|w| w[0] as usize..w[1] as usize) {
                    let norm = x[range.clone()].iter().map(|v| v * v).sum::<f64>().sqrt();
                    if norm > 0.0 {
                        for i in range {
                            x[i] *= self.mass[i] / norm;
                        }
                    }
                }
            }
            _ => {}
        }
        values
    }

    /// The solution among those fields that have no part along the curves (section 7 of the paper's code: "preserve source
    /// normals"): conjugate gradients on the multipliers of one row a segment, with the kept factor inside.
    fn preserve_normals(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        source: &Source,
        values: &EdgeVector,
        free: EdgeVector,
    ) -> Result<EdgeVector, SignedHeatError> {
        let rows = TangentRows::new(mesh, triangles, &self.frames, source);
        let scale = source.segments.len().max(1) as f64;
        let mut multipliers = vec![0.0; rows.rows.len()];
        let mut residual = rows.apply(mesh, &free);
        let mut direction = residual.clone();
        let mut norm: f64 = residual.iter().map(|r| r * r).sum();
        let target = norm * PRESERVE_TOLERANCE * PRESERVE_TOLERANCE;
        for _ in 0..PRESERVE_ITERATIONS {
            if norm <= target || norm <= f64::MIN_POSITIVE * scale {
                break;
            }
            let image = rows.apply(mesh, &self.solve(&rows.transpose(mesh, &direction))?);
            let curvature: f64 = direction.iter().zip(&image).map(|(d, s)| d * s).sum();
            if curvature <= 0.0 {
                break; // only by rounding: rows that say the same
            }
            let step = norm / curvature;
            for i in 0..multipliers.len() {
                multipliers[i] += step * direction[i];
                residual[i] -= step * image[i];
            }
            let next: f64 = residual.iter().map(|r| r * r).sum();
            for i in 0..multipliers.len() {
                direction[i] = residual[i] + next / norm * direction[i];
            }
            norm = next;
        }
        let mut constrained = values.clone();
        match (&mut constrained, rows.transpose(mesh, &multipliers)) {
            (EdgeVector::Complex(b), EdgeVector::Complex(m)) => {
                b.iter_mut().zip(m).for_each(|(b, m)| *b -= m)
            }
            (EdgeVector::Real(b), EdgeVector::Real(m)) => b.iter_mut().zip(m).for_each(|(b, m)| *b -= m),
            _ => {}
        }
        self.solve(&constrained)
    }
}

/// Relative residual at which tangential parts count as gone; each iteration costs one solve.
const PRESERVE_TOLERANCE: f64 = 1e-8;
const PRESERVE_ITERATIONS: usize = 200;

fn largest_part(x: &EdgeVector) -> f64 {
    fn of<T: Scalar>(x: &[T]) -> f64 {
        x.iter().fold(0.0f64, |m, v| m.max(v.max_part()))
    }
    match x {
        EdgeVector::Complex(x) => of(x),
        EdgeVector::Real(x) => of(x),
    }
}

/// Divides by the largest entry.
fn normalise(values: &mut EdgeVector) {
    let largest = largest_part(values);
    if largest > 0.0 {
        match values {
            EdgeVector::Complex(v) => v.iter_mut().for_each(|v| *v = v.scale(1.0 / largest)),
            EdgeVector::Real(v) => v.iter_mut().for_each(|v| *v /= largest),
        }
    }
}

/// One row for each signed segment: the part of the field along it, at its middle.
struct TangentRows<'a> {
    frames: &'a EdgeFrames,
    /// Halfedges with coefficients `c`: the row is the sum of `Re(conj(c) z_h)`.
    rows: Vec<Vec<(eikona_mesh::Halfedge, Complex)>>,
}

impl<'a> TangentRows<'a> {
    fn new(mesh: &TriangleMesh, triangles: &[Triangle], frames: &'a EdgeFrames, source: &Source) -> Self {
        let signed =
            source.segments.iter().zip(&source.kinds).filter(|(_, kind)| **kind == CurveKind::Signed);
        let rows = signed
            .map(|(segment, _)| match segment.host {
                SegmentHost::Edge(edge, _) => {
                    vec![(mesh.edge_halfedges(edge)[0], Complex { re: 1.0, im: 0.0 })]
                }
                SegmentHost::Face(face, [from, to]) => {
                    let t = &triangles[face.index()];
                    let vector = t.point(to) - t.point(from);
                    let tangent = vector.scale(1.0 / vector.norm());
                    let directions = t.directions();
                    (0..3)
                        .map(|k| {
                            // The Crouzeix-Raviart function of side k at the middle of the segment.
                            let opposite = (k + 2) % 3;
                            let value = 1.0 - (from[opposite] + to[opposite]);
                            (face.halfedge(k), directions[k].conj() * tangent.scale(value))
                        })
                        .collect()
                }
            })
            .collect();
        TangentRows { frames, rows }
    }

    fn apply(&self, mesh: &TriangleMesh, x: &EdgeVector) -> Vec<f64> {
        let value = |&(h, c): &(eikona_mesh::Halfedge, Complex)| {
            let z = self.frames.read(mesh, x, h);
            c.re * z.re + c.im * z.im
        };
        self.rows.iter().map(|row| row.iter().map(value).sum()).collect()
    }

    fn transpose(&self, mesh: &TriangleMesh, multipliers: &[f64]) -> EdgeVector {
        let mut values = self.frames.zeros(mesh);
        for (row, &m) in self.rows.iter().zip(multipliers) {
            for &(h, c) in row {
                self.frames.add(mesh, &mut values, h, c.scale(m));
            }
        }
        values
    }
}
