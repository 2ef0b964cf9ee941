//! Steps I and II: diffusion of the normals (SHM eq. 12) over the whole mesh, and normalisation to
//! one unit vector per face.

use crate::geometry::Triangle;
use crate::operators::{ComplexFrames, ConnectionLaplacian, EdgeFrames, RealFrames};
use crate::signed_heat::error::SignedHeatError;
use crate::signed_heat::options::SolveOptions;
use crate::signed_heat::report::NormalConstraints;
use crate::signed_heat::sheets::{Entrance, Sheets};
use crate::signed_heat::source::{Deposit, Source};
use eikona_mesh::{Edge, Face, TriangleMesh};
use eikona_numeric::{
    Cholesky, Complex, CompressedRows, Graph, NumericError, Ordering, Scalar, Symbolic, SymmetricMatrix,
    check_step, check_stopped,
};
use std::sync::Arc;

/// Factored operator `M + t L`, in the form that the mesh needs.
#[derive(Debug)]
pub(crate) enum Diffusion {
    /// For consistently oriented meshes.
    Complex(DiffusionOn<ComplexFrames>),
    /// For any mesh.
    Real(DiffusionOn<RealFrames>),
}

/// Assembled operator, not yet analysed.
pub(crate) enum AssembledDiffusion {
    Complex(AssembledOn<ComplexFrames>),
    Real(AssembledOn<RealFrames>),
}

impl AssembledDiffusion {
    pub fn new(mesh: &TriangleMesh, triangles: &[Triangle]) -> Result<Self, NumericError> {
        Ok(match ComplexFrames::of(mesh) {
            Some(frames) => Self::Complex(AssembledOn::new(mesh, triangles, frames)?),
            None => Self::Real(AssembledOn::new(mesh, triangles, RealFrames::of(mesh))?),
        })
    }

    /// Analyses the operator. `vertex_order` is an elimination order of the vertices.
    pub fn analysed(
        self,
        mesh: &TriangleMesh,
        vertex_order: &[u32],
    ) -> Result<PreparedDiffusion, NumericError> {
        Ok(match self {
            Self::Complex(assembled) => PreparedDiffusion::Complex(assembled.analysed(mesh, vertex_order)?),
            Self::Real(assembled) => PreparedDiffusion::Real(assembled.analysed(mesh, vertex_order)?),
        })
    }
}

/// Analysed operator, not yet factored.
pub(crate) enum PreparedDiffusion {
    Complex(PreparedOn<ComplexFrames>),
    Real(PreparedOn<RealFrames>),
}

impl PreparedDiffusion {
    pub fn predicted_bytes(&self, threads: usize) -> usize {
        match self {
            Self::Complex(prepared) => prepared.symbolic.predicted_bytes::<Complex>(threads),
            Self::Real(prepared) => prepared.symbolic.predicted_bytes::<f64>(threads),
        }
    }
    pub fn factor_bytes(&self) -> usize {
        match self {
            Self::Complex(prepared) => prepared.symbolic.factor_bytes::<Complex>(),
            Self::Real(prepared) => prepared.symbolic.factor_bytes::<f64>(),
        }
    }
    pub fn factor(self, time: f64, threads: usize) -> Result<Diffusion, SignedHeatError> {
        Ok(match self {
            Self::Complex(prepared) => Diffusion::Complex(prepared.factor(time, threads)?),
            Self::Real(prepared) => Diffusion::Real(prepared.factor(time, threads)?),
        })
    }
}

impl Diffusion {
    pub fn is_real(&self) -> bool {
        matches!(self, Self::Real(_))
    }
    pub fn predicted_bytes(&self, threads: usize) -> usize {
        match self {
            Self::Complex(diffusion) => diffusion.factor.symbolic().predicted_bytes::<Complex>(threads),
            Self::Real(diffusion) => diffusion.factor.symbolic().predicted_bytes::<f64>(threads),
        }
    }
    /// Factors the same operator for another time, sharing the symbolic analysis.
    pub fn at(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        time: f64,
        threads: usize,
    ) -> Result<Diffusion, SignedHeatError> {
        Ok(match self {
            Self::Complex(diffusion) => Self::Complex(diffusion.at(mesh, triangles, time, threads)?),
            Self::Real(diffusion) => Self::Real(diffusion.at(mesh, triangles, time, threads)?),
        })
    }
    /// Runs steps I and II, see [`DiffusionOn::unit_field`].
    pub fn unit_field(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        source: &Source,
        options: &SolveOptions,
    ) -> Result<UnitField, SignedHeatError> {
        match self {
            Self::Complex(diffusion) => diffusion.unit_field(mesh, triangles, source, options),
            Self::Real(diffusion) => diffusion.unit_field(mesh, triangles, source, options),
        }
    }
    /// Extends a field into further sheets, see [`DiffusionOn::continue_from`].
    pub fn continue_from(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        sheets: &Sheets,
        entrances: &[Entrance],
        field: &mut UnitField,
    ) -> Result<(), SignedHeatError> {
        match self {
            Self::Complex(diffusion) => diffusion.continue_from(mesh, triangles, sheets, entrances, field),
            Self::Real(diffusion) => diffusion.continue_from(mesh, triangles, sheets, entrances, field),
        }
    }
}

