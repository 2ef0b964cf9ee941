//! Constraints: prescribed quantities, barycentres, and their derivatives by the vertices.

use super::options::{Barycentre, FlowOptions};
use crate::geometry::vector::{cross, dot, norm, scale, sub};
use crate::repulsive::quantity::Quantity;
use eikona_mesh::TriangleMesh;

type Vec3 = [f64; 3];

/// The quantities that are prescribed, each once: those that are kept, and those that grow.
pub(super) fn quantities(options: &FlowOptions) -> Vec<Quantity> {
    let mut all = Vec::new();
    for quantity in options.keep.iter().copied().chain(options.growth.iter().map(|growth| growth.quantity)) {
        if !all.contains(&quantity) {
            all.push(quantity);
        }
    }
    all
}

/// The constraints at a surface: quantities, then three coordinates per component of how far its
/// barycentre is from that of the last component. (The last one is held by a translation.)
pub(super) struct Constraints<'a> {
    pub quantities: &'a [Quantity],
    /// The component of each vertex, for those whose barycentres are held.
    pub components: &'a [u32],
}

impl Constraints<'_> {
    /// The number of components with rows.
    fn component_count(&self) -> usize {
        component_count(self.components).saturating_sub(1)
    }

    /// Returns the values.
    pub fn values(&self, mesh: &TriangleMesh) -> Vec<f64> {
        let mut values: Vec<f64> = self.quantities.iter().map(|quantity| quantity.of(mesh)).collect();
        let centres = component_centres(mesh, self.components);
        if let Some((last, others)) = centres.split_last() {
            values.extend(others.iter().flat_map(|centre| sub(*centre, *last)));
        }
        values
    }

    /// Returns the derivatives by the vertices. Those of barycentres are taken at fixed areas.
    pub fn rows(&self, mesh: &TriangleMesh) -> Vec<Vec<Vec3>> {
        let mut rows: Vec<Vec<Vec3>> = self.quantities.iter().map(|q| q.differential(mesh)).collect();
        let (shares, areas) = vertex_areas(mesh, self.components);
        let last = self.component_count();
        for component in 0..last {
            for k in 0..3 {
                let row = shares.iter().zip(self.components).map(|(share, c)| {
                    let mut own = [0.0; 3];
                    own[k] = match *c as usize {
                        c if c == component => share / areas[component],
                        c if c == last => -share / areas[last],
                        _ => 0.0,
                    };
                    own
                });
                rows.push(row.collect());
            }
        }
        rows
    }

    /// Returns the sizes to which deviations are compared. The volume may be zero.
    pub fn sizes(&self, mesh: &TriangleMesh, targets: &[f64]) -> Vec<f64> {
        let area = Quantity::Area.of(mesh);
        let quantities = self.quantities.iter().zip(targets).map(|(quantity, target)| match quantity {
            Quantity::Area => target.abs(),
            Quantity::Volume => target.abs().max(1e-3 * area.powf(1.5)),
        });
        quantities.chain((0..3 * self.component_count()).map(|_| area.sqrt())).collect()
    }
}

fn component_count(components: &[u32]) -> usize {
    components.iter().filter(|c| **c != u32::MAX).max().map_or(0, |c| *c as usize + 1)
}

/// A third of the faces of each vertex, and the area of each component.
fn vertex_areas(mesh: &TriangleMesh, components: &[u32]) -> (Vec<f64>, Vec<f64>) {
    let mut shares = vec![0.0; components.len()];
    let mut areas = vec![0.0; component_count(components)];
    if !areas.is_empty() {
        for (f, corners) in mesh.faces().zip(mesh.triangles()) {
            let [a, b, c] = mesh.face_positions(f);
            let area = 0.5 * norm(cross(sub(b, a), sub(c, a)));
            corners.iter().for_each(|v| shares[*v as usize] += area / 3.0);
            areas[components[corners[0] as usize] as usize] += area;
        }
    }
    (shares, areas)
}

