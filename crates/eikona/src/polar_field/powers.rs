//! The power of each face (PLPF section 4.4): the field in a face is a power of a linear field,
//! high enough for the rotation along its sides.

use crate::polar_field::bevel::{BeveledMesh, Cycle, Rotation};
use crate::polar_field::singularity::Prescribed;
use eikona_mesh::{Face, FaceField};
use eikona_numeric::{
    Cholesky, Graph, NumericError, Ordering, Resources, Symbolic, SymmetricMatrix, nested_dissection_order,
};
use std::f64::consts::PI;

/// Returns the power of each face.
///
/// A singular face has the magnitude of its index; a face at a singular edge or vertex the largest
/// magnitude of these. Other faces interpolate, but have at least the power at which the rotation
/// along every side is below `pi` times it, so that the field has no zero there.
pub(crate) fn powers(
    bevel: &BeveledMesh,
    singularities: &[Prescribed],
    theta: &Rotation,
    resources: Resources,
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
    let mut powers = interpolated(bevel, &fixed, resources)?;
    for f in mesh.faces().filter(|f| !singular[*f]) {
        let largest = [0, 1, 2].map(|k| theta.split[f.halfedge(k)].abs()).into_iter().fold(0.0, f64::max);
        powers[f] = powers[f].max((largest / PI).floor() as u32 + 1);
    }
    Ok(powers)
}

/// Interpolates positive values harmonically from faces to their neighbours, and rounds.
fn interpolated(
    bevel: &BeveledMesh,
    fixed: &FaceField<u32>,
    resources: Resources,
) -> Result<FaceField<u32>, NumericError> {
    let mesh = &bevel.mesh;
    let highest = fixed.as_slice().iter().max().copied().unwrap_or(0);
    if highest <= 1 {
        return Ok(FaceField::constant(mesh.face_count(), 1));
    }
    let mut graph = Graph { unknowns: mesh.face_count(), pairs: Vec::new() };
    let mut matrix = SymmetricMatrix { diagonal: vec![0.0; mesh.face_count()], off_diagonal: Vec::new() };
    let mut rhs = vec![0.0; mesh.face_count()];
    for (h, twin) in bevel.interior().filter(|(h, twin)| h < twin) {
        let [f, g] = [h, twin].map(|h| h.face());
        let area = bevel.triangles[f.index()].area + bevel.triangles[g.index()].area;
        let weight = 3.0 * bevel.triangles[f.index()].lengths[h.side()].powi(2) / area;
        graph.pairs.push([f.0, g.0]);
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
    for f in mesh.faces() {
        sourced[bevel.component_of(Cycle::Face(f))] |= fixed[f] > 0;
    }
    for f in mesh.faces() {
        if fixed[f] > 0 {
            matrix.diagonal[f.index()] = 1.0;
            rhs[f.index()] = f64::from(fixed[f]);
        }
    }
    // A component without a fixed face has the power 1.
    for (component, _) in bevel.topology.components.iter().zip(&sourced).filter(|(_, sourced)| !**sourced) {
        let f = component.first_face.index();
        let weight = matrix.diagonal[f].max(1.0);
        matrix.diagonal[f] += weight;
        rhs[f] += weight;
    }
    let centre = |f: Face| {
        let [a, b, c] = mesh.face_positions(f);
        [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0)
    };
    let centres: Vec<[f64; 3]> = mesh.faces().map(centre).collect();
    let order = nested_dissection_order(&graph, &centres)?;
    let symbolic = Symbolic::new(&graph, Ordering::Given(&order))?;
    let values = Cholesky::within(resources, symbolic.into(), &matrix)?.solve(&rhs)?;
    let rounded: Vec<u32> =
        values.into_iter().map(|x| x.round().clamp(1.0, f64::from(highest)) as u32).collect();
    Ok(rounded.into())
}