/// Factored operator `M + t L`, with the frames of its unknowns.
#[derive(Debug)]
pub(crate) struct DiffusionOn<F: EdgeFrames> {
    pub(super) frames: F,
    factor: Cholesky<F::Value>,
    mass: Vec<f64>,
    edge_of_unknown: Vec<Edge>,
    pub(super) time: f64,
}

/// Analysed operator, not yet factored.
pub(crate) struct PreparedOn<F: EdgeFrames> {
    frames: F,
    operator: ConnectionLaplacian<F::Value>,
    symbolic: Symbolic,
    edge_of_unknown: Vec<Edge>,
}

/// Assembled operator, not yet analysed.
pub(crate) struct AssembledOn<F: EdgeFrames> {
    frames: F,
    operator: ConnectionLaplacian<F::Value>,
    edge_of_unknown: Vec<Edge>,
}

impl<F: EdgeFrames> AssembledOn<F> {
    fn new(mesh: &TriangleMesh, triangles: &[Triangle], frames: F) -> Result<Self, NumericError> {
        let operator = frames.connection_laplacian(mesh, triangles)?;
        let edge_of_unknown = frames.edge_of_unknown(mesh);
        check_stopped()?;
        Ok(AssembledOn { frames, operator, edge_of_unknown })
    }

    fn analysed(self, mesh: &TriangleMesh, vertex_order: &[u32]) -> Result<PreparedOn<F>, NumericError> {
        let AssembledOn { frames, operator, edge_of_unknown } = self;
        let order = induced_order(mesh, &edge_of_unknown, vertex_order);
        check_stopped()?;
        let symbolic = Symbolic::new(&operator.graph, Ordering::Given(&order))?;
        Ok(PreparedOn { frames, operator, symbolic, edge_of_unknown })
    }
}

impl<F: EdgeFrames> PreparedOn<F> {
    fn factor(self, time: f64, threads: usize) -> Result<DiffusionOn<F>, SignedHeatError> {
        DiffusionOn::new(
            self.frames,
            self.operator,
            self.symbolic.into(),
            self.edge_of_unknown,
            time,
            threads,
        )
    }
}

impl<F: EdgeFrames + Clone> DiffusionOn<F> {
    fn at(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        time: f64,
        threads: usize,
    ) -> Result<Self, SignedHeatError> {
        let operator = self.frames.connection_laplacian(mesh, triangles)?;
        let symbolic = self.factor.symbolic().clone();
        Self::new(self.frames.clone(), operator, symbolic, self.edge_of_unknown.clone(), time, threads)
    }
}

/// Derives an elimination order of edge unknowns from one of vertices: edges are sorted by their
/// earlier end, then by the other.
///
/// If a set of vertices separates two parts of the mesh, the edges between these vertices separate
/// the edges of the parts: no face has corners in both parts, so no face has edges in both. Hence
/// the separators of nested dissection carry over without growing, at a third of the cost of
/// dissecting the edges.
fn induced_order(mesh: &TriangleMesh, edge_of_unknown: &[Edge], vertex_order: &[u32]) -> Vec<u32> {
    let mut place = vec![0u32; vertex_order.len()];
    for (p, &v) in vertex_order.iter().enumerate() {
        place[v as usize] = p as u32;
    }
    let ends = |unknown: u32| {
        let [a, b] = mesh.edge_vertices(edge_of_unknown[unknown as usize]).map(|v| place[v.index()]);
        (a.min(b), a.max(b))
    };
    // Sorted by the later end first, then stably by the earlier one.
    let unknowns = 0..edge_of_unknown.len() as u32;
    let by_later = CompressedRows::new(
        place.len(),
        unknowns.map(|unknown| {
            let (earlier, later) = ends(unknown);
            (later, (earlier, unknown))
        }),
    );
    CompressedRows::new(place.len(), by_later.items().iter().copied()).into_parts().1
}

