//! A rotation with prescribed sums around all cycles and generators (PLPF section 4.3), by
//! elimination along spanning trees.

use crate::polar_field::bevel::{BeveledMesh, Cycle, PerCycle, Rotation};
use crate::polar_field::homology::Homology;
use eikona_numeric::{NumericError, check_step, check_stopped};

/// Returns a rotation with these sums around the cycles and along the generators. It differs from
/// every other one by the differences of a function on corners.
///
/// The sums around the cycles of a component must add up to zero.
///
/// # Errors
/// [`NumericError::Stopped`].
///
/// # Cost
/// O(F) plus the lengths of the generators.
pub(crate) fn particular_rotation(
    bevel: &BeveledMesh,
    homology: &Homology,
    cycles: &PerCycle<f64>,
    generators: &[f64],
) -> Result<Rotation, NumericError> {
    let mesh = &bevel.mesh;
    let mut theta = bevel.zero();
    // A vertex takes what it needs from the quad of one of its edges.
    for v in mesh.vertices().filter(|&v| bevel.loop_of_vertex(v).is_none()) {
        if let Some(corner) = mesh.vertex_corners(v).first() {
            theta.jump[corner.halfedge()] = cycles.vertex[v];
        }
    }
    check_stopped()?;
    // A quad outside of the tree of faces takes it from the face of its first halfedge, a boundary
    // loop from the face it is attached to.
    let mut in_tree = vec![false; mesh.edge_count()];
    homology.entry.iter().flatten().for_each(|&h| in_tree[mesh.edge(h).index()] = true);
    for e in mesh.edges().filter(|e| !in_tree[e.index()]) {
        if let &[a, b] = mesh.edge_halfedges(e) {
            theta.split[a] = -cycles.edge[e] - theta.jump[a] - theta.jump[b];
        }
    }
    for (b, &h) in homology.attachment.iter().enumerate() {
        theta.split[h] = -cycles[Cycle::Boundary(b as u32)];
    }
    check_stopped()?;
    // Leaves first: a face takes it from the quad towards its parent, and that quad from the
    // parent.
    for (step, face) in homology.order.iter().rev().enumerate() {
        check_step(step)?;
        let Some(h) = homology.entry[face.index()] else { continue };
        let twin = bevel.twin[h].expect("the tree crosses interior edges only");
        theta.split[h] = cycles.face[*face] - theta.split[h.next()] - theta.split[h.previous()];
        theta.split[twin] = -cycles.edge[mesh.edge(h)] - theta.jump[h] - theta.jump[twin] - theta.split[h];
    }
    for (generator, wanted) in homology.generators.iter().zip(generators) {
        let missing = wanted - generator.sum(&theta);
        generator.add_dual(missing / generator.period, &mut theta);
    }
    Ok(theta)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::lay_out;
    use crate::polar_field::bevel::wrapped;
    use crate::polar_field::samples::surfaces;
    use eikona_mesh::random::Random;
    use eikona_mesh::{Topology, TriangleMesh};
    use std::f64::consts::TAU;

    fn beveled(mesh: &TriangleMesh) -> BeveledMesh {
        BeveledMesh::new(mesh, Topology::of(mesh), lay_out(mesh))
    }

    #[test]
    fn differences_sum_to_zero_around_cycles_and_generators() {
        for (name, mesh) in surfaces() {
            let bevel = beveled(&mesh);
            let homology = Homology::of(&bevel).unwrap();
            let x: Vec<f64> = (0..mesh.halfedge_count()).map(|i| (i as f64).sin()).collect();
            let differences = bevel.differences(&x);
            let sums = bevel.sums(&differences);
            assert!(bevel.cycles().all(|c| sums[c].abs() < 1e-12), "{name}");
            assert!(homology.generators.iter().all(|g| g.sum(&differences).abs() < 1e-12), "{name}");
        }
    }

    #[test]
    fn curvature_sums_to_the_euler_characteristic_and_is_that_of_the_connection() {
        for (name, mesh) in surfaces() {
            let bevel = beveled(&mesh);
            let homology = Homology::of(&bevel).unwrap();
            let (curvature, connection) = (bevel.curvature(), bevel.connection().unwrap());
            for (i, component) in bevel.topology.components.iter().enumerate() {
                let here = bevel.cycles().filter(|c| bevel.component_of(*c) == i);
                let total: f64 = here.map(|c| curvature[c]).sum();
                let chi = component.euler_characteristic as f64;
                assert!((total - TAU * chi).abs() < 1e-9, "{name}: {total}");
            }
            let sums = bevel.sums(&connection);
            assert!(bevel.cycles().all(|c| wrapped(sums[c] - curvature[c]).abs() < 1e-9), "{name}");
            let handles: u32 = bevel.topology.components.iter().filter_map(|c| c.genus).sum();
            assert_eq!(homology.generators.len(), 2 * handles as usize, "{name}");
            for g in &homology.generators {
                assert!(wrapped(g.sum(&connection) - g.curvature).abs() < 1e-9, "{name}");
            }
        }
    }

    #[test]
    fn duals_are_closed_and_separate_the_generators() {
        for (name, mesh) in surfaces() {
            let bevel = beveled(&mesh);
            let homology = Homology::of(&bevel).unwrap();
            for (i, g) in homology.generators.iter().enumerate() {
                let mut form = bevel.zero();
                g.add_dual(1.0, &mut form);
                let sums = bevel.sums(&form);
                assert!(bevel.cycles().all(|c| sums[c] == 0.0), "{name}");
                assert_eq!(g.period.abs(), 1.0, "{name}");
                for (j, other) in homology.generators.iter().enumerate() {
                    assert_eq!(other.sum(&form), if i == j { g.period } else { 0.0 }, "{name} {i} {j}");
                }
            }
        }
    }

    #[test]
    fn the_rotation_has_the_wanted_sums() {
        let mut random = Random::from_seed(7);
        for (name, mesh) in surfaces() {
            let bevel = beveled(&mesh);
            let homology = Homology::of(&bevel).unwrap();
            let mut wanted = bevel.constant(0.0);
            let cycles: Vec<Cycle> = bevel.cycles().collect();
            for component in 0..bevel.topology.components.len() {
                let mut here = cycles.iter().filter(|c| bevel.component_of(**c) == component);
                let first = *here.next().unwrap();
                for &cycle in here {
                    wanted[cycle] = random.uniform() - 0.5;
                    wanted[first] -= wanted[cycle];
                }
            }
            let along: Vec<f64> = homology.generators.iter().map(|_| random.uniform()).collect();
            let theta = particular_rotation(&bevel, &homology, &wanted, &along).unwrap();
            let sums = bevel.sums(&theta);
            for &cycle in &cycles {
                assert!((sums[cycle] - wanted[cycle]).abs() < 1e-10, "{name} {cycle:?}");
            }
            for (g, wanted) in homology.generators.iter().zip(&along) {
                assert!((g.sum(&theta) - wanted).abs() < 1e-10, "{name}");
            }
        }
    }
}
