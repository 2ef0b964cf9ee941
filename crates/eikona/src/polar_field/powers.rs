//! The power of each face (PLPF section 4.4): the field in a face is a power of a linear field,
//! high enough for the rotation along its sides.

use crate::polar_field::bevel::{BeveledMesh, Cycle, Rotation};
use crate::polar_field::singularity::Prescribed;
use eikona_mesh::{Face, FaceField};
use eikona_numeric::{
    Cholesky, Graph, NumericError, Ordering, Resources, Symbolic, SymmetricMatrix, nested_dissection_order,
};
use std::f64::consts::PI;
use std::sync::{Arc, OnceLock};

/// Returns the power of each face.
///
/// A singular face has the magnitude of its index; a face at a singular edge or vertex the largest
/// magnitude of these. Other faces interpolate, but have at least the power at which the rotation
/// along every side is below `pi` times it, so that the field has no zero there.
pub(crate) fn powers(
    bevel: &BeveledMesh,
    system: &FaceSystem,
    singularities: &[Prescribed],
    theta: &Rotation,
) -> Result<FaceField<u32>, NumericError> {
    let mesh = &bevel.mesh;
    let mut fixed: FaceField<u32> = FaceField::constant(mesh.face_count(), 0);
    let mut singular = FaceField::constant(mesh.face_count(), false);
    for s in singularities.iter().filter(|s| s.turns != 0) {
        let power = s.turns.unsigned_abs() as u32;
        let mut fix = |f: Face| fixed[f] = fixed[f].max(power);
        match s.cycle {
            Cycle::Face(f) => {
                fix(f);
                singular[f] = true;
            }
            Cycle::Edge(e) => mesh.edge_halfedges(e).iter().for_each(|h| fix(h.face())),
            Cycle::Vertex(v) => mesh.vertex_corners(v).iter().for_each(|c| fix(c.face())),
            Cycle::Boundary(_) => {}
        }
    }
    for s in singularities {
        if let Cycle::Face(f) = s.cycle
            && s.turns != 0
        {
            fixed[f] = s.turns.unsigned_abs() as u32;
        }
    }
    let mut powers = interpolated(bevel, system, &fixed)?;
    for f in mesh.faces().filter(|f| !singular[*f]) {
        let largest = [0, 1, 2].map(|k| theta.split[f.halfedge(k)].abs()).into_iter().fold(0.0, f64::max);
        powers[f] = powers[f].max((largest / PI).floor() as u32 + 1);
    }
    Ok(powers)
}

/// The Laplacian on faces, analysed when it is first needed.
#[derive(Debug)]
pub(crate) struct FaceSystem {
    symbolic: OnceLock<Arc<Symbolic>>,
    resources: Resources,
}

impl FaceSystem {
    pub fn new(resources: Resources) -> FaceSystem {
        FaceSystem { symbolic: OnceLock::new(), resources }
    }

    fn symbolic(&self, bevel: &BeveledMesh) -> Result<Arc<Symbolic>, NumericError> {
        if let Some(symbolic) = self.symbolic.get() {
            return Ok(symbolic.clone());
        }
        let graph = face_graph(bevel);
        let order = face_order(bevel, &graph, self.resources.threads)?;
        let symbolic = Arc::new(Symbolic::new(&graph, Ordering::Given(&order))?);
        Ok(self.symbolic.get_or_init(|| symbolic).clone())
    }
}

/// Interpolates positive values harmonically from faces to their neighbours, and rounds.
fn interpolated(
    bevel: &BeveledMesh,
    system: &FaceSystem,
    fixed: &FaceField<u32>,
) -> Result<FaceField<u32>, NumericError> {
    let mesh = &bevel.mesh;
    let highest = fixed.as_slice().iter().max().copied().unwrap_or(0);
    if highest <= 1 {
        return Ok(FaceField::constant(mesh.face_count(), 1));
    }
    let mut matrix = SymmetricMatrix { diagonal: vec![0.0; mesh.face_count()], off_diagonal: Vec::new() };
    let mut rhs = vec![0.0; mesh.face_count()];
    for (h, twin) in bevel.edges() {
        let [f, g] = [h, twin].map(|h| h.face());
        let area = bevel.triangles[f.index()].area + bevel.triangles[g.index()].area;
        let weight = 3.0 * bevel.triangles[f.index()].lengths[h.side()].powi(2) / area;
        // A fixed face keeps its value and is moved to the right-hand side of its neighbours.
        let free = [f, g].map(|f| fixed[f] == 0);
        matrix.off_diagonal.push(if free == [true, true] { -weight } else { 0.0 });
        for (this, other, is_free) in [(f, g, free[0]), (g, f, free[1])] {
            if is_free {
                matrix.diagonal[this.index()] += weight;
                rhs[this.index()] += weight * f64::from(fixed[other]);
            }
        }
    }
    let mut sourced = vec![false; bevel.topology.components.len()];
    for f in mesh.faces().filter(|f| fixed[*f] > 0) {
        sourced[bevel.component_of(Cycle::Face(f))] = true;
        matrix.diagonal[f.index()] = 1.0;
        rhs[f.index()] = f64::from(fixed[f]);
    }
    // A component without a fixed face has the power 1.
    for (component, _) in bevel.topology.components.iter().zip(&sourced).filter(|(_, sourced)| !**sourced) {
        let f = component.first_face.index();
        let weight = matrix.diagonal[f].max(1.0);
        matrix.diagonal[f] += weight;
        rhs[f] += weight;
    }
    let values = Cholesky::within(system.resources, system.symbolic(bevel)?, &matrix)?.solve(&rhs)?;
    let rounded: Vec<u32> =
        values.into_iter().map(|x| x.round().clamp(1.0, f64::from(highest)) as u32).collect();
    Ok(rounded.into())
}

/// Returns the graph of the faces that share an edge.
pub(crate) fn face_graph(bevel: &BeveledMesh) -> Graph {
    let pairs = bevel.edges().map(|(h, twin)| [h.face().0, twin.face().0]).collect();
    Graph { unknowns: bevel.mesh.face_count(), pairs }
}

/// Orders the faces by nested dissection.
pub(crate) fn face_order(
    bevel: &BeveledMesh,
    graph: &Graph,
    threads: usize,
) -> Result<Vec<u32>, NumericError> {
    let centre = |f: Face| {
        let [a, b, c] = bevel.mesh.face_positions(f);
        [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0)
    };
    let centres: Vec<[f64; 3]> = bevel.mesh.faces().map(centre).collect();
    nested_dissection_order(graph, &centres, threads)
}