/// Computes `M + t L` in place.
pub(super) fn mass_plus<T: Scalar>(
    mass: &[f64],
    time: f64,
    mut laplacian: SymmetricMatrix<T>,
) -> SymmetricMatrix<T> {
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

/// Field of unit vectors to which the gradient of the distance is fitted.
#[derive(Debug)]
pub(crate) struct UnitField {
    /// One vector per face, in the layout of the face; zero where no source reaches.
    pub vectors: Vec<Complex>,
    /// Whether a source reaches each face.
    pub reached: Vec<bool>,
    /// Agreement of the three edge vectors of each face: the length of their sum over the sum of
    /// their lengths, 1 where they agree.
    pub agreement: Vec<f64>,
    /// Faces with vectors so short that faces beyond them may not be reached yet.
    frontier: Vec<Face>,
    /// Number of solves.
    pub stages: usize,
    /// Largest relative residual of the solves over the whole mesh; later stages use the same
    /// factor.
    pub residual: f64,
    /// Convergence of the normal constraints, if they were asked for.
    pub normal_constraints: Option<NormalConstraints>,
}

/// Vectors shorter than this share of the longest have lost their relative accuracy, or are about
/// to: the factor drops fill-in below 1e-150.
const SHORTEST: f64 = 1e-130;

/// The next stage starts from faces with vectors at most this many times longer than the shortest.
/// Wherever it matters, what this neglects is smaller by this factor than what it keeps, far below
/// rounding.
const FRONTIER: f64 = 1e25;

impl<F: EdgeFrames> DiffusionOn<F> {
    fn new(
        frames: F,
        operator: ConnectionLaplacian<F::Value>,
        symbolic: Arc<Symbolic>,
        edge_of_unknown: Vec<Edge>,
        time: f64,
        threads: usize,
    ) -> Result<Self, SignedHeatError> {
        let ConnectionLaplacian { graph, mass, matrix } = operator;
        drop::<Graph>(graph);
        let matrix = mass_plus(&mass, time, matrix);
        check_stopped()?;
        let factor = Cholesky::on_threads(symbolic, &matrix, threads)
            .map_err(|fault| at_edge(&edge_of_unknown, fault))?;
        Ok(DiffusionOn { frames, factor, mass, edge_of_unknown, time })
    }

    /// Solves `(M + t L) x = b`.
    pub(super) fn solve(&self, b: &[F::Value]) -> Result<Vec<F::Value>, SignedHeatError> {
        self.factor.solve(b).map_err(|fault| at_edge(&self.edge_of_unknown, fault))
    }

    /// Solves `(M + t L) x = b` at the edges of these faces only.
    fn solve_at(
        &self,
        mesh: &TriangleMesh,
        b: &[F::Value],
        faces: &[Face],
    ) -> Result<Vec<F::Value>, SignedHeatError> {
        let mut wanted = vec![false; mesh.edge_count()];
        for halfedge in faces.iter().flat_map(|f| [0, 1, 2].map(|k| f.halfedge(k))) {
            wanted[mesh.edge(halfedge).index()] = true;
        }
        let wanted = |unknown: usize| wanted[self.edge_of_unknown[unknown].index()];
        self.factor.solve_where(b, wanted).map_err(|fault| at_edge(&self.edge_of_unknown, fault))
    }

    /// Runs steps I and II in stages.
    ///
    /// The diffused vectors shrink by a factor of about 7 per edge (at coefficient 1) and underflow
    /// a few hundred edges away from the source. After each solve, the faces with sufficiently long
    /// vectors are final, and the unit vectors of the farthest of them are the source of the next
    /// solve, which uses the same factor and reaches equally far. Later solves read and normalise
    /// only the remaining faces; elsewhere they only clear the right-hand side and skip what is not
    /// needed.
    ///
    /// Deviation: the paper solves once, and its result is silently flat beyond that distance (test
    /// `strip_of_20000_columns`).
    fn unit_field(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        source: &Source,
        options: &SolveOptions,
    ) -> Result<UnitField, SignedHeatError> {
        let mut field = UnitField {
            vectors: vec![Complex::ZERO; mesh.face_count()],
            reached: vec![false; mesh.face_count()],
            agreement: vec![0.0; mesh.face_count()],
            frontier: Vec::new(),
            stages: 0,
            residual: 0.0,
            normal_constraints: None,
        };
        let mut values = source.values(mesh, &self.frames, triangles, options.sign, self.time);
        check_stopped()?;
        let mut x = self.first_vectors(&mut values, &mut field)?;
        if options.preserve_source_normals {
            let kept;
            (x, kept) = self.preserve_normals(mesh, triangles, source, &values, x)?;
            field.normal_constraints = Some(kept);
        }
        self.read_in_stages(mesh, triangles, x, &mut field)?;
        Ok(field)
    }

    /// Extends a field into unreached sheets from their entrances. No two sheets share an edge, so
    /// one solve serves any number of them.
    fn continue_from(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        sheets: &Sheets,
        entrances: &[Entrance],
        field: &mut UnitField,
    ) -> Result<(), SignedHeatError> {
        let mut deposit = Deposit::new(mesh, &self.frames, triangles);
        for at_vertex in entrances.chunk_by(|a, b| a.vertex == b.vertex) {
            let Entrance { vertex, sign, .. } = at_vertex[0];
            let inside =
                |face: Face| at_vertex.binary_search_by_key(&sheets.of_face(face), |e| e.sheet).is_ok();
            deposit.outward_at_vertex(vertex, sign, inside);
        }
        let mut values = deposit.finish();
        let x = self.first_vectors(&mut values, field)?;
        self.read_in_stages(mesh, triangles, x, field)
    }

    /// Diffuses the values, after scaling them to at most 1.
    fn first_vectors(
        &self,
        values: &mut [F::Value],
        field: &mut UnitField,
    ) -> Result<Vec<F::Value>, SignedHeatError> {
        scale_to_one(values);
        let x = self.solve(values)?;
        check_stopped()?;
        field.residual = field.residual.max(self.factor.relative_residual(&x, values));
        field.stages += 1;
        Ok(x)
    }

    fn read_in_stages(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        mut x: Vec<F::Value>,
        field: &mut UnitField,
    ) -> Result<(), SignedHeatError> {
        let mut unknown: Vec<Face> = mesh.faces().filter(|f| !field.reached[f.index()]).collect();
        loop {
            check_stopped()?;
            field.frontier.clear();
            let before = unknown.len();
            let shortest = SHORTEST * largest_part(&x);
            for (i, face) in std::mem::take(&mut unknown).into_iter().enumerate() {
                check_step(i)?;
                if !self.read_face(mesh, triangles, &x, face, shortest, field) {
                    unknown.push(face);
                }
            }
            if unknown.is_empty() || unknown.len() == before {
                return Ok(());
            }
            check_stopped()?;
            let values = self.next_stage(mesh, triangles, field);
            x = self.solve_at(mesh, &values, &unknown)?;
            field.stages += 1;
        }
    }

    /// Averages the vectors at a face's edges and normalises the mean. Returns false if the vectors
    /// are too short to be distinguished from zero.
    fn read_face(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        x: &[F::Value],
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
            // Scaled first, since the square would underflow.
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

    /// Returns the next right-hand side: unit vectors on the edges of the frontier, times the mass,
    /// scaled to at most 1.
    fn next_stage(&self, mesh: &TriangleMesh, triangles: &[Triangle], field: &UnitField) -> Vec<F::Value> {
        let mut values = self.frames.zeros();
        let mut edges: Vec<Edge> = Vec::with_capacity(3 * field.frontier.len());
        for &face in &field.frontier {
            let directions = triangles[face.index()].directions();
            for k in 0..3 {
                let seen = directions[k].conj() * field.vectors[face.index()];
                self.frames.add(mesh, &mut values, face.halfedge(k), seen);
                edges.push(mesh.edge(face.halfedge(k)));
            }
        }
        edges.sort_unstable();
        edges.dedup();
        let ranges = || edges.iter().map(|&e| self.frames.of_edge(e));
        for range in ranges() {
            let norm = values[range.clone()].iter().map(|v| v.abs_sq()).sum::<f64>().sqrt();
            if norm > 0.0 {
                for i in range {
                    values[i] = values[i].scale(self.mass[i] / norm);
                }
            }
        }
        let largest = ranges().map(|range| largest_part(&values[range])).fold(0.0, f64::max);
        if largest > 0.0 {
            for range in ranges() {
                scale_by(&mut values[range], 1.0 / largest);
            }
        }
        values
    }
}

fn largest_part<T: Scalar>(x: &[T]) -> f64 {
    x.iter().fold(0.0f64, |m, v| m.max(v.max_part()))
}

/// Divides by the largest entry.
fn scale_to_one<T: Scalar>(values: &mut [T]) {
    let largest = largest_part(values);
    if largest > 0.0 {
        scale_by(values, 1.0 / largest);
    }
}

fn scale_by<T: Scalar>(values: &mut [T], factor: f64) {
    values.iter_mut().for_each(|v| *v = v.scale(factor));
}
