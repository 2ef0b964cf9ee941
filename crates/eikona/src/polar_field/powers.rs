//! The power of each face (PLPF section 4.4): the field in a face is a power of a linear field,
//! high enough for the rotation along its sides.

use crate::polar_field::bevel::{BeveledMesh, Cycle, Rotation};
use crate::polar_field::responses::{Condition, HalfSolutions, Responses};
use crate::polar_field::singularity::Prescribed;
use eikona_mesh::{Face, FaceField, Halfedge};
use eikona_numeric::{
    Cholesky, Graph, NumericError, Ordering, Resources, Symbolic, SymmetricMatrix, check_step, check_stopped,
    nested_dissection_order,
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

/// The Laplacian on faces, analysed and factored when it is first needed.
#[derive(Debug)]
pub(crate) struct FaceSystem {
    symbolic: OnceLock<Arc<Symbolic>>,
    /// The Laplacian, with one face of each component held by [`HELD`].
    factor: OnceLock<Cholesky<f64>>,
    halves: HalfSolutions,
    resources: Resources,
}

/// Weight that holds a face of each component at zero, relative to its diagonal. Values that are
/// rounded to integers may be off by as much.
const HELD: f64 = 1e-6;

/// Most faces whose values are prescribed by a dense system. More of them take a factorisation of
/// their own.
const MOST_FIXED: usize = 400;

impl FaceSystem {
    pub fn new(resources: Resources) -> FaceSystem {
        let (symbolic, factor, halves) = (OnceLock::new(), OnceLock::new(), HalfSolutions::default());
        FaceSystem { symbolic, factor, halves, resources }
    }

    fn symbolic(&self, bevel: &BeveledMesh) -> Result<Arc<Symbolic>, NumericError> {
        if let Some(symbolic) = self.symbolic.get() {
            return Ok(symbolic.clone());
        }
        let graph = face_graph(bevel)?;
        let order = face_order(bevel, &graph, self.resources.threads)?;
        let symbolic = Arc::new(Symbolic::new(&graph, Ordering::Given(&order))?);
        Ok(self.symbolic.get_or_init(|| symbolic).clone())
    }

    fn factor(&self, bevel: &BeveledMesh) -> Result<&Cholesky<f64>, NumericError> {
        if let Some(factor) = self.factor.get() {
            return Ok(factor);
        }
        let mut matrix = laplacian(bevel, |_| true)?;
        for component in &bevel.topology.components {
            let diagonal = &mut matrix.diagonal[component.first_face.index()];
            // A single triangle has no neighbours.
            *diagonal += HELD * diagonal.max(1.0);
        }
        let factor = Cholesky::within(self.resources, self.symbolic(bevel)?, &matrix)?;
        Ok(self.factor.get_or_init(|| factor))
    }

    /// Interpolates harmonically between a few fixed faces, with the kept factor.
    fn between_few(
        &self,
        bevel: &BeveledMesh,
        fixed: impl Iterator<Item = (u32, f64)>,
    ) -> Result<Vec<f64>, NumericError> {
        let condition = |(face, wanted)| Condition { row: vec![(face, 1.0)], wanted, compliance: 0.0 };
        let conditions: Vec<Condition> = fixed.map(condition).collect();
        let responses = Responses::new(self.factor(bevel)?, &self.halves);
        responses.solve(&conditions, &vec![0.0; bevel.mesh.face_count()])
    }

    /// Interpolates harmonically between many fixed faces, with a factor for them.
    fn between_many(&self, bevel: &BeveledMesh, fixed: &FaceField<u32>) -> Result<Vec<f64>, NumericError> {
        let mut matrix = laplacian(bevel, |f| fixed[f] == 0)?;
        let mut rhs = vec![0.0; bevel.mesh.face_count()];
        for (h, twin) in bevel.edges() {
            for (this, other) in [(h, twin), (twin, h)].map(|(h, twin)| (h.face(), twin.face())) {
                if fixed[this] == 0 {
                    rhs[this.index()] += stiffness(bevel, h, twin) * f64::from(fixed[other]);
                }
            }
        }
        let mut sourced = vec![false; bevel.topology.components.len()];
        for f in bevel.mesh.faces().filter(|f| fixed[*f] > 0) {
            sourced[bevel.component_of(Cycle::Face(f))] = true;
            matrix.diagonal[f.index()] = 1.0;
            rhs[f.index()] = f64::from(fixed[f]);
        }
        for (component, _) in bevel.topology.components.iter().zip(&sourced).filter(|(_, sourced)| !**sourced)
        {
            let diagonal = &mut matrix.diagonal[component.first_face.index()];
            *diagonal += diagonal.max(1.0);
        }
        Cholesky::within(self.resources, self.symbolic(bevel)?, &matrix)?.solve(&rhs)
    }
}

/// Interpolates positive values harmonically from faces to their neighbours, and rounds. A
/// component without a fixed face has the power 1.
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
    let held = || mesh.faces().filter(|f| fixed[*f] > 0).map(|f| (f.0, f64::from(fixed[f])));
    let few = if held().count() <= MOST_FIXED { Some(system.between_few(bevel, held())) } else { None };
    check_stopped()?;
    let values = match few {
        Some(Ok(values)) => values,
        // Fixed faces can be too close together for the digits of the kept factor.
        None | Some(Err(NumericError::NonPositivePivot { .. })) => system.between_many(bevel, fixed)?,
        Some(Err(fault)) => return Err(fault),
    };
    let rounded = values.into_iter().map(|x| x.round().clamp(1.0, f64::from(highest)) as u32);
    let of_face = |(power, fixed): (u32, &u32)| if *fixed > 0 { *fixed } else { power };
    Ok(rounded.zip(fixed.as_slice()).map(of_face).collect::<Vec<_>>().into())
}