/// The barycentre of each component.
fn component_centres(mesh: &TriangleMesh, components: &[u32]) -> Vec<Vec3> {
    let (shares, areas) = vertex_areas(mesh, components);
    let mut sums = vec![[0.0; 3]; areas.len()];
    let used = mesh.positions().iter().zip(&shares).zip(components).filter(|(_, c)| **c != u32::MAX);
    for ((p, share), component) in used {
        (0..3).for_each(|k| sums[*component as usize][k] += share * p[k]);
    }
    sums.iter().zip(&areas).map(|(sum, area)| scale(*sum, 1.0 / area)).collect()
}

/// The point that a translation holds: the barycentre of the last component, if there are any, or
/// of the whole.
pub(super) fn held_centre(mesh: &TriangleMesh, components: &[u32]) -> Vec3 {
    component_centres(mesh, components).pop().unwrap_or_else(|| barycentre(mesh))
}

/// Translates motions so that none moves the held point, to first order. The volume of a surface
/// with boundary changes with a translation, so corrections have to know of the one that follows.
pub(super) fn hold_centre(mesh: &TriangleMesh, components: &[u32], motions: &mut [Vec<Vec3>]) {
    let centre = held_centre(mesh, components);
    let last = component_count(components).saturating_sub(1) as u32;
    for motion in motions {
        let (mut change, mut total) = ([0.0; 3], 0.0);
        for corners in mesh.triangles() {
            let corners = corners.map(|v| v as usize);
            if components.get(corners[0]).is_some_and(|component| *component != last) {
                continue;
            }
            let [a, b, c] = corners.map(|v| mesh.positions()[v]);
            let doubled = cross(sub(b, a), sub(c, a));
            let size = norm(doubled);
            let normal = scale(doubled, 1.0 / size);
            let ways = corners.map(|v| motion[v]);
            let sides = [sub(c, b), sub(a, c), sub(b, a)];
            let growth: f64 =
                ways.iter().zip(sides).map(|(way, side)| 0.5 * dot(cross(normal, side), *way)).sum();
            total += 0.5 * size;
            for k in 0..3 {
                let mean = (a[k] + b[k] + c[k]) / 3.0 - centre[k];
                let way = (ways[0][k] + ways[1][k] + ways[2][k]) / 3.0;
                change[k] += 0.5 * size * way + growth * mean;
            }
        }
        let change = scale(change, 1.0 / total);
        motion.iter_mut().for_each(|way| *way = sub(*way, change));
    }
}

/// Adds to a motion the translation of each component along the mean force on it (RS section
/// 7.1.1).
///
/// Deviation: the paper takes the mean of the gradient in L2, whose unit differs from that of the
/// motion. It is taken in a unit of length in which the component has area 1.
pub(super) fn add_translations(
    mesh: &TriangleMesh,
    components: &[u32],
    differential: &[Vec3],
    order: f64,
    motion: &mut [Vec3],
) {
    let (_, areas) = vertex_areas(mesh, components);
    let mut forces = vec![[0.0; 3]; areas.len()];
    for (force, component) in differential.iter().zip(components) {
        if let Some(sum) = forces.get_mut(*component as usize) {
            (0..3).for_each(|k| sum[k] += force[k]);
        }
    }
    for (way, component) in motion.iter_mut().zip(components).filter(|(_, c)| **c != u32::MAX) {
        let component = *component as usize;
        let factor = areas[component].powf(order - 1.0);
        (0..3).for_each(|k| way[k] += factor * forces[component][k]);
    }
}

/// The mean of the surface: of the centroids, weighted by area.
fn barycentre(mesh: &TriangleMesh) -> Vec3 {
    let (mut sum, mut total) = ([0.0; 3], 0.0);
    for f in mesh.faces() {
        let [a, b, c] = mesh.face_positions(f);
        let area = 0.5 * norm(cross(sub(b, a), sub(c, a)));
        total += area;
        (0..3).for_each(|k| sum[k] += area * (a[k] + b[k] + c[k]) / 3.0);
    }
    scale(sum, 1.0 / total)
}

/// Whether the barycentre of the whole surface is held by a translation.
pub(super) fn holds_barycentre(options: &FlowOptions) -> bool {
    options.barycentre == Barycentre::Kept && options.pins.is_empty()
}
