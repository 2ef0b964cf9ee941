//! Areas, centroids and second moments of clusters of faces, and derivatives by them passed down to
//! the faces.

use crate::geometry::vector::{add, dot, scale, sub};
use crate::repulsive::faces::FaceDatum;
use crate::spatial::ClusterTree;

/// A symmetric matrix: xx, yy, zz, xy, xz, yz.
pub(crate) type Symmetric = [f64; 6];

/// What the far field knows of a cluster.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moments {
    pub area: f64,
    pub centre: [f64; 3],
    /// The sum of `a_T d d^T`, where `d` leads from the centre to the centroid of T.
    pub second: Symmetric,
}

/// Derivatives of the energy by the moments of a cluster. That by the second moment is a matrix
/// whose product with it, entry by entry over all nine, is the change.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MomentForce {
    pub area: f64,
    pub centre: [f64; 3],
    pub second: Symmetric,
}

impl MomentForce {
    pub fn add(&mut self, other: &MomentForce) {
        self.area += other.area;
        self.centre = add(self.centre, other.centre);
        self.second.iter_mut().zip(other.second).for_each(|(sum, own)| *sum += own);
    }
}

/// Returns the moments of all clusters of faces in the order of the tree.
pub(crate) fn moments_of(tree: &ClusterTree, faces: &[FaceDatum]) -> Vec<Moments> {
    let mut result = vec![Moments::default(); tree.nodes().len()];
    for node in (0..result.len()).rev() {
        result[node] = match tree.children(node) {
            Some(children) => combined(children.map(|child| result[child]).iter()),
            None => {
                let points = faces[tree.nodes()[node].places()].iter();
                let points: Vec<Moments> = points.map(of_face).collect();
                combined(points.iter())
            }
        };
    }
    result
}

fn of_face(face: &FaceDatum) -> Moments {
    Moments { area: face.area, centre: face.centroid, second: [0.0; 6] }
}

fn combined<'a>(parts: impl Iterator<Item = &'a Moments> + Clone) -> Moments {
    let area: f64 = parts.clone().map(|part| part.area).sum();
    let weighted = parts.clone().fold([0.0; 3], |sum, part| add(sum, scale(part.centre, part.area)));
    let centre = scale(weighted, 1.0 / area);
    let mut second = [0.0; 6];
    for part in parts {
        let d = sub(part.centre, centre);
        for ((sum, own), square) in second.iter_mut().zip(part.second).zip(squares(d)) {
            *sum += own + part.area * square;
        }
    }
    Moments { area, centre, second }
}

/// `d d^T`
fn squares([x, y, z]: [f64; 3]) -> Symmetric {
    [x * x, y * y, z * z, x * y, x * z, y * z]
}

fn times([xx, yy, zz, xy, xz, yz]: Symmetric, [x, y, z]: [f64; 3]) -> [f64; 3] {
    [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z]
}

/// Returns the largest distance of a centroid from the centre of each cluster.
pub(crate) fn radii(tree: &ClusterTree, faces: &[FaceDatum], moments: &[Moments]) -> Vec<f64> {
    let radius = |(node, moments): (&crate::spatial::Cluster, &Moments)| {
        let away = |face: &FaceDatum| {
            let d = sub(face.centroid, moments.centre);
            dot(d, d)
        };
        faces[node.places()].iter().map(away).fold(0.0, f64::max).sqrt()
    };
    tree.nodes().iter().zip(moments).map(radius).collect()
}

/// Passes derivatives by the moments of clusters on to the faces, as derivatives by centroid and
/// area.
pub(crate) fn pass_down(
    tree: &ClusterTree,
    faces: &[FaceDatum],
    moments: &[Moments],
    mut forces: Vec<MomentForce>,
    mut to_face: impl FnMut(usize, [f64; 3], f64),
) {
    for node in 0..forces.len() {
        let (force, whole) = (forces[node], moments[node]);
        match tree.children(node) {
            Some(children) => {
                for child in children {
                    let own = part_of(&force, &whole, &moments[child]);
                    forces[child].add(&own);
                }
            }
            None => {
                for place in tree.nodes()[node].places() {
                    let own = part_of(&force, &whole, &of_face(&faces[place]));
                    to_face(place, own.centre, own.area);
                }
            }
        }
    }
}

/// The derivative by the moments of a part, from that by the moments of the whole.
fn part_of(force: &MomentForce, whole: &Moments, part: &Moments) -> MomentForce {
    let d = sub(part.centre, whole.centre);
    let turned = times(force.second, d);
    let share = part.area / whole.area;
    MomentForce {
        area: force.area + dot(force.centre, d) / whole.area + dot(d, turned),
        centre: add(scale(force.centre, share), scale(turned, 2.0 * part.area)),
        second: force.second,
    }
}