/// Assembles the Laplacian of the free faces.
fn laplacian(
    bevel: &BeveledMesh,
    is_free: impl Fn(Face) -> bool,
) -> Result<SymmetricMatrix<f64>, NumericError> {
    let diagonal = vec![0.0; bevel.mesh.face_count()];
    let mut matrix = SymmetricMatrix { diagonal, off_diagonal: Vec::new() };
    for (step, (h, twin)) in bevel.edges().enumerate() {
        check_step(step)?;
        let weight = stiffness(bevel, h, twin);
        let free = [h, twin].map(|h| is_free(h.face()));
        matrix.off_diagonal.push(if free == [true, true] { -weight } else { 0.0 });
        for (h, _) in [h, twin].into_iter().zip(free).filter(|(_, is_free)| *is_free) {
            matrix.diagonal[h.face().index()] += weight;
        }
    }
    Ok(matrix)
}

/// Weight of the difference of two faces.
fn stiffness(bevel: &BeveledMesh, h: Halfedge, twin: Halfedge) -> f64 {
    let [own, other] = [h, twin].map(|h| &bevel.triangles[h.face().index()]);
    3.0 * own.lengths[h.side()].powi(2) / (own.area + other.area)
}

/// Returns the graph of the faces that share an edge.
pub(crate) fn face_graph(bevel: &BeveledMesh) -> Result<Graph, NumericError> {
    let mut pairs = Vec::with_capacity(bevel.mesh.edge_count());
    for (step, (h, twin)) in bevel.edges().enumerate() {
        check_step(step)?;
        pairs.push([h.face().0, twin.face().0]);
    }
    Ok(Graph { unknowns: bevel.mesh.face_count(), pairs })
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
    let mut centres = Vec::with_capacity(bevel.mesh.face_count());
    for face in bevel.mesh.faces() {
        check_step(face.index())?;
        centres.push(centre(face));
    }
    nested_dissection_order(graph, &centres, threads)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polar_field::samples::surfaces;
    use crate::polar_field::surface::Surface;
    use eikona_mesh::random::Random;

    #[test]
    fn the_kept_factor_gives_the_values_of_a_factor_for_the_fixed_faces() {
        let mut random = Random::from_seed(3);
        for (name, mesh) in surfaces() {
            let bevel = Surface::of(&mesh).unwrap().bevel;
            let system = FaceSystem::new(Resources::default());
            for _ in 0..5 {
                let mut fixed = FaceField::constant(mesh.face_count(), 0);
                for _ in 0..4 {
                    fixed[Face(random.below(mesh.face_count()) as u32)] = 1 + random.below(4) as u32;
                }
                let held = mesh.faces().filter(|f| fixed[*f] > 0).map(|f| (f.0, f64::from(fixed[f])));
                let few = system.between_few(&bevel, held).unwrap();
                let many = system.between_many(&bevel, &fixed).unwrap();
                let off = few.iter().zip(&many).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                // A component without fixed faces has 0 in one and 1 in the other.
                let components = bevel.topology.components.len();
                assert!(components > 1 || off < 1e-4, "{name}: {off:e}");
            }
        }
    }
}
